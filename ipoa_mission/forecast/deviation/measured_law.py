from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.deviation.law import DeviationLaw


def not_measured(autopilot: Autopilot, wind: float) -> str | None:
    """Return why the law is extrapolated in this wind [m/s]; None if it was measured."""
    strongest = autopilot.part(DeviationLaw).strongest
    if wind <= strongest:
        return None
    flown = f"the deviation of {autopilot.firmware_name} was measured in wind up to {strongest:g} m/s"
    return f"{flown}: the clearance in {wind:g} m/s is extrapolated"


def law_of(autopilot: Autopilot, wind: float = 0.0) -> DeviationLaw:
    return autopilot.part(DeviationLaw).in_wind(wind)
