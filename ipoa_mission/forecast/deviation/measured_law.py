"""What is told of an autopilot's tube: the law of its flights, and in what wind nothing measured stands behind it."""

from ipoa_mission.forecast.deviation.law import DeviationLaw
from ipoa_mission.vehicles.autopilot import Autopilot


def not_measured(autopilot: Autopilot, wind: float) -> str | None:
    """Why nothing measured stands behind the tube in this wind [m/s], in words; None where something does."""
    strongest = autopilot.part(DeviationLaw).strongest
    if wind <= strongest:
        return None
    flown = f"{autopilot.firmware_name}'s tube was measured in wind up to {strongest:g} m/s"
    return f"{flown}: what its flights keep in {wind:g} m/s is extrapolated"


def law_of(autopilot: Autopilot, wind: float = 0.0) -> DeviationLaw:
    """The tube of an autopilot in a wind of this speed [m/s]."""
    return autopilot.part(DeviationLaw).in_wind(wind)
