"""The fence that a vehicle has by its own parameters, around its home, whatever fence a mission brings.

ArduCopter (AC_Fence): bits of FENCE_TYPE switch on the greatest height (1), the circle (2), the polygons of a mission
(4) and the least height (8), where FENCE_ENABLE is on; FENCE_ACTION 0 only reports. PX4: a distance or a height of 0 is
no limit; GF_ACTION 0 does nothing and 1 only warns.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ipoa_mission.autopilots.vehicle import Autopilot, Parameters

CEILING_BIT, CIRCLE_BIT, FLOOR_BIT = 1, 2, 8
ONLY_TOLD: Mapping[Autopilot, float] = {Autopilot.ARDUPILOT: 0.0, Autopilot.PX4: 1.0}  # the last action of no effect
#: All that decides about it.
OWN_FENCE: Mapping[Autopilot, tuple[str, ...]] = {
    Autopilot.ARDUPILOT: (
        "FENCE_ENABLE",
        "FENCE_TYPE",
        "FENCE_ACTION",
        "FENCE_RADIUS",
        "FENCE_ALT_MAX",
        "FENCE_ALT_MIN",
    ),
    Autopilot.PX4: ("GF_ACTION", "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"),
}


@dataclass(frozen=True)
class Limit:
    """One limit of a fence [m], and the parameter that says it; none is infinite."""

    name: str
    value: float


@dataclass(frozen=True)
class OwnFence:
    """How far from home a vehicle may fly, how high above it, and how low between take-off and landing [m]."""

    radius: Limit
    ceiling: Limit
    floor: Limit


def own_fence(autopilot: Autopilot, parameters: Parameters) -> OwnFence | None:
    """The fence that these parameters of a vehicle put into force; None where it has none that does something."""
    if autopilot is Autopilot.PX4:
        if parameters.get("GF_ACTION", 0.0) <= ONLY_TOLD[autopilot]:
            return None
        across, up = (parameters.get(name, 0.0) for name in ("GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"))
        return OwnFence(
            Limit("GF_MAX_HOR_DIST", across if across > 0.0 else math.inf),
            Limit("GF_MAX_VER_DIST", up if up > 0.0 else math.inf),
            Limit("", -math.inf),
        )
    if not parameters.get("FENCE_ENABLE", 0.0) or parameters.get("FENCE_ACTION", 1.0) <= ONLY_TOLD[autopilot]:
        return None
    bits = int(parameters.get("FENCE_TYPE", 0.0))

    def limit(name: str, bit: int, none: float) -> Limit:
        return Limit(name, parameters.get(name, none) if bits & bit else none)

    return OwnFence(
        limit("FENCE_RADIUS", CIRCLE_BIT, math.inf),
        limit("FENCE_ALT_MAX", CEILING_BIT, math.inf),
        limit("FENCE_ALT_MIN", FLOOR_BIT, -math.inf),
    )
