import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.polygon import union_of

MIN_PIECE = 0.25  # of the spacing; detours see shorter pieces
ARC = 8  # segments of a quarter circle
COUNT_TOLERANCE = 1e-6  # [spacings]
SEAM_WIDTH = 1e-4  # [m]
POSITIONS = 5  # tried for an extra line


@dataclass(frozen=True)
class LineAxes:
    """Unit vectors along the lines and across, on their left (2,)."""

    along: Vector
    across: Vector

    @classmethod
    def of(cls, degrees: float) -> "LineAxes":
        e, n = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        return cls(np.array([e, n]), np.array([-n, e]))

    def turned(self, places: Points) -> Points:
        return np.column_stack([places @ self.along, places @ self.across])

    def back(self, places: Points) -> Points:
        return np.asarray(places[:, :1] * self.along + places[:, 1:] * self.across)


def heights(area: Any, grid: LineAxes, spacing: float, shift: float = 0.0) -> Vector:
    """Return positions across, evenly; `shift` from -1 to 1 moves them by this share of the slack."""
    across = shapely.get_coordinates(area) @ grid.across
    low, high = float(across.min()), float(across.max())
    count = max(math.ceil((high - low) / spacing - COUNT_TOLERANCE), 1)
    if shift == 0.0:
        return np.asarray(low + (high - low) / count * (np.arange(count) + 0.5))
    middle = (low + high) / 2 + shift * (count * spacing - (high - low)) / 2
    return np.asarray(middle + spacing * (np.arange(count) - (count - 1) / 2))


def cut(edges: Points, grid: LineAxes, at: Vector) -> Points:
    """Return the pieces (n, 2, 2) between the edges (m, 4) of polygons."""
    begins, ends = grid.turned(edges[:, :2]), grid.turned(edges[:, 2:])
    crosses = (begins[None, :, 1] <= at[:, None]) != (ends[None, :, 1] <= at[:, None])
    line, edge = np.nonzero(crosses)
    share = (at[line] - begins[edge, 1]) / (ends[edge, 1] - begins[edge, 1])
    along = begins[edge, 0] + share * (ends[edge, 0] - begins[edge, 0])
    order = np.lexsort([along, line])
    pairs = np.column_stack([along[order], at[line[order]]]).reshape(-1, 2, 2)
    return grid.back(pairs.reshape(-1, 2)).reshape(-1, 2, 2)


def seen_from(lines: Any, width: float) -> Any:
    """Return the area seen from lines (n, 2, 2), without seams."""
    return union_along(shapely.linestrings(lines), width / 2 + SEAM_WIDTH, ARC)


def union_along(drawn: Any, away: float, arc: int) -> Any:
    """Return the area within `away` of lines (n,); `arc` segments a quarter circle."""
    return union_of(shapely.buffer(drawn, away, quad_segs=arc))


def parts_of(gaps: Any) -> list[Any]:
    return [part for part in shapely.get_parts(gaps) if part.geom_type == "Polygon" and part.area > 0.0]


def line_over(gap: Any, inner: Any, width: float) -> Points | None:
    """Return the line (2, 2) that sees most of a gap, or None if a place sees as much."""
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
    for height in np.linspace(low, high, POSITIONS):
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
