"""Fractions of a leg at which a body may be nearest: roots of polynomials."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector

LEAST_STEP = 1e-12  # counts as zero [m]


class _Body(Protocol):
    def distance(self, points: Points) -> Vector: ...


def straightened(a: Vector, b: Vector) -> Vector:
    """Remove tiny steps, whose quotients overflow."""
    return np.where(np.abs(b - a) < LEAST_STEP, a, b)


def least(body: _Body, a: Vector, b: Vector, candidates: Vector) -> tuple[float, float]:
    """Return the least distance [m] at the ends and at `candidates` (n,), and its fraction."""
    fractions = np.concatenate([[0.0, 1.0], candidates[(candidates > 0) & (candidates < 1)]])
    distances = body.distance(a + fractions[:, None] * (b - a))
    best = int(np.argmin(distances))
    return float(distances[best]), float(fractions[best])


def foot(a: Vector, b: Vector, points: NDArray[np.float64]) -> Vector:
    """Return parameters (n,) nearest to points."""
    square = float((b - a) @ (b - a))
    return np.atleast_1d((points - a) @ (b - a) / square) if square > 0 else np.zeros(0)


def levels(a: Vector, b: Vector, base: float, top: float) -> Vector:
    """Return parameters at the base, the top and the middle height."""
    climb = b[2] - a[2]
    return np.array([base - a[2], top - a[2], (base + top) / 2 - a[2]]) / climb if climb != 0 else np.zeros(0)


def derivative(ascending: Vector) -> Vector:
    return np.asarray(ascending[1:] * np.arange(1, len(ascending)))


def roots(ascending: Vector) -> Vector:
    """Return real parts: rounding turns a double root into a complex pair."""
    scale = float(np.abs(ascending).max())
    return (
        np.asarray(np.polynomial.polynomial.polyroots(np.trim_zeros(ascending / scale, "b")).real)
        if scale
        else np.zeros(0)
    )


def upright_distance(aside: Vector, up: Vector, base: float, top: float) -> NDArray[np.float64]:
    """Return the signed distance from the plan's, (n,) [m]."""
    above = np.maximum(base - up, up - top)
    outside = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(aside, above), 0.0))
