"""Contingencies, and the routes of a return to home, a rally point or the mission's landing."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.version import Version

if TYPE_CHECKING:
    from ipoa_mission.geometry import Place


class Contingency(StrEnum):
    """An action that replaces the rest of the mission."""

    RTL = "rtl"  # home or a rally point, by `Autopilot.return_route` and `return_height`
    LAND = "land"  # in place
    SMART_RTL = "smart_rtl"  # back along the flown path
    HOLD = "hold"  # until a new order or an empty battery
    CONTINUE = "continue"
    LAND_START = "land_start"  # to the mission's landing
    TERMINATE = "terminate"  # the motors stop; the vehicle falls
    UNKNOWN = "unknown"  # not modeled; see the action's `words`


COMPUTED = (Contingency.RTL, Contingency.LAND, Contingency.SMART_RTL, Contingency.HOLD)  # their paths are known
TIMED = (Contingency.RTL, Contingency.LAND)  # flight models end them on the ground
IN_PLACE = (Contingency.LAND, Contingency.HOLD)


class FlightStage(StrEnum):
    TAKEOFF = "take-off"
    ROUTE = "route"
    RETURN = "return"
    LANDING = "landing"


HOME: "Place" = (0.0, 0.0, 0.0)


def level_distance(start: "Place", end: "Place") -> float:
    return math.hypot(start[0] - end[0], start[1] - end[1])


class ReturnBy(StrEnum):
    DIRECT = "direct"  # climb to the return height, fly straight to home or a rally point
    LANDING = "to the mission's landing"  # climb to the return height, fly straight to the mission's landing
    MISSION_FORWARD = "ahead along the mission"  # to the landing, without climbing and other commands
    MISSION_REVERSED = "back along the mission"  # without climbing, landing at home
    LAND_IN_PLACE = "here"


@dataclass(frozen=True)
class ReturnRoute:
    """A route and its rally point; None: home, or as `by` says."""

    by: ReturnBy
    rally: int | None = None


@dataclass(frozen=True)
class MissionLanding:
    """Place of the LAND item, and items ahead and behind.

    `ahead`: from the current item to DO_LAND_START or LAND. `behind`: from the first item.
    """

    place: "Place"
    ahead: int
    behind: int


@dataclass(frozen=True)
class ReturnOrder:
    """An order to return from `here`, with the rally points aboard and the mission's landing."""

    here: "Place"
    rally: "Sequence[Place]" = ()
    landing: MissionLanding | None = None
    version: Version | None = None


@dataclass(frozen=True)
class OverTerrain:
    """Height error `margin` [m]; `always_over_terrain`: it never falls back to heights above home."""

    margin: float
    always_over_terrain: bool
