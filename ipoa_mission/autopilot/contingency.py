from enum import StrEnum


class Contingency(StrEnum):
    """An action that replaces the rest of the mission."""

    RTL = "rtl"
    """Home or a rally point, by `Autopilot.return_route` and `return_height`."""
    LAND = "land"
    """In place."""
    SMART_RTL = "smart_rtl"
    """Back along the flown path."""
    HOLD = "hold"
    """Until a new order or an empty battery."""
    CONTINUE = "continue"
    LAND_START = "land_start"
    """To the mission's landing."""
    TERMINATE = "terminate"
    """The motors stop; the vehicle falls."""
    UNKNOWN = "unknown"
    """Not modeled; see the action's `words`."""


class FlightStage(StrEnum):
    TAKEOFF = "take-off"
    ROUTE = "route"
    RETURN = "return"
    LANDING = "landing"
