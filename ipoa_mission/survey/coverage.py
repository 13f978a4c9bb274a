"""Compute how much of an area a tour sees, where not, and whether it stays inside, by geometry alone.

A place within half the width of a line is seen, the line's ends rounded: the sensor sees a disc. The share
counts places that can be covered: those within half the width of a permitted line (`Area.visible`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.survey.area import ARC, Area
from ipoa_mission.survey.survey_lines import union_along
from ipoa_mission.survey.tour import Tour

STEP, MAX_STEPS = 0.1, 20_000  # spacing of the places at which a stray path is measured [m], and their maximum number


@dataclass(frozen=True, eq=False)
class Coverage:
    """The part of an area that a tour sees.

    Attributes:
        share: of what can be covered, 0 to 1.
        gaps: what can be covered and is not seen: a shapely geometry.
        seen: the part of the area that is seen: a shapely geometry.
        outside_m: maximum distance of the path outside the area, or inside a hole or `keep_out` [m].
    """

    share: float
    gaps: Any
    seen: Any
    outside_m: float

    @property
    def seen_m2(self) -> float:
        return float(self.seen.area)


def coverage(area: Area, tour: Tour, width: float, keep_out: Any = None) -> Coverage:
    """Return how much of an area the lines of a tour see.

    Args:
        area: to be seen.
        tour: as planned.
        width: seen by the sensor [m].
        keep_out: a shapely geometry that is not entered.
    """
    can = area.visible(keep_out, width)
    lines = np.array([[swath.begin, swath.end] for swath in tour.swaths]).reshape(-1, 2, 2)
    seen = area.shape.intersection(union_along(shapely.linestrings(lines), width / 2, ARC))
    gaps = can.difference(seen)
    whole = float(can.area)
    share = 1.0 if whole <= 0.0 else 1.0 - float(gaps.area) / whole
    return Coverage(share, gaps, seen, _outside(area.shape, tour, keep_out))


def _outside(shape: Any, tour: Tour, keep_out: Any) -> float:
    if len(tour.path) < 2:
        return 0.0
    path = shapely.LineString(tour.path)
    farthest = [float(shape.distance(at)) for at in _places(path.difference(shape))]
    if keep_out is not None:
        farthest += [float(keep_out.boundary.distance(at)) for at in _places(path.intersection(keep_out))]
    return max(farthest, default=0.0)


def _places(stray: Any) -> list[Any]:
    return list(shapely.points(shapely.get_coordinates(shapely.segmentize(stray, max(STEP, stray.length / MAX_STEPS)))))
