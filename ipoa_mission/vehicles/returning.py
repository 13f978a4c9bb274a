"""Where a return may lead: places over home, and how far they are."""

import math
from typing import TypeAlias

Place: TypeAlias = tuple[float, float, float]  # east, north, up [m]

HOME: Place = (0.0, 0.0, 0.0)


def level_distance(one: Place, other: Place) -> float:
    """Between two places, over the ground [m]."""
    return math.hypot(one[0] - other[0], one[1] - other[1])
