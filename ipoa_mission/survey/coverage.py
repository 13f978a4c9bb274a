"""Compute by geometry alone how much of an area a tour sees; line ends are rounded."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.scenario.survey_area import ARC, Area
from ipoa_mission.survey.survey_lines import union_along
from ipoa_mission.survey.tour import Tour

STEP, MAX_STEPS = 0.1, 20_000  # [m], along a stray path


@dataclass(frozen=True, eq=False)
class Coverage:
    """The seen part of an area.

    Attributes:
        share: of `Area.visible`, 0 to 1.
        gaps: of what can be covered (shapely).
        seen: shapely.
        outside_m: farthest the path is outside the area, or inside a hole or `keep_out` [m].
    """

    share: float
    gaps: Any
    seen: Any
    outside_m: float

    @property
    def seen_m2(self) -> float:
        return float(self.seen.area)


def coverage(area: Area, tour: Tour, width: float, keep_out: Any = None) -> Coverage:
    """Return the coverage by a tour; `width` [m] of the sensor, `keep_out` a shapely geometry."""
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
