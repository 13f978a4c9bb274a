"""Contingencies of a flight and the stages of a mission."""

from enum import StrEnum


class Contingency(StrEnum):
    """An action that replaces the rest of the mission."""

    RTL = "rtl"
    """Fly home or to a rally point, by `Autopilot.return_route` and `return_height`."""
    LAND = "land"
    """Brake and land in place."""
    SMART_RTL = "smart_rtl"
    """Fly back along the flown path."""
    HOLD = "hold"
    """Brake and hold until a new order or an empty battery."""
    CONTINUE = "continue"
    """Continue the mission."""
    LAND_START = "land_start"
    """Fly to the mission's landing and land there."""
    TERMINATE = "terminate"
    """Stop the motors; the vehicle falls."""
    UNKNOWN = "unknown"
    """The path depends on something not modeled, which the action's `words` name."""


class FlightStage(StrEnum):
    """The stage of a mission; the response to a cause may depend on it."""

    TAKEOFF = "take-off"
    ROUTE = "route"
    RETURN = "return"
    """A return item of the mission, up to its landing."""
    LANDING = "landing"
    """A landing item of the mission: the descent."""
