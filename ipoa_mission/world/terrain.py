"""Kinds of ground, with least heights of legs above it."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, radii_of_curvature
from ipoa_mission.geometry import Points, Vector

Spot: TypeAlias = tuple[float, int, float]  # height [m], leg, fraction


class Terrain(Hashable, Protocol):
    @property
    def steepness(self) -> float:
        """Bound the slope [m/m]."""
        ...

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Return heights [m] (n,) under points (n, 2 or 3)."""
        ...

    def least_height(self, points: Points, enough: float = np.inf) -> Spot:
        """Return the least height above ground of legs, or a bound from `enough` [m] on."""
        ...

    def greatest_height(self, points: Points) -> Spot: ...

    def legs_height(self, starts: Points, ends: Points, enough: float = np.inf) -> Vector:
        """Bound legs' heights above ground (n,) [m]; from `enough` [m] on less exactly."""
        ...


def _end(heights: Vector, i: int) -> Spot:
    leg = min(i, len(heights) - 2)
    return float(heights[i]), leg, float(i - leg)


@dataclass(frozen=True)
class Flat:
    """Level ground.

    Attributes:
        level: height above home [m].

    Example:
        >>> import numpy as np
        >>> Flat(2.0).height(np.array([[10.0, 20.0]]))
        array([2.])
    """

    level: float = 0.0
    steepness: ClassVar[float] = 0.0

    def height(self, points: NDArray[np.float64]) -> Vector:
        return np.full(len(points), self.level)

    def least_height(self, points: Points, enough: float = np.inf) -> Spot:
        """Return the least height of legs between `points`; `enough` has no effect."""
        heights = points[:, 2] - self.level
        return _end(heights, int(np.argmin(heights)))

    def greatest_height(self, points: Points) -> Spot:
        heights = points[:, 2] - self.level
        return _end(heights, int(np.argmax(heights)))

    def legs_height(self, starts: Points, ends: Points, enough: float = np.inf) -> Vector:
        """Return the least heights of legs from `starts` to `ends`, (n,) [m], also beyond `enough`."""
        return np.asarray(np.minimum(starts[:, 2], ends[:, 2]) - self.level)


class SeaLevel(NamedTuple):
    """Constant height AMSL, which falls below home's plane.

    Height: `level` - `east_bend` east^2 - `north_bend` north^2 [1/m], within `reach` [m].
    """

    level: float
    east_bend: float
    north_bend: float
    reach: float

    @classmethod
    def around(cls, home: Geodetic, level: float, reach: float) -> "SeaLevel":
        """Return the ground `level` above home: accurate to 1 cm within 20 km."""
        along, across = radii_of_curvature(home.latitude_deg)
        altitude = home.altitude + level
        return cls(level, 0.5 / (across + altitude), 0.5 / (along + altitude), reach)

    @property
    def drop(self) -> float:
        return max(self.east_bend, self.north_bend) * self.reach**2

    @property
    def steepness(self) -> float:
        return 2 * max(self.east_bend, self.north_bend) * self.reach

    def height(self, points: NDArray[np.float64]) -> Vector:
        return np.asarray(self.level - points[:, :2] ** 2 @ self._bends)

    def least_height(self, points: Points, enough: float = np.inf) -> Spot:
        heights, lowest = self._lowest(points[:-1], points[1:])
        leg = int(np.argmin(heights))
        return float(heights[leg]), leg, float(lowest[leg])

    def legs_height(self, starts: Points, ends: Points, enough: float = np.inf) -> Vector:
        return self._lowest(starts, ends)[0]

    def _lowest(self, starts: Points, ends: Points) -> tuple[Vector, Vector]:
        step = ends - starts
        curvature = step[:, :2] ** 2 @ self._bends
        slope = step[:, 2] + 2 * (starts[:, :2] * step[:, :2]) @ self._bends
        lowest = np.divide(-slope, 2 * curvature, out=np.where(slope < 0, 1.0, 0.0), where=curvature > 0)
        lowest = np.clip(lowest, 0.0, 1.0)
        spots = starts + lowest[:, None] * step
        return np.asarray(spots[:, 2] - self.height(spots)), lowest

    def greatest_height(self, points: Points) -> Spot:
        heights = points[:, 2] - self.height(points)
        return _end(heights, int(np.argmax(heights)))

    @property
    def _bends(self) -> Vector:
        return np.array([self.east_bend, self.north_bend])


@dataclass(frozen=True, eq=False)
class Grid:
    """Regular grid, bilinear, constant beyond its edge.

    `heights[row, column]` is at (`east` + column * `spacing`, `north` + row * `spacing`).
    """

    east: float
    north: float
    spacing: float
    heights: NDArray[np.float64]

    def __post_init__(self) -> None:
        if not self.spacing > 0:
            raise BadInput(f"expected a positive number of meters, not {self.spacing:g}", place="terrain.spacing")
        if self.heights.ndim != 2 or min(self.heights.shape) < 2:
            raise BadInput(f"expected at least 2 x 2 heights, not {self.heights.shape}", place="terrain.heights")
        if not np.isfinite(self.heights).all():
            raise BadInput("expected numbers only, not a missing height", place="terrain.heights")

    @cached_property
    def steepness(self) -> float:
        """Bound each component in a cell by those of its sides."""
        along_north, along_east = (float(np.abs(np.diff(self.heights, axis=axis)).max()) for axis in (0, 1))
        return float(np.hypot(along_north, along_east)) / self.spacing

    def height(self, points: NDArray[np.float64]) -> Vector:
        rows, columns = self.heights.shape
        x = np.clip((points[:, 0] - self.east) / self.spacing, 0.0, columns - 1.0)
        y = np.clip((points[:, 1] - self.north) / self.spacing, 0.0, rows - 1.0)
        column = np.minimum(x.astype(int), columns - 2)
        row = np.minimum(y.astype(int), rows - 2)
        x = x - column
        y = y - row
        south = (1 - x) * self.heights[row, column] + x * self.heights[row, column + 1]
        north = (1 - x) * self.heights[row + 1, column] + x * self.heights[row + 1, column + 1]
        return np.asarray((1 - y) * south + y * north)

    def least_height(self, points: Points, enough: float = np.inf) -> Spot:
        return self._lowest(points, 1.0)

    def legs_height(self, starts: Points, ends: Points, enough: float = np.inf) -> Vector:
        heights, leg, _ = self._candidate_heights(starts, ends, 1.0)
        least = np.full(len(starts), np.inf)
        np.minimum.at(least, leg, heights)
        return least

    def greatest_height(self, points: Points) -> Spot:
        height, leg, fraction = self._lowest(points, -1.0)
        return -height, leg, fraction

    def _lowest(self, points: Points, sign: float) -> Spot:
        heights, leg, fraction = self._candidate_heights(points[:-1], points[1:], sign)
        best = int(np.argmin(heights))
        return float(heights[best]), int(leg[best]), float(fraction[best])

    def _candidate_heights(self, starts: Points, ends: Points, sign: float) -> tuple[Vector, NDArray[np.intp], Vector]:
        """Return heights on legs, their numbers and fractions, (k,) each, including the least of each leg."""
        everywhere = np.arange(len(starts))
        pieces = [(everywhere, np.zeros(len(everywhere))), (everywhere, np.ones(len(everywhere)))]
        pieces += [self._crossings(starts, ends, axis) for axis in (0, 1)]
        leg, fraction = (np.concatenate(column) for column in zip(*pieces, strict=True))
        order = np.lexsort((fraction, leg))
        leg, fraction = leg[order], fraction[order]

        def above(leg: NDArray[np.intp], fraction: Vector) -> Vector:
            spots = starts[leg] + fraction[:, None] * (ends[leg] - starts[leg])
            return np.asarray(sign * (spots[:, 2] - self.height(spots)))

        same = leg[:-1] == leg[1:]
        legs = leg[:-1][same]
        first = fraction[:-1][same]
        last = fraction[1:][same]
        at_first, at_middle, at_last = (above(legs, t) for t in (first, (first + last) / 2, last))
        curvature = at_first - 2 * at_middle + at_last
        bowl = curvature > 0
        lowest = 0.5 + (at_first - at_last)[bowl] / (4 * curvature[bowl])
        vertex = first[bowl] + np.clip(lowest, 0.0, 1.0) * (last - first)[bowl]
        leg = np.concatenate([leg, legs[bowl]])
        fraction = np.concatenate([fraction, vertex])
        return above(leg, fraction), leg, fraction

    def _crossings(self, starts: Points, ends: Points, axis: int) -> tuple[NDArray[np.intp], Vector]:
        start, end = ((points[:, axis] - (self.east, self.north)[axis]) / self.spacing for points in (starts, ends))
        low = np.maximum(np.ceil(np.minimum(start, end)), 0.0)
        high = np.minimum(np.floor(np.maximum(start, end)), self.heights.shape[1 - axis] - 1.0)
        count = np.where(start == end, 0, np.maximum(high - low + 1, 0)).astype(int)
        leg = np.repeat(np.arange(len(count)), count)
        line = low[leg] + np.arange(len(leg)) - np.repeat(np.cumsum(count) - count, count)
        return leg, np.clip((line - start[leg]) / (end - start)[leg], 0.0, 1.0)


class Peak(NamedTuple):
    """Gaussian mountain of eq. (2), wide `a` east and `b` north [m]."""

    height: float
    east: float
    north: float
    a: float
    b: float


@dataclass(frozen=True)
class Analytic:
    """The paper's surface, eqs. (1)-(3)."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float
    g: float
    peaks: tuple[Peak, ...]
    base: float = 0.0

    @cached_property
    def steepness(self) -> float:
        """Bound the slope: exp(-w^2) falls by at most sqrt(2/e) per unit of w."""
        landform = np.hypot(abs(self.b), 1 + abs(self.e + self.g)) + abs(self.c * self.d) + self.f**2
        mountains = sum(abs(p.height) * np.sqrt(2 / np.e) / min(p.a, p.b) for p in self.peaks)
        return float(max(landform, mountains))

    def height(self, points: NDArray[np.float64]) -> Vector:
        return np.maximum(self.landform(points), self.mountains(points))

    def landform(self, points: NDArray[np.float64]) -> Vector:
        x, y = points[:, 0], points[:, 1]
        r = np.hypot(x, y)
        return np.asarray(
            np.sin(y + self.a)
            + self.b * np.sin(x)
            + self.c * np.cos(self.d * r)
            + self.e * np.cos(y)
            + self.f * np.sin(self.f * r)
            + self.g * np.cos(y)
        )

    def mountains(self, points: NDArray[np.float64]) -> Vector:
        height, east, north, a, b = self._numbers[1].T[:, :, None]
        x, y = points[:, 0] - east, points[:, 1] - north
        rises = height * np.exp(-((x / a) ** 2) - (y / b) ** 2)
        return np.asarray(np.vstack([np.full((1, len(points)), self.base), rises]).sum(axis=0))

    @cached_property
    def _numbers(self) -> tuple[tuple[float, ...], NDArray[np.float64]]:
        peaks = np.array([(p.height, p.east, p.north, p.a, p.b) for p in self.peaks], dtype=np.float64).reshape(-1, 5)
        return (self.a, self.b, self.c, self.d, self.e, self.f, self.g, self.base), peaks

    def least_height(self, points: Points, enough: float = np.inf) -> Spot:
        """Bound the height within 0.1 mm."""
        return self._extreme(points, greatest=False, enough=enough)

    def greatest_height(self, points: Points) -> Spot:
        return self._extreme(points, greatest=True)

    def legs_height(self, starts: Points, ends: Points, enough: float = np.inf) -> Vector:
        from ipoa_mission.world._analytic import least_heights

        return np.asarray(least_heights(np.stack([starts, ends], axis=1), *self._numbers, enough))

    def _extreme(self, points: Points, greatest: bool, enough: float = np.inf) -> Spot:
        from ipoa_mission.world._analytic import extreme

        points = np.ascontiguousarray(points, dtype=np.float64)
        height, leg, fraction = extreme(points, *self._numbers, greatest, enough)
        return float(height), int(leg), float(fraction)
