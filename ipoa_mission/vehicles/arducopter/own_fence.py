"""The fence of ArduCopter's own parameters (AC_Fence): which of its limits are on, and how far they reach."""

import math

from ipoa_mission.vehicles.own_fence import FenceLimit, OwnFence
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.returning import HOME, Place, level_distance

CEILING_BIT, CIRCLE_BIT, FLOOR_BIT = 1, 2, 8  # of FENCE_TYPE; 4 is the polygons of a mission
#: What switches a fence on, for good or from arming or take-off on.
MAY_BE_ON = {"FENCE_ENABLE": 0.0, "FENCE_AUTOENABLE": 0.0}
DEFAULTS = {"FENCE_TYPE": 7.0, "FENCE_RADIUS": 300.0, "FENCE_ALT_MAX": 100.0, "FENCE_ALT_MIN": -10.0}


def limits_on(parameters: Parameters) -> OwnFence | None:
    """The limits that are switched on, whatever follows a breach; None where none is."""
    if not any(parameters.get(name, usual) for name, usual in MAY_BE_ON.items()):
        return None
    p = {**DEFAULTS, **parameters}

    def limit(name: str, bit: int, none: float) -> FenceLimit:
        return FenceLimit(name, p[name] if int(p["FENCE_TYPE"]) & bit else none)

    return OwnFence(
        limit("FENCE_RADIUS", CIRCLE_BIT, math.inf),
        limit("FENCE_ALT_MAX", CEILING_BIT, math.inf),
        limit("FENCE_ALT_MIN", FLOOR_BIT, -math.inf),
    )


def return_ceiling(parameters: Parameters) -> float:
    """No higher than so high above home does RTL climb [m]: FENCE_MARGIN below the fence's ceiling."""
    fence = limits_on(parameters)
    return math.inf if fence is None else fence.ceiling.value - parameters.get("FENCE_MARGIN", 2.0)


def is_within(parameters: Parameters, place: Place) -> bool:
    """Whether RTL takes it for a rally point: it passes over those outside the fence."""
    fence = limits_on(parameters)
    if fence is None:
        return True
    return level_distance(place, HOME) <= fence.radius.value and fence.floor.value <= place[2] <= fence.ceiling.value
