"""Kinds of obstacles, and fractions of a leg at which one may be nearest."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
import shapely
from numpy.polynomial.polynomial import polyder, polyroots
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Plane, Points, Vector
from ipoa_mission.world.obstacles.obstacle import (
    CYLINDER,
    PRISM,
    SPHERE,
    Column,
    GridRow,
    Part,
    Passing,
    distance_of,
    expect_positive,
)
from ipoa_mission.world.polygon import Polygon, Ring, circle, rings_of

LEAST_STEP = 1e-12  # counts as zero [m]


def straightened(a: Vector, b: Vector) -> Vector:
    """Remove tiny steps, whose quotients overflow."""
    return np.where(np.abs(b - a) < LEAST_STEP, a, b)


def least(body: Part, a: Vector, b: Vector, candidates: Vector) -> tuple[float, float]:
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


def roots(ascending: Vector) -> Vector:
    """Return real parts: rounding turns a double root into a complex pair."""
    scale = float(np.abs(ascending).max())
    if not scale:
        return np.zeros(0)
    return np.asarray(polyroots(np.trim_zeros(ascending / scale, "b")).real)


def quadratic_roots(c0: Vector, c1: Vector, c2: Vector) -> Vector:
    flat = np.asarray(c2 == 0)
    root = np.sqrt(np.maximum(c1**2 - 4 * c2 * c0, 0.0))
    q = -0.5 * (c1 + np.copysign(root, c1))
    both: Vector = np.concatenate([q[~flat] / c2[~flat], c0[q != 0] / q[q != 0]])
    return both[np.isfinite(both)]


def upright_distance(aside: Vector, up: Vector, base: float, top: float) -> NDArray[np.float64]:
    return distance_of(aside, np.maximum(base - up, up - top))


def _expect_finite(name: str, *numbers: float) -> None:
    if not np.isfinite(numbers).all():
        raise BadInput(f"expected finite numbers, not {numbers}", place=name)


@dataclass(frozen=True)
class Sphere(Part):
    """A ball.

    Attributes:
        name: in messages.
        center: east, north and up [m].
        radius: above zero [m].

    Example:
        >>> import numpy as np
        >>> Sphere("ball", (50.0, 0.0, 30.0), 10.0).distance(np.array([[30.0, 0.0, 30.0]]))
        array([10.])
    """

    name: str
    center: tuple[float, float, float]
    radius: float
    convex: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _expect_finite(self.name, *self.center, self.radius)
        expect_positive(self.name, "radius", self.radius)

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        return np.array([np.subtract(self.center, self.radius), np.add(self.center, self.radius)])

    @property
    def horizontal_shape(self) -> shapely.Geometry:
        return shapely.Point(self.center[:2]).buffer(self.radius)

    def grown(self, aside: float, below: float, above: float) -> "Sphere":
        return type(self)(self.name, self.center, self.radius + max(aside, below, above))

    def passing(self, a: Points, b: Points) -> Passing:
        """Return distances to the tangent plane nearest to each leg."""
        away = self._away(a, b)
        length = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
        share = (length - self.radius) / length
        up = share * away[:, 2]
        return Passing(share * np.hypot(away[:, 0], away[:, 1]), up, -up, np.ones(len(a)))

    def leg_distances(self, a: Points, b: Points) -> Vector:
        return np.asarray(np.linalg.norm(self._away(a, b), axis=1) - self.radius)

    def _away(self, a: Points, b: Points) -> Points:
        step = b - a
        center = np.asarray(self.center)
        squares = np.maximum((step**2).sum(axis=1), 1e-12)
        along = np.clip(((center - a) * step).sum(axis=1) / squares, 0.0, 1.0)
        return np.asarray(a + along[:, None] * step - center)

    def distance(self, points: Points) -> Vector:
        return np.asarray(np.linalg.norm(points - np.asarray(self.center), axis=1) - self.radius)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        b = straightened(a, b)
        return least(self, a, b, foot(a, b, np.asarray(self.center)))

    def outline(self) -> tuple[Plane, ...]:
        return (circle(*self.center[:2], self.radius),)

    def silhouette(self, axis: int) -> Plane:
        return circle(self.center[axis], self.center[2], self.radius)

    def grid_row(self) -> GridRow:
        east, north, up = self.center
        return GridRow(SPHERE, (east, north, up, self.radius, 0.0), self.radius)


@dataclass(frozen=True)
class Cylinder(Part):
    """A vertical, closed cylinder: a tower, a mast, a tree.

    Attributes:
        name: in messages.
        east: of its axis [m].
        north: of its axis [m].
        radius: above zero [m].
        base: its lowest height [m].
        top: its greatest height [m].

    Example:
        >>> import numpy as np
        >>> mast = Cylinder("mast", east=60.0, north=45.0, radius=8.0, base=0.0, top=60.0)
        >>> mast.distance(np.array([[48.0, 45.0, 30.0]]))
        array([4.])
    """

    name: str
    east: float
    north: float
    radius: float
    base: float
    top: float
    convex: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _expect_finite(self.name, self.east, self.north, self.radius, self.base, self.top)
        expect_positive(self.name, "radius", self.radius)
        expect_positive(self.name, "top - base", self.top - self.base)

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        r = self.radius
        return np.array([[self.east - r, self.north - r, self.base], [self.east + r, self.north + r, self.top]])

    @cached_property
    def column(self) -> Column:
        return Column(shapely.Point(self.east, self.north), self.radius, self.base, self.top)

    def grown(self, aside: float, below: float, above: float) -> "Cylinder":
        return type(self)(self.name, self.east, self.north, self.radius + aside, self.base - below, self.top + above)

    def distance(self, points: Points) -> Vector:
        aside = np.hypot(points[:, 0] - self.east, points[:, 1] - self.north) - self.radius
        return upright_distance(aside, points[:, 2], self.base, self.top)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Solve a quartic for the edge of a cap.

        Let q(t) be the squared distance to the axis and w(t) the height over a cap. The edge is nearest where (q' +
        (w^2)')^2 q = r^2 q'^2. Inside, side and cap balance where q = (r + w)^2.
        """
        b = straightened(a, b)
        axis = np.array([self.east, self.north])
        away = a[:2] - axis
        step = (b - a)[:2]
        q = np.array([away @ away, 2 * away @ step, step @ step])
        candidates = [feet := foot(a[:2], b[:2], axis)]
        nearest = min(1.0, max(0.0, float(feet[0]))) if len(feet) else 0.0
        crosses = bool(q @ [1.0, nearest, nearest**2] <= (1 + 1e-9) * self.radius**2)  # or touches
        if crosses:
            candidates.append(quadratic_roots(*(q - [self.radius**2, 0, 0])[:, None]))
        for height, climb in ((a[2] - self.top, b[2] - a[2]), (self.base - a[2], a[2] - b[2])):
            if not crosses and max(height, height + climb) <= 0:
                continue
            w_squared = np.array([height**2, 2 * height * climb, climb**2])
            slope = polyder(q)
            both = polyder(q + w_squared)
            slope_squared = np.pad(np.convolve(slope, slope), (0, 2))
            quartic = np.convolve(np.convolve(both, both), q) - self.radius**2 * slope_squared
            candidates.append(roots(quartic))
            if crosses:
                balance = q - w_squared - 2 * self.radius * np.array([height, climb, 0]) - [self.radius**2, 0, 0]
                candidates.append(quadratic_roots(*balance[:, None]))
        return least(self, a, b, np.concatenate([*candidates, levels(a, b, self.base, self.top)]))

    def outline(self) -> tuple[Plane, ...]:
        return (circle(self.east, self.north, self.radius),)

    def grid_row(self) -> GridRow:
        return GridRow(CYLINDER, (self.east, self.north, self.radius, self.base, self.top), self.radius)


class RoundZone(Cylinder):
    """A cylinder of forbidden air."""

    solid: ClassVar[bool] = False


@dataclass(frozen=True)
class Prism(Part):
    """An extruded polygon: a building with its courtyards, or a box.

    Attributes:
        name: in messages.
        outer: corners (east, north) [m], in either direction, the first not repeated.
        holes: rings of the same kind inside it.
        base: its lowest height [m].
        top: its greatest height [m].

    Example:
        >>> import numpy as np
        >>> hall = Prism("hall", ((0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (0.0, 20.0)), holes=(), base=0.0, top=12.0)
        >>> hall.distance(np.array([[15.0, 10.0, 15.0], [33.0, 10.0, 5.0]]))
        array([3., 3.])
    """

    name: str
    outer: Ring
    holes: tuple[Ring, ...]
    base: float
    top: float

    def __post_init__(self) -> None:
        _expect_finite(self.name, self.base, self.top)
        expect_positive(self.name, "top - base", self.top - self.base)
        _ = self.footprint  # raises if invalid

    @cached_property
    def footprint(self) -> Polygon:
        try:
            return Polygon(self.outer, self.holes)
        except BadInput as error:
            raise error.at(self.name) from None

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        corners, _ = self.footprint.edges
        return np.array([[*corners.min(axis=0), self.base], [*corners.max(axis=0), self.top]])

    @property
    def convex(self) -> bool:
        return self.footprint.convex

    @cached_property
    def column(self) -> Column:
        return Column(self.footprint.shape, 0.0, self.base, self.top)

    def grown(self, aside: float, below: float, above: float) -> "Prism":
        outer, holes = rings_of(self.footprint.buffered(aside))
        return type(self)(self.name, outer, holes, self.base - below, self.top + above)

    def distance(self, points: Points) -> Vector:
        return upright_distance(self.footprint.distance(points[:, :2]), points[:, 2], self.base, self.top)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        from ipoa_mission.world.obstacles._prism import nearest

        a, b = np.asarray(a, dtype=np.float64), np.asarray(straightened(a, b), dtype=np.float64)
        return nearest(*self.footprint.edges, self.base, self.top, a, b)  # type: ignore[no-any-return]

    def outline(self) -> tuple[Plane, ...]:
        return tuple(np.asarray(ring, float) for ring in (self.outer, *self.holes))

    def grid_row(self) -> GridRow:
        lower, upper = self.bounds
        radius = float(np.hypot(*(upper - lower)[:2])) / 2
        return GridRow(PRISM, (0.0, 0.0, 0.0, self.base, self.top), radius, np.hstack(self.footprint.edges))


class Zone(Prism):
    """A prism of forbidden air."""

    solid: ClassVar[bool] = False
