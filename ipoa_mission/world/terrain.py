"""The ground: its height everywhere, and the least height of a straight leg above it, exactly.

Above the ground means vertically above: `height` and `leg_clearance` know nothing of slopes.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Vector

REFINED = 1e-4  # the bound on an analytic surface is closed to this [m]


class Terrain(Protocol):
    """Anything with a height over the plane."""

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Height of the ground [m] under points (n, 2) or (n, 3) east, north(, up), (n,)."""
        ...

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least height [m] of the straight leg from a to b above the ground, and the fraction of it where that is."""
        ...


@dataclass(frozen=True)
class Flat:
    """Level ground."""

    level: float = 0.0

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Height under points (n, 2 or 3), (n,)."""
        return np.full(len(points), self.level)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least height of the leg above the ground, and where."""
        return float(min(a[2], b[2]) - self.level), float(b[2] < a[2])


@dataclass(frozen=True, eq=False)
class Grid:
    """Heights on a regular grid, bilinear between its nodes; beyond its edge the height at the edge goes on.

    `heights[row, column]` belongs to (`east` + column * `spacing`, `north` + row * `spacing`).
    """

    east: float
    north: float
    spacing: float
    heights: NDArray[np.float64]

    def __post_init__(self) -> None:
        if not self.spacing > 0:
            raise BadInput(f"terrain.spacing: expected a positive number of metres, not {self.spacing:g}")
        if self.heights.ndim != 2 or min(self.heights.shape) < 2:
            raise BadInput(f"terrain.heights: expected at least 2 x 2 heights, not {self.heights.shape}")
        if not np.isfinite(self.heights).all():
            raise BadInput("terrain.heights: expected numbers only, not a missing height")

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Height under points (n, 2 or 3), (n,)."""
        rows, columns = self.heights.shape
        x = np.clip((points[:, 0] - self.east) / self.spacing, 0.0, columns - 1.0)
        y = np.clip((points[:, 1] - self.north) / self.spacing, 0.0, rows - 1.0)
        column, row = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
        x, y = x - column, y - row
        south = (1 - x) * self.heights[row, column] + x * self.heights[row, column + 1]
        north = (1 - x) * self.heights[row + 1, column] + x * self.heights[row + 1, column + 1]
        return np.asarray((1 - y) * south + y * north)

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """Least height of the leg above the ground, and where: in each cell it is a quadratic of the fraction."""
        cuts = np.concatenate([[0.0, 1.0], self._crossings(a, b, 0), self._crossings(a, b, 1)])
        cuts = np.sort(cuts[(cuts >= 0) & (cuts <= 1)])
        first, last = cuts[:-1], cuts[1:]
        at_first, at_middle, at_last = (self._above(a, b, t) for t in (first, (first + last) / 2, last))
        curvature = at_first - 2 * at_middle + at_last
        bowl = curvature > 0
        lowest = 0.5 + (at_first - at_last)[bowl] / (4 * curvature[bowl])
        vertices = first[bowl] + np.clip(lowest, 0.0, 1.0) * (last - first)[bowl]
        fractions = np.concatenate([cuts, vertices])
        heights = self._above(a, b, fractions)
        best = int(np.argmin(heights))
        return float(heights[best]), float(fractions[best])

    def _above(self, a: Vector, b: Vector, fractions: Vector) -> Vector:
        points = a + fractions[:, None] * (b - a)
        return np.asarray(points[:, 2] - self.height(points))

    def _crossings(self, a: Vector, b: Vector, axis: int) -> Vector:
        """Fractions at which the leg crosses the grid lines of one axis."""
        origin, count = (self.east, self.north)[axis], self.heights.shape[1 - axis]
        low, high = sorted(((a[axis] - origin) / self.spacing, (b[axis] - origin) / self.spacing))
        lines = np.arange(max(np.ceil(low), 0.0), min(np.floor(high), count - 1.0) + 1.0)
        return (origin + lines * self.spacing - a[axis]) / (b[axis] - a[axis]) if high > low else np.zeros(0)


@dataclass(frozen=True)
class Peak:
    """One Gaussian mountain of eq. (2): its height, its centre, and its slopes a and b along east and north [m]."""

    height: float
    east: float
    north: float
    a: float
    b: float


@dataclass(frozen=True)
class Analytic:
    """The paper's surface, eqs. (1)-(3): the higher of a rolling base landform and a range of Gaussian peaks."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float
    g: float
    peaks: tuple[Peak, ...]
    base: float = 0.0

    def height(self, points: NDArray[np.float64]) -> Vector:
        """Height under points (n, 2 or 3), (n,): eq. (3)."""
        return np.maximum(self.landform(points), self.mountains(points))

    def landform(self, points: NDArray[np.float64]) -> Vector:
        """Eq. (1)."""
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
        """Eq. (2)."""
        x, y = points[:, 0], points[:, 1]
        total = np.full(len(points), self.base)
        for p in self.peaks:
            total += p.height * np.exp(-(((x - p.east) / p.a) ** 2) - ((y - p.north) / p.b) ** 2)
        return total

    def leg_clearance(self, a: Vector, b: Vector) -> tuple[float, float]:
        """A height [m] that the leg nowhere goes below, within 0.1 mm of the least one, and where that is.

        If the height above a surface bends upwards by at most m along the leg, then over a span s it stays above the
        lower end minus m s^2 / 8; spans that might go lower than the lowest end found are halved.
        """
        hollow_landform, hollow_mountains = self._bends(b - a)
        return min(
            _bound_and_refine(self.landform, a, b, hollow_landform),
            _bound_and_refine(self.mountains, a, b, hollow_mountains),
        )

    def _bends(self, step: Vector) -> tuple[float, float]:
        """How strongly, at most, landform and mountains arch upwards along a leg, per squared fraction of it.

        c cos(d r) bends by at most |c| d^2 in any direction and f sin(f r) arches by at most |f|^3 (its kink at the
        origin is hollow); a Gaussian exp(-w^2) has second derivatives between -2 and 4 exp(-3/2).
        """
        east, north, run = step[0] ** 2, step[1] ** 2, step[0] ** 2 + step[1] ** 2
        waves = abs(self.b) * east + (1 + abs(self.e + self.g)) * north
        rings = (abs(self.c) * self.d**2 + abs(self.f) ** 3) * run
        domes = sum(
            (2 * p.height if p.height > 0 else -4 * np.exp(-1.5) * p.height) * (east / p.a**2 + north / p.b**2)
            for p in self.peaks
        )
        return float(waves + rings), float(domes)


def _bound_and_refine(surface: "_Surface", a: Vector, b: Vector, bend: float) -> tuple[float, float]:
    fractions = np.linspace(0.0, 1.0, 2 + min(int(np.sqrt(bend)), 1000))
    width = 1.0 / (len(fractions) - 1)
    ends = _above(surface, a, b, fractions)
    low, at_low, at_high = fractions[:-1], ends[:-1], ends[1:]
    least, where = float(ends.min()), float(fractions[np.argmin(ends)])
    proven = np.inf  # what the spans that are not halved any more cannot go below
    while len(low):
        bound = np.minimum(at_low, at_high) - bend * width**2 / 8
        settled = bound >= least - REFINED
        proven = min(proven, float(bound[settled].min(initial=np.inf)))
        low, at_low, at_high, width = low[~settled], at_low[~settled], at_high[~settled], width / 2
        if len(low) == 0:
            break
        at_middle = _above(surface, a, b, low + width)
        if at_middle.min() < least:
            least, where = float(at_middle.min()), float(low[np.argmin(at_middle)] + width)
        low = np.concatenate([low, low + width])
        at_low, at_high = np.concatenate([at_low, at_middle]), np.concatenate([at_middle, at_high])
    return min(least, proven), where


def _above(surface: "_Surface", a: Vector, b: Vector, fractions: Vector) -> Vector:
    points = a + fractions[:, None] * (b - a)
    return np.asarray(points[:, 2] - surface(points))


class _Surface(Protocol):
    def __call__(self, points: NDArray[np.float64]) -> Vector: ...
