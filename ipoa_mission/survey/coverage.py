"""How much of an area a tour sees, where not, and whether it keeps inside: by geometry, not by how it was planned.

A place is seen that lies within half the width of a line, its ends rounded: the sensor sees a disc. Of what can be
covered all is asked: places of the area within half the width of some place of it where lines may be (`Area.visible`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.survey.area import ARC, Area
from ipoa_mission.survey.survey_lines import union_along
from ipoa_mission.survey.tour import Tour

STEP, MOST = 0.1, 20_000  # between places at which it is looked how far a path strays [m], and how many at most


@dataclass(frozen=True, eq=False)
class Coverage:
    """What a tour sees of an area.

    Attributes:
        share: of what can be covered, 0 to 1.
        gaps: where it can be covered, and is not: a shapely geometry.
        seen: what of the area is seen: a shapely geometry.
        outside_m: the farthest that the path leaves the area, or enters a hole or what is kept out of [m].
    """

    share: float
    gaps: Any
    seen: Any
    outside_m: float

    @property
    def seen_m2(self) -> float:
        """How much of the area is seen [m^2]."""
        return float(self.seen.area)


def coverage(area: Area, tour: Tour, width: float, keep_out: Any = None) -> Coverage:
    """How much of an area the lines of a tour see.

    Args:
        area: what is to be seen.
        tour: what is flown.
        width: of what the sensor sees [m].
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
    """The farthest that the path leaves where it may be [m]."""
    if len(tour.path) < 2:
        return 0.0
    path = shapely.LineString(tour.path)
    farthest = [float(shape.distance(at)) for at in _places(path.difference(shape))]
    if keep_out is not None:
        farthest += [float(keep_out.boundary.distance(at)) for at in _places(path.intersection(keep_out))]
    return max(farthest, default=0.0)


def _places(stray: Any) -> list[Any]:
    """Places along what strays, close to each other."""
    return list(shapely.points(shapely.get_coordinates(shapely.segmentize(stray, max(STEP, stray.length / MOST)))))
