"""Parallel lines through an area, cut where it ends, and those that a direction makes necessary besides."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.union import union_of

SHORT = 0.25  # a piece of a line shorter than this share of the spacing is left to what closes gaps
ARC = 8  # segments of a quarter of a circle, around what is seen
EVEN = 1e-6  # of a spacing: what is less than this too wide for a line less is not
SEAM = 1e-4  # [m]
TRIED = 5  # places of an extra line


@dataclass(frozen=True)
class LineAxes:
    """Axes along the lines and across, on their left, as unit vectors (2,)."""

    along: Vector
    across: Vector

    @classmethod
    def of(cls, degrees: float) -> "LineAxes":
        """That of a direction, clockwise from north."""
        e, n = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        return cls(np.array([e, n]), np.array([-n, e]))

    def turned(self, places: Points) -> Points:
        """Places (n, 2) along and across the lines."""
        return np.column_stack([places @ self.along, places @ self.across])

    def back(self, places: Points) -> Points:
        """Such places (n, 2) east and north."""
        return np.asarray(places[:, :1] * self.along + places[:, 1:] * self.across)


def heights(area: Any, grid: LineAxes, spacing: float, shift: float = 0.0) -> Vector:
    """How far across the lines lie: as few as see all of an area from side to side, evenly.

    `shift` from -1 to 1 moves them by the share of what the spacing leaves.
    """
    across = shapely.get_coordinates(area) @ grid.across
    low, high = float(across.min()), float(across.max())
    count = max(math.ceil((high - low) / spacing - EVEN), 1)
    if shift == 0.0:
        return np.asarray(low + (high - low) / count * (np.arange(count) + 0.5))
    middle = (low + high) / 2 + shift * (count * spacing - (high - low)) / 2
    return np.asarray(middle + spacing * (np.arange(count) - (count - 1) / 2))


def cut(edges: Points, grid: LineAxes, at: Vector) -> Points:
    """Pieces (n, 2, 2) of lines at these heights that lie between the edges (m, 4) of polygons, along their axis."""
    begins, ends = grid.turned(edges[:, :2]), grid.turned(edges[:, 2:])
    crosses = (begins[None, :, 1] <= at[:, None]) != (ends[None, :, 1] <= at[:, None])
    line, edge = np.nonzero(crosses)
    share = (at[line] - begins[edge, 1]) / (ends[edge, 1] - begins[edge, 1])
    along = begins[edge, 0] + share * (ends[edge, 0] - begins[edge, 0])
    order = np.lexsort([along, line])
    pairs = np.column_stack([along[order], at[line[order]]]).reshape(-1, 2, 2)
    return grid.back(pairs.reshape(-1, 2)).reshape(-1, 2, 2)


def seen_from(lines: Any, width: float) -> Any:
    """What is seen from lines (n, 2, 2), or from nothing; nothing is left between two that just meet."""
    return union_along(shapely.linestrings(lines), width / 2 + SEAM, ARC)


def union_along(drawn: Any, away: float, arc: int) -> Any:
    """What lies so near to lines (n,) of shapely, their ends rounded by so many segments for a quarter of a circle."""
    return union_of(shapely.buffer(drawn, away, quad_segs=arc))


def parts_of(gaps: Any) -> list[Any]:
    """The polygons among what a difference of areas left."""
    return [part for part in shapely.get_parts(gaps) if part.geom_type == "Polygon" and part.area > 0.0]


def line_over(gap: Any, inner: Any, width: float) -> Points | None:
    """A line (2, 2) inside that sees the most of a long gap; None where one place, or nothing, sees as much."""
    box = shapely.get_coordinates(shapely.oriented_envelope(gap))
    if len(box) < 4:
        return None
    sides = np.diff(box[:3], axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    along = sides[int(lengths.argmax())] / lengths.max()
    grid = LineAxes(along, np.array([-along[1], along[0]]))
    places = grid.turned(shapely.get_coordinates(shapely.segmentize(gap.boundary, width / 4)))
    (west, south), (east, north) = places.min(axis=0), places.max(axis=0)
    low, high = sorted((north - width / 2, south + width / 2))
    best, most = None, 0
    for height in np.linspace(low, high, TRIED):
        whole = shapely.LineString(grid.back(np.array([[west, height], [east, height]])))
        for part in shapely.get_parts(shapely.intersection(whole, inner)):
            if part.geom_type != "LineString" or part.length <= 0.0:
                continue
            ends = np.sort(grid.turned(shapely.get_coordinates(part))[[0, -1], 0])
            away = places[:, 1] - height
            reach = np.sqrt(np.maximum((width / 2) ** 2 - away**2, 0.0))
            sees = (np.abs(away) <= width / 2) & (places[:, 0] >= ends[0] - reach) & (places[:, 0] <= ends[1] + reach)
            if (count := int(sees.sum())) > most:
                first, last = (places[sees, 0] + reach[sees]).min(), (places[sees, 0] - reach[sees]).max()
                ends = np.clip([min(first, last), max(first, last)], *ends)
                best, most = grid.back(np.column_stack([ends, [height, height]])), count
    return best
