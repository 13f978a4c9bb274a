"""Where a return may lead, along which way, and what the vehicle does once it is over its goal."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

Place: TypeAlias = tuple[float, float, float]  # east, north, up [m]

HOME: Place = (0.0, 0.0, 0.0)


def level_distance(one: Place, other: Place) -> float:
    """Between two places, over the ground [m]."""
    return math.hypot(one[0] - other[0], one[1] - other[1])


class ReturnBy(StrEnum):
    """Along which way a return leads."""

    DIRECT = "direct"
    """Up to its height, then straight to home or a rally point."""
    LANDING = "to the mission's landing"
    """Up to its height, then straight to where the mission begins to land, and on as the mission does."""
    AHEAD = "ahead along the mission"
    """From waypoint to waypoint to the mission's landing, without climbing and without what is done on the way."""
    BACK = "back along the mission"
    """From waypoint to waypoint back to the take-off, without climbing; then it lands at home."""
    HERE = "here"
    """Nowhere: it lands where it is."""


@dataclass(frozen=True)
class ReturnRoute:
    """Along which way a return leads, and to which of the rally points; None: home, or as `by` says."""

    by: ReturnBy
    rally: int | None = None


@dataclass(frozen=True)
class MissionLanding:
    """The landing of a mission: the place of its LAND item, and how many items before and after the one flown to now.

    `ahead` counts up to DO_LAND_START, or to the LAND item of a mission that has none, `behind` from the first item.
    """

    place: Place
    ahead: int
    behind: int


@dataclass(frozen=True)
class OverTerrain:
    """That a return keeps its height over the ground, by up to `margin` m off; `surely`: it cannot but do so."""

    margin: float
    surely: bool
