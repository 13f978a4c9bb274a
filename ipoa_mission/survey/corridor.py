import math
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.scenario.survey_area import Area
from ipoa_mission.survey.tour import Swath, Tour

MAX_TRIM = 1 / 8
INSIDE = 1e-6  # [m]


def corridor_tour(middle: Points, width: float, spacing: float, begin: Vector, inside: Any, past: float) -> Tour | None:
    """Return lines at most `spacing` apart [m], from the corridor's end nearer to `begin` (2,).

    Lines end earlier by the overshoot `past` corners [m]. Return None if a line bends back on itself or leaves
    `inside`.
    """
    count = max(math.ceil(width / spacing - 1e-9), 1)
    if np.linalg.norm(middle[-1] - begin) < np.linalg.norm(middle[0] - begin):
        middle = middle[::-1]
    middle = _trimmed(middle, min(past, MAX_TRIM * spacing))
    lines = list[Points]()
    for n in range(count):
        line = shapely.LineString(middle).offset_curve(width * ((n + 0.5) / count - 0.5), join_style="mitre")
        corners = shapely.get_coordinates(line)
        if line.geom_type != "LineString" or len(corners) != len(middle) or not inside.covers(line):
            return None
        lines.append(corners if n % 2 == 0 else corners[::-1])
    swaths = tuple(Swath(a, b) for line in lines for a, b in pairwise(line))
    return Tour(swaths, tuple(np.array([one.end, other.begin]) for one, other in pairwise(swaths)))


def _trimmed(middle: Points, by: float) -> Points:
    legs = middle[[1, -2]] - middle[[0, -1]]
    lengths = np.linalg.norm(legs, axis=1, keepdims=True)
    if (lengths <= 2 * by).any():
        return middle
    ends = middle[[0, -1]] + by / lengths * legs
    return np.concatenate([ends[:1], middle[1:-1], ends[1:]])


def where_allowed(area: Area, keep_out: Any | None) -> Any:
    return area.without(keep_out).buffer(INSIDE)
