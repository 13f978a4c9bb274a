"""In which ways a flight can end, in the words of the field, and in which stages of a mission."""

from enum import StrEnum


class Contingency(StrEnum):
    """What a vehicle does instead of flying on with its mission."""

    RTL = "rtl"
    """It flies home, or to a rally point, as its parameters say: `Autopilot.return_route` and `return_height`."""
    LAND = "land"
    """It brakes and lands where it is."""
    SMART_RTL = "smart_rtl"
    """It flies back along the way that it has flown."""
    HOLD = "hold"
    """It brakes and stays there, until somebody or an empty battery ends that."""
    CONTINUE = "continue"
    """It goes on with what it does."""
    LAND_START = "land_start"
    """It flies to the landing that its mission has, and lands there."""
    TERMINATE = "terminate"
    """The motors stop, and it falls."""
    UNKNOWN = "unknown"
    """Where it goes depends on what is not modeled; the words beside it say on what."""


class FlightStage(StrEnum):
    """What a mission is doing as something happens; vehicles take the same cause otherwise by it."""

    TAKEOFF = "take-off"
    ROUTE = "route"
    RETURN = "return"
    """An item of the mission that returns home, up to its landing."""
    LANDING = "landing"
    """Where an item of the mission comes down to land."""
