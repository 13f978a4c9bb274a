"""What stands in the way: spheres, vertical cylinders, prisms on a polygon; each knows its exact distance.

The least distance along a straight leg is found without sampling: along a line every feature of these bodies has a
distance that is a polynomial's root, so the minimum is at one of a few parameters that can be written down. All of
them are tried.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.polygon import Polygon, Ring, quadratic_roots

LEVEL = 1e-12  # a leg that goes less far than this along an axis does not go along it [m]
TOUCHING = 1e-6  # a leg that goes through may have been tried at the walls only [m]


class Obstacle(Protocol):
    """A closed body with a name."""

    @property
    def name(self) -> str:
        """What messages call it."""
        ...

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The box around it, (2, 3): lower and upper corner [m]."""
        ...

    @property
    def convex(self) -> bool:
        """Whether it is convex; then distance along a straight leg is a convex function."""
        ...

    def distance(self, points: Points) -> Vector:
        """Euclidean distance of points (n, 3) to the surface, (n,) [m]: negative inside."""
        ...

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least signed distance [m] of the straight leg from a to b, and the fraction of the leg where it is."""
        ...


@dataclass(frozen=True)
class Sphere:
    """A ball."""

    name: str
    center: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        _expect_positive(self.name, "radius", self.radius)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The box around it, (2, 3)."""
        return np.array([np.subtract(self.center, self.radius), np.add(self.center, self.radius)])

    @property
    def convex(self) -> bool:
        """It is."""
        return True

    def distance(self, points: Points) -> Vector:
        """Signed distance of points (n, 3), (n,)."""
        return np.asarray(np.linalg.norm(points - np.asarray(self.center), axis=1) - self.radius)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least signed distance of the leg, and where."""
        b = straightened(a, b)
        return _least(self, a, b, _foot(a, b, np.asarray(self.center)))


@dataclass(frozen=True)
class Cylinder:
    """A vertical, closed cylinder from `base` to `top` around (`east`, `north`)."""

    name: str
    east: float
    north: float
    radius: float
    base: float
    top: float

    def __post_init__(self) -> None:
        _expect_positive(self.name, "radius", self.radius)
        _expect_positive(self.name, "top - base", self.top - self.base)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The box around it, (2, 3)."""
        r = self.radius
        return np.array([[self.east - r, self.north - r, self.base], [self.east + r, self.north + r, self.top]])

    @property
    def convex(self) -> bool:
        """It is."""
        return True

    def distance(self, points: Points) -> Vector:
        """Signed distance of points (n, 3), (n,)."""
        aside = np.hypot(points[:, 0] - self.east, points[:, 1] - self.north) - self.radius
        return _upright(aside, points[:, 2], self.base, self.top)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least signed distance of the leg, and where.

        With q(t) the squared distance to the axis and w(t) the height over a cap, the rim is nearest where
        (q' + (w^2)')^2 q = r^2 q'^2, a quartic; deep inside, side and cap balance where q = (r + w)^2.
        """
        b = straightened(a, b)
        axis = np.array([self.east, self.north])
        away, step = a[:2] - axis, (b - a)[:2]
        q = np.array([away @ away, 2 * away @ step, step @ step])
        candidates = [_foot(a[:2], b[:2], axis), quadratic_roots(*(q - [self.radius**2, 0, 0])[:, None])]
        for height, climb in ((a[2] - self.top, b[2] - a[2]), (self.base - a[2], a[2] - b[2])):
            w_squared = np.array([height**2, 2 * height * climb, climb**2])
            slope, both = _derivative(q), _derivative(q + w_squared)
            quartic = np.convolve(np.convolve(both, both), q) - self.radius**2 * np.pad(
                np.convolve(slope, slope), (0, 2)
            )
            balance = q - w_squared - 2 * self.radius * np.array([height, climb, 0]) - [self.radius**2, 0, 0]
            candidates += [_roots(quartic), quadratic_roots(*balance[:, None])]
        return _least(self, a, b, np.concatenate([*candidates, _levels(a, b, self.base, self.top)]))


@dataclass(frozen=True)
class Prism:
    """A polygon footprint with holes, extruded from `base` to `top`: a building with its courtyards. A box is one."""

    name: str
    outer: Ring
    holes: tuple[Ring, ...]
    base: float
    top: float

    def __post_init__(self) -> None:
        _expect_positive(self.name, "top - base", self.top - self.base)
        _ = self.footprint  # built now, so that a wrong one is refused now

    @cached_property
    def footprint(self) -> Polygon:
        """The ground plan."""
        try:
            return Polygon(self.outer, self.holes)
        except BadInput as error:
            raise BadInput(f"{self.name}: {error}") from None

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The box around it, (2, 3)."""
        corners = self.footprint.starts
        return np.array([[*corners.min(axis=0), self.base], [*corners.max(axis=0), self.top]])

    @property
    def convex(self) -> bool:
        """Whether the footprint is, and has no holes."""
        return self.footprint.convex

    def distance(self, points: Points) -> Vector:
        """Signed distance of points (n, 3), (n,)."""
        return _upright(self.footprint.distance(points[:, :2]), points[:, 2], self.base, self.top)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least signed distance of the leg, and where."""
        b = straightened(a, b)
        corners, edges = self.footprint.starts, self.footprint.ends - self.footprint.starts
        candidates = [self.footprint.break_parameters(a[:2], b[:2]), _levels(a, b, self.base, self.top)]
        for level in (self.base, self.top):
            rim = np.column_stack([corners, np.full(len(corners), level)])
            candidates += [_foot(a, b, rim), _closest_approach(a, b, rim, np.pad(edges, ((0, 0), (0, 1))))]
        least, where = _least(self, a, b, np.concatenate(candidates))
        if least > TOUCHING:
            return least, where
        height, climb = a[2] - np.array([self.base, self.top]), b[2] - a[2]
        caps = np.column_stack([height**2, 2 * height * climb, np.full(2, climb**2)])
        inner = self.footprint.balance_parameters(a[:2], b[:2], caps, inside=True)
        return min((least, where), _least(self, a, b, inner))


class Zone(Prism):
    """A prism of air that may not be entered, in which nothing stands."""


def box(name: str, lower: tuple[float, float, float], upper: tuple[float, float, float]) -> Prism:
    """A box along the axes, as a prism."""
    (e0, n0, base), (e1, n1, top) = lower, upper
    return Prism(name, ((e0, n0), (e1, n0), (e1, n1), (e0, n1)), (), base, top)


def straightened(a: Vector, b: Vector) -> Vector:
    """The end b of a leg, put right so that quotients of steps do not overflow: what is next to nothing is nothing."""
    return np.where(np.abs(b - a) < LEVEL, a, b)


def _upright(aside: Vector, up: Vector, base: float, top: float) -> Vector:
    """Signed distance to an upright body, from the signed distance to its footprint."""
    above = np.maximum(base - up, up - top)
    outside = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(aside, above), 0.0))


def _least(body: Obstacle, a: Vector, b: Vector, candidates: Vector) -> tuple[float, float]:
    fractions = np.concatenate([[0.0, 1.0], candidates[(candidates > 0) & (candidates < 1)]])
    distances = body.distance(a + fractions[:, None] * (b - a))
    best = int(np.argmin(distances))
    return float(distances[best]), float(fractions[best])


def _foot(a: Vector, b: Vector, points: NDArray[np.float64]) -> Vector:
    """Parameters at which the line from a to b is nearest to points (n, k) or (k,)."""
    square = float((b - a) @ (b - a))
    return np.atleast_1d((points - a) @ (b - a) / square) if square > 0 else np.zeros(0)


def _closest_approach(a: Vector, b: Vector, starts: Points, along: Points) -> Vector:
    """Parameters at which the line from a to b is nearest to lines in space; parallel ones are left out."""
    step, away = b - a, starts - a
    square, mixed, edge = step @ step, along @ step, np.einsum("mk,mk->m", along, along)
    determinant = square * edge - mixed**2
    skew = determinant > 0
    return np.asarray(((away @ step) * edge - np.einsum("mk,mk->m", away, along) * mixed)[skew] / determinant[skew])


def _levels(a: Vector, b: Vector, base: float, top: float) -> Vector:
    """Parameters at which the leg passes the base, the top and half-way between."""
    climb = b[2] - a[2]
    return np.array([base - a[2], top - a[2], (base + top) / 2 - a[2]]) / climb if climb != 0 else np.zeros(0)


def _derivative(ascending: Vector) -> Vector:
    return np.asarray(ascending[1:] * np.arange(1, len(ascending)))


def _roots(ascending: Vector) -> Vector:
    """Real parts of all roots: a double root comes back as a pair that is complex by a rounding error."""
    scale = float(np.abs(ascending).max())
    return (
        np.asarray(np.polynomial.polynomial.polyroots(np.trim_zeros(ascending / scale, "b")).real)
        if scale
        else np.zeros(0)
    )


def _expect_positive(name: str, what: str, value: float) -> None:
    if not value > 0:
        raise BadInput(f"{name}.{what}: expected a positive number of metres, not {value:g}")
