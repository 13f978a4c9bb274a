"""ArduCopter's own fence, and the height of its RTL (4.x), which the fence limits."""

import math
from enum import IntEnum
from typing import NamedTuple

from ipoa_mission.autopilot.failsafe import FenceLimit, OwnFence
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.vehicles.arducopter.parameter_table import PARAMETER_TABLE

#: These enable the fence, always or from arming or take-off.
FENCE_SWITCHES = {"FENCE_ENABLE": 0.0, "FENCE_AUTOENABLE": 0.0}


class FenceType(IntEnum):
    """Bits of FENCE_TYPE."""

    CEILING = 1
    CIRCLE = 2
    POLYGONS = 4
    FLOOR = 8


def fence_limits(parameters: Parameters) -> OwnFence | None:
    """Return the limits that FENCE_TYPE enables; None: the fence is off."""
    if not any(parameters.get(name, default) for name, default in FENCE_SWITCHES.items()):
        return None
    defaults = {"FENCE_TYPE": 7.0, "FENCE_RADIUS": 300.0, "FENCE_ALT_MAX": 100.0, "FENCE_ALT_MIN": -10.0}
    p = {**defaults, **parameters}

    def limit(name: str, bit: FenceType, none: float) -> FenceLimit:
        return FenceLimit(name, p[name] if int(p["FENCE_TYPE"]) & bit else none)

    return OwnFence(
        limit("FENCE_RADIUS", FenceType.CIRCLE, math.inf),
        limit("FENCE_ALT_MAX", FenceType.CEILING, math.inf),
        limit("FENCE_ALT_MIN", FenceType.FLOOR, -math.inf),
    )


class CopterReturn(NamedTuple):
    """RTL_ALT, RTL_CLIMB_MIN [m], RTL_CONE_SLOPE, and the fence's limit [m]."""

    altitude: float
    climb: float
    cone: float
    ceiling: float

    @classmethod
    def of(cls, parameters: Parameters) -> "CopterReturn":
        p, fence = {**PARAMETER_TABLE.moving, **parameters}, fence_limits(parameters)
        ceiling = math.inf if fence is None else fence.ceiling.value - p.get("FENCE_MARGIN", 2.0)
        return cls(p["RTL_ALT"] / 100, max(p["RTL_CLIMB_MIN"] / 100, 0.0), p["RTL_CONE_SLOPE"], ceiling)

    def height(self, above: float, distance: float, goal_up: float) -> float:
        """Return the height above home [m], from `above` home over a level distance to `goal_up`.

        Near the goal a cone of at least 0.5 limits it, and FENCE_MARGIN below a ceiling. It never descends for a limit.
        """
        least = max(0.3, above + self.climb)  # RTL_ALT_MIN
        top = max(self.altitude, goal_up, least)
        if self.cone >= 0.5:
            top = min(top, max(distance * self.cone, least))
        return max(min(top, self.ceiling), above)
