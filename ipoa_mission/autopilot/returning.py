"""The routes of a return to home, a rally point or the mission's landing, and LAND at its end.

Touchdown depends on LAND's height above home. A range finder, terrain data or ArduCopter 4.7's LAND altitude in AUTO
would take precedence.
"""

import math
from collections.abc import Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from ipoa_mission.autopilot.parameters import Parameters, ParameterTable
from ipoa_mission.autopilot.version import Version

if TYPE_CHECKING:
    from ipoa_mission.geometry import Place

HOME: "Place" = (0.0, 0.0, 0.0)
SLOWEST = 0.05  # [m/s]
HEIGHT_UNCERTAINTY = 2.0  # of heights and terrain maps; least slow stretch [m]


class ReturnBy(StrEnum):
    DIRECT = "direct"  # at the return height, to home or a rally point
    LANDING = "to the mission's landing"  # at the return height
    MISSION_FORWARD = "ahead along the mission"  # to the landing, without climbing and other commands
    MISSION_REVERSED = "back along the mission"  # without climbing, landing at home
    LAND_IN_PLACE = "here"


class ReturnRoute(NamedTuple):
    """A route and its rally point; None: home, or as `by` says."""

    by: ReturnBy
    rally: int | None = None


class MissionLanding(NamedTuple):
    """Place of the LAND item, and numbers of items to it."""

    place: "Place"
    ahead: int  # from the current item to DO_LAND_START or LAND
    behind: int  # from the first item to the current one


class ReturnOrder(NamedTuple):
    """An order to return from `here`, with the rally points aboard and the mission's landing."""

    here: "Place"
    rally: "Sequence[Place]" = ()
    landing: MissionLanding | None = None
    version: Version | None = None


class OverTerrain(NamedTuple):
    margin: float  # of the height [m]
    always_over_terrain: bool  # it never falls back to heights above home


class SinkingBrake(NamedTuple):
    """LAND from level flight: its braking, and its sink meanwhile, as flown."""

    accel: float  # horizontal deceleration [m/s^2]
    descent: float  # descent speed [m/s]
    begins_late_s: float  # after the order, in level flight
    settles_s: float  # added to the braking time
    overshoots_s: float  # of the speed, beyond the stopping point


class SlowedBy(NamedTuple):
    names: tuple[str, ...]
    most: float  # as documented [m]
    decided_by: tuple[str, ...]  # all that affect the touchdown speed
    spared_by: str = ""  # range finder's parameter: heights count from the ground

    def raised(self, table: ParameterTable, parameters: Parameters, ground: float) -> Parameters:
        p = table.si(parameters)
        higher = math.ceil(ground - 0.05)  # whole meters, with rounding
        return {name: round(table.by_name[name].spelled(min(p[name] + higher, self.most)), 6) for name in self.names}


class SlowStretch(NamedTuple):
    """LAND's slowing from `descent` to `landing` speed."""

    landing: float  # [m/s]
    descent: float
    begins: float  # height above home [m]
    ends: float

    def touchdown(self, ground: float) -> float:
        share = (ground - self.ends) / max(self.begins - self.ends, 1e-6)
        return self.landing + min(max(share, 0.0), 1.0) * max(self.descent - self.landing, 0.0)

    def is_fast(self, ground: float) -> bool:
        return self.touchdown(ground) > self.landing + 0.05
