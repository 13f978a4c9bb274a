import math

from ipoa_mission.autopilot.failsafe import FenceLimit, OwnFence
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import HOME, Place, level_distance

CEILING_BIT, CIRCLE_BIT, FLOOR_BIT = 1, 2, 8  # of FENCE_TYPE; 4: polygons
#: These enable the fence, always or from arming or take-off.
FENCE_SWITCHES = {"FENCE_ENABLE": 0.0, "FENCE_AUTOENABLE": 0.0}
DEFAULTS = {"FENCE_TYPE": 7.0, "FENCE_RADIUS": 300.0, "FENCE_ALT_MAX": 100.0, "FENCE_ALT_MIN": -10.0}


def limits_on(parameters: Parameters) -> OwnFence | None:
    if not any(parameters.get(name, usual) for name, usual in FENCE_SWITCHES.items()):
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
    """Return RTL's greatest height above home [m]."""
    fence = limits_on(parameters)
    return math.inf if fence is None else fence.ceiling.value - parameters.get("FENCE_MARGIN", 2.0)


def is_within(parameters: Parameters, place: Place) -> bool:
    """Return whether RTL considers a rally point."""
    fence = limits_on(parameters)
    if fence is None:
        return True
    return level_distance(place, HOME) <= fence.radius.value and fence.floor.value <= place[2] <= fence.ceiling.value
