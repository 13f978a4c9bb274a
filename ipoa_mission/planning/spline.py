"""A clamped uniform cubic B-spline, the paper's eqs. (11) and (12), for u in [0, 1]."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Matrix, Points, Vector

DEGREE = 3
ARC_TABLE = 64  # entries per span
LocalBasis = tuple[NDArray[np.intp], Matrix]  # as `local_basis` returns


@dataclass(frozen=True, eq=False, repr=False)
class Spline:
    """A cubic B-spline; `control` is (n, 3) with n >= 4."""

    control: Points

    def __repr__(self) -> str:
        return f"<Spline: {len(self.control)} control points, {self.length:.1f} m>"

    @property
    def spans(self) -> int:
        return len(self.control) - DEGREE

    def points(self, u: Vector, order: int = 0) -> Points:
        """Return points at parameters u (k,), or derivatives by u of the given order, (k, 3)."""
        return self._combined(*local_basis(len(self.control), u, order))

    def even_points(self, count: int) -> Points:
        return self._combined(*_even_local_basis(len(self.control), count))

    def _combined(self, first: NDArray[np.intp], values: Matrix) -> Points:
        return np.asarray(np.einsum("kj,kja->ka", values, self.control[first[:, None] + np.arange(DEGREE + 1)]))

    @cached_property
    def length(self) -> float:
        """Return the arc length [m], by Gauss-Legendre quadrature."""
        local, weights = _quadrature(len(self.control))
        speed = np.linalg.norm(self._combined(*local), axis=1)
        return float(speed @ weights / (2 * self.spans))

    def sample(self, n: int) -> Points:
        return self.points(self.parameters(n))

    def parameters(self, n: int) -> Vector:
        u, traveled = self._arcs
        return np.concatenate([[0.0], np.interp(np.linspace(0.0, traveled[-1], n), traveled, u)[1:-1], [1.0]])

    @cached_property
    def _arcs(self) -> tuple[Vector, Vector]:
        u, *local = _arc_table(len(self.control))
        speed, middle = (np.linalg.norm(self._combined(*at), axis=1) for at in local)
        arcs = (speed[:-1] + 4 * middle + speed[1:]) / 6 * np.diff(u)  # Simpson
        return u, np.concatenate([[0.0], np.cumsum(arcs)])

    def chords(self, tolerance: float) -> Vector:
        """Return parameters (k,) of chords within `tolerance` [m] of the curve, by max |p''| h^2 / 8."""
        knots = np.arange(self.spans + 1) / self.spans
        bend = np.linalg.norm(self.points(knots, order=2), axis=1)
        strongest = np.maximum(bend[:-1], bend[1:])
        count = np.maximum(np.ceil(np.sqrt(strongest / (8 * tolerance)) / self.spans), 1).astype(int)
        pieces = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(knots[:-1], knots[1:], count, strict=True)]
        return np.concatenate([*pieces, [1.0]])

    def refined(self) -> "Spline":
        n = 2 * self.spans + DEGREE
        u = np.linspace(0.0, 1.0, 4 * n)
        control = np.asarray(np.linalg.lstsq(basis(n, u), self.points(u), rcond=None)[0])
        control[[0, -1]] = self.control[[0, -1]]
        return Spline(control)


@lru_cache(maxsize=32)
def _even_local_basis(n: int, count: int) -> LocalBasis:
    return local_basis(n, np.linspace(0.0, 1.0, count))


@lru_cache(maxsize=16)
def _quadrature(n: int) -> tuple[LocalBasis, Vector]:
    """Return the derivative's basis at the nodes of each span, and weights."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    spans = n - DEGREE
    u = (np.arange(spans)[:, None] + (nodes + 1) / 2).ravel() / spans
    return local_basis(n, u, 1), np.tile(weights, spans)


@lru_cache(maxsize=16)
def _arc_table(n: int) -> tuple[Vector, LocalBasis, LocalBasis]:
    """Return parameters, and the derivative's basis there and in the middles."""
    u = np.linspace(0.0, 1.0, (n - DEGREE) * ARC_TABLE + 1)
    return u, local_basis(n, u, 1), local_basis(n, (u[1:] + u[:-1]) / 2, 1)


@lru_cache(maxsize=64)
def even_basis(n: int, count: int) -> NDArray[np.float64]:
    """Return a cached, read-only `basis` at `count` even parameters, (count, n)."""
    values = basis(n, np.linspace(0.0, 1.0, count))
    values.flags.writeable = False
    return values


def basis(n: int, u: Vector) -> NDArray[np.float64]:
    """Return the n basis functions at u (k,), eq. (12), (k, n)."""
    first, nonzero = local_basis(n, u)
    values = np.zeros((len(u), n))
    np.put_along_axis(values, first[:, None] + np.arange(DEGREE + 1), nonzero, axis=1)
    return values


def knots_of(n: int) -> Vector:
    return np.concatenate([np.zeros(DEGREE), np.linspace(0.0, 1.0, n - DEGREE + 1), np.ones(DEGREE)])


def local_basis(n: int, u: Vector, order: int = 0) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the four nonzero basis functions: index of the first (k,) and values (k, 4)."""
    knots = knots_of(n)
    span = np.clip(np.searchsorted(knots, u, side="right") - 1, DEGREE, n - 1)
    values = np.zeros((len(u), DEGREE + 1))
    values[:, -1] = 1.0  # N_i,0
    for k in range(1, DEGREE + 1):
        starts, ends = (knots[span[:, None] + np.arange(1 - k, 1) + shift] for shift in (0, k))
        share = values[:, -k:] / (ends - starts)
        values = np.zeros_like(values)
        if k <= DEGREE - order:
            values[:, -k:] += (u[:, None] - starts) * share
            values[:, -k - 1 : -1] += (ends - u[:, None]) * share
        else:  # differentiated
            values[:, -k:] += k * share
            values[:, -k - 1 : -1] -= k * share
    return span - DEGREE, values
