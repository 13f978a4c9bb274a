"""Where along a straight leg a body may be nearest: the fractions to try.

Along a line every feature of these bodies has a distance that is a polynomial's root, so the minimum is at one of a
few parameters that can be written down. All of them are tried, and nothing is sampled.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector

LEVEL = 1e-12  # a leg that goes less far than this along an axis does not go along it [m]


class _Body(Protocol):
    def distance(self, points: Points) -> Vector: ...


def straightened(a: Vector, b: Vector) -> Vector:
    """The end b (3,) of a leg, put right so that quotients of steps do not overflow: next to nothing is nothing."""
    return np.where(np.abs(b - a) < LEVEL, a, b)


def least(body: _Body, a: Vector, b: Vector, candidates: Vector) -> tuple[float, float]:
    """The least distance [m] of the leg from a to b at its ends and at `candidates` (n,), and the fraction where."""
    fractions = np.concatenate([[0.0, 1.0], candidates[(candidates > 0) & (candidates < 1)]])
    distances = body.distance(a + fractions[:, None] * (b - a))
    best = int(np.argmin(distances))
    return float(distances[best]), float(fractions[best])


def foot(a: Vector, b: Vector, points: NDArray[np.float64]) -> Vector:
    """Parameters (n,) at which the line from a to b is nearest to points (n, k) or (k,)."""
    square = float((b - a) @ (b - a))
    return np.atleast_1d((points - a) @ (b - a) / square) if square > 0 else np.zeros(0)


def levels(a: Vector, b: Vector, base: float, top: float) -> Vector:
    """Parameters at which the leg passes the base, the top and half-way between."""
    climb = b[2] - a[2]
    return np.array([base - a[2], top - a[2], (base + top) / 2 - a[2]]) / climb if climb != 0 else np.zeros(0)


def derivative(ascending: Vector) -> Vector:
    """Coefficients of a polynomial's derivative, both from the constant on."""
    return np.asarray(ascending[1:] * np.arange(1, len(ascending)))


def roots(ascending: Vector) -> Vector:
    """Real parts of all roots: a double root comes back as a pair that is complex by a rounding error."""
    scale = float(np.abs(ascending).max())
    return (
        np.asarray(np.polynomial.polynomial.polyroots(np.trim_zeros(ascending / scale, "b")).real)
        if scale
        else np.zeros(0)
    )


def upright_distance(aside: Vector, up: Vector, base: float, top: float) -> NDArray[np.float64]:
    """Signed distance (n,) to an upright body, from the signed distance to its plan (n,) and heights (n,) [m]."""
    above = np.maximum(base - up, up - top)
    outside = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(aside, above), 0.0))
