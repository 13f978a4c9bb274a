"""Where PX4's RTL leads and how high it goes there: home or a rally point (1.15 and later).

Whichever is nearest, home or a rally point that is 2 m nearer and 10 m away from home; with RTL_TYPE 1 never home where
there is a rally point. All its heights count from the rally point's. What RTL_TYPE makes of a mission's own landing is
not modeled.
"""

import math
from collections.abc import Sequence

from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Return
from ipoa_mission.vehicles.returning import HOME, Place, level_distance

NEARER = 2.0  # by so much a rally point must be nearer than home [m]
OF_ITS_OWN = 10.0  # rally points that are no farther from home are none [m]
NOT_HOME = 1.0  # RTL_TYPE: a rally point or a mission's landing, home only where there is neither
ALONG_THE_MISSION = frozenset({2.0, 4.0})  # RTL_TYPE: back along the mission, or on along it


def return_height(parameters: Parameters, height: float, distance: float, goal_up: float) -> float:
    """As `Px4Return` says, counted from the goal's height [m]."""
    return goal_up + Px4Return.of(parameters).height(height - goal_up, distance)


def goal_of_return(parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    """Which of the rally points a return from `here` leads to; None: home."""
    kind = parameters.get("RTL_TYPE", 0.0)
    if kind in ALONG_THE_MISSION:
        return None
    goal, nearest = None, math.inf if kind == NOT_HOME else level_distance(here, HOME)
    for n, place in enumerate(rally):
        way = level_distance(here, place)
        if level_distance(HOME, place) > OF_ITS_OWN and way + NEARER < nearest:
            goal, nearest = n, way
    return goal
