"""Goal and route of PX4's RTL: the nearest of home, rally points and the mission's landing.

From 1.19 on RTL flies around fences, except on the smallest boards; not modeled. Read in
1.17.0 (d6f12ad1), release/1.18 (05deebf313) and main (bb59c637).
"""

import math
from collections.abc import Sequence

from ipoa_mission.autopilot.failsafe import Series
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import (
    HOME,
    MissionLanding,
    Place,
    ReturnBy,
    ReturnRoute,
    level_distance,
)
from ipoa_mission.vehicles.px4_multicopter.parameter_table import SINCE_SPLIT

REQUIRED_ADVANTAGE = 2.0  # of a rally point or landing [m]
LEAST_RALLY_DISTANCE = 10.0  # from home [m]
# RTL_TYPE 0 to 5
HOME_OR_RALLY, NOT_HOME, LANDING_OR_BACK, NEAREST, SHORTER_WAY, RALLY_ONLY = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
RALLY_ONLY_SINCE = (1, 18)
FENCE_ROUTING_SINCE = (1, 19)  # 40e61d2429, after release/1.18 branched


def return_height(parameters: Parameters, height: float, distance: float, goal_up: float) -> float:
    """Return the height above home [m]."""
    from ipoa_mission.vehicles.px4_multicopter.limits import Px4Return

    return goal_up + Px4Return.of(parameters).height(height - goal_up, distance)


def return_route(
    parameters: Parameters, here: Place, rally: Sequence[Place], landing: MissionLanding | None, series: Series
) -> ReturnRoute:
    """Return RTL_TYPE's route; 1 uses home last, 5 (1.18) never."""
    kind = parameters.get("RTL_TYPE", HOME_OR_RALLY)
    if kind in {LANDING_OR_BACK, SHORTER_WAY}:
        ahead = landing is not None and (kind == LANDING_OR_BACK or landing.ahead < landing.behind)
        return ReturnRoute(ReturnBy.AHEAD if ahead else ReturnBy.BACK)
    rally_only = kind == RALLY_ONLY and series >= RALLY_ONLY_SINCE
    best = ReturnRoute(ReturnBy.HERE if rally_only else ReturnBy.DIRECT)
    nearest = math.inf if rally_only or kind == NOT_HOME else level_distance(here, HOME)
    if (
        landing is not None
        and kind in {NOT_HOME, NEAREST}
        and level_distance(here, landing.place) + REQUIRED_ADVANTAGE < nearest
    ):
        best, nearest = ReturnRoute(ReturnBy.LANDING), level_distance(here, landing.place)
    for n, place in enumerate(rally):
        way = level_distance(here, place)
        if (rally_only or level_distance(HOME, place) > LEAST_RALLY_DISTANCE) and way + REQUIRED_ADVANTAGE < nearest:
            best, nearest = ReturnRoute(ReturnBy.DIRECT, n), way
    return best


def room_to_fences(parameters: Parameters, series: Series) -> float | None:
    """Return the distance to fences that it flies around [m]; None: ignored."""
    return 2.0 * parameters.get("NAV_ACC_RAD", SINCE_SPLIT["NAV_ACC_RAD"]) if series >= FENCE_ROUTING_SINCE else None
