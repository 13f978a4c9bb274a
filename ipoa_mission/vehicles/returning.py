"""Goals and routes of a return."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

Place: TypeAlias = tuple[float, float, float]  # east, north, up [m]

HOME: Place = (0.0, 0.0, 0.0)


def level_distance(one: Place, other: Place) -> float:
    return math.hypot(one[0] - other[0], one[1] - other[1])


class ReturnBy(StrEnum):
    """The route of a return."""

    DIRECT = "direct"
    """Climb to the return height, then fly straight to home or a rally point."""
    LANDING = "to the mission's landing"
    """Climb to the return height, fly straight to the start of the mission's landing, and follow it."""
    AHEAD = "ahead along the mission"
    """Follow the waypoints ahead to the mission's landing, without climbing and without other commands."""
    BACK = "back along the mission"
    """Follow the waypoints back to the take-off without climbing, and land at home."""
    HERE = "here"
    """Land in place."""


@dataclass(frozen=True)
class ReturnRoute:
    """The route of a return and the index of its rally point; None: home, or as `by` says."""

    by: ReturnBy
    rally: int | None = None


@dataclass(frozen=True)
class MissionLanding:
    """A mission's landing: the place of its LAND item, and the number of items ahead and behind.

    `ahead` counts from the current item to DO_LAND_START, else to the LAND item. `behind` counts from the first item.
    """

    place: Place
    ahead: int
    behind: int


@dataclass(frozen=True)
class OverTerrain:
    """A return over terrain: `margin` is the height error [m]; `surely`: it never falls back to heights above home."""

    margin: float
    surely: bool
