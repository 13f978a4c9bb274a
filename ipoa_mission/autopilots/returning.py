"""Where a return leads and how high it goes there: home or a rally point, by each autopilot's own rules.

ArduCopter (4.x): the nearest rally point, unless home is nearer and RALLY_INCL_HOME counts it, or all are farther than
RALLY_LIMIT_KM. Its height there is at least the rally point's. PX4 (1.15 and later): whichever is nearest, home or a
rally point that is 2 m nearer and 10 m away from home; with RTL_TYPE 1 never home where there is a rally point. All its
heights count from the rally point's. What RTL_TYPE makes of a mission's own landing is not modeled.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from ipoa_mission.autopilots.px4 import Px4Return
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters

Place: TypeAlias = tuple[float, float, float]  # east, north, up [m]

HOME: Place = (0.0, 0.0, 0.0)
NEARER = 2.0  # by so much a rally point must be nearer to PX4 than home [m]
OF_ITS_OWN = 10.0  # rally points that are no farther from home are none to PX4 [m]
NOT_HOME = 1.0  # RTL_TYPE: a rally point or a mission's landing, home only where there is neither
ALONG_THE_MISSION = frozenset({2.0, 4.0})  # RTL_TYPE: back along the mission, or on along it
LEAST_CONE = 0.5  # RTL_CONE_SLOPE counts from here on


def goal_of_return(autopilot: Autopilot, parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    """Which of the rally points a return from `here` leads to; None: home. `parameters` are by their older names.

    >>> goal_of_return(Autopilot.PX4, {}, (100.0, 0.0, 20.0), [(90.0, 0.0, 10.0)])
    0
    >>> goal_of_return(Autopilot.ARDUPILOT, {"RALLY_LIMIT_KM": 0.3}, (0.0, 500.0, 20.0), [(0.0, 900.0, 10.0)])
    """
    return _GOAL[autopilot](parameters, here, rally)


def return_height(
    autopilot: Autopilot, parameters: Parameters, height: float, distance: float, goal_up: float = 0.0
) -> float:
    """How high above home it returns from so high above it, over so far, to a goal of the height `goal_up` [m]."""
    return _HEIGHT[autopilot](parameters, height, distance, goal_up)


def ardupilot_height(least: float, top: float, cone: float, distance: float, goal_up: float) -> float:
    """ArduCopter's: `top` or the goal's height, if that is more; near the goal less, by the cone; `least` at least."""
    top = max(top, goal_up, least)
    return min(top, max(distance * cone, least)) if cone >= LEAST_CONE else top


def _ardupilot(parameters: Parameters, height: float, distance: float, goal_up: float) -> float:
    """RTL_ALT [cm] at least, RTL_CLIMB_MIN [cm] more than now, less near the goal by RTL_CONE_SLOPE."""
    least = max(0.0, height + max(0.0, parameters.get("RTL_CLIMB_MIN", 0.0) / 100))
    cone = parameters.get("RTL_CONE_SLOPE", 3.0)
    return ardupilot_height(least, parameters["RTL_ALT"] / 100, cone, distance, goal_up)


def _px4(parameters: Parameters, height: float, distance: float, goal_up: float) -> float:
    return goal_up + Px4Return.of(parameters).height(height - goal_up, distance)


def _ardupilot_goal(parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    if not rally:
        return None
    ways = [_way(here, place) for place in rally]
    nearest = min(range(len(ways)), key=ways.__getitem__)
    limit = 1000.0 * parameters.get("RALLY_LIMIT_KM", 0.3)
    too_far = limit > 0.0 and ways[nearest] > limit
    home_is_nearer = parameters.get("RALLY_INCL_HOME", 1.0) != 0.0 and ways[nearest] >= _way(here, HOME)
    return None if too_far or home_is_nearer else nearest


def _px4_goal(parameters: Parameters, here: Place, rally: Sequence[Place]) -> int | None:
    kind = parameters.get("RTL_TYPE", 0.0)
    if kind in ALONG_THE_MISSION:
        return None
    goal, nearest = None, math.inf if kind == NOT_HOME else _way(here, HOME)
    for n, place in enumerate(rally):
        way = _way(here, place)
        if _way(HOME, place) > OF_ITS_OWN and way + NEARER < nearest:
            goal, nearest = n, way
    return goal


def _way(one: Place, other: Place) -> float:
    return math.hypot(one[0] - other[0], one[1] - other[1])


_GOAL: Mapping[Autopilot, Callable[[Parameters, Place, Sequence[Place]], int | None]] = {
    Autopilot.ARDUPILOT: _ardupilot_goal,
    Autopilot.PX4: _px4_goal,
}
_HEIGHT: Mapping[Autopilot, Callable[[Parameters, float, float, float], float]] = {
    Autopilot.ARDUPILOT: _ardupilot,
    Autopilot.PX4: _px4,
}
