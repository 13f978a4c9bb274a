"""How long a vehicle takes on a straight line between two turns, and how much a turn costs: from its own time model."""

from dataclasses import dataclass

from ipoa_mission.mission.items import Mission
from ipoa_mission.wind import CALM, Wind


@dataclass(frozen=True, eq=False)
class LegTimes:
    """Seconds of legs and turns of one vehicle at one speed, in one wind."""

    speed: float

    @classmethod
    def of(cls, mission: Mission, speed: float, height: float = 30.0, wind: Wind = CALM) -> "LegTimes":
        """Those of a mission's vehicle: its home, autopilot, parameters and what was learned count, its items do not.

        Args:
            mission: of the vehicle, with no items or any.
            speed: of DO_CHANGE_SPEED [m/s].
            height: above home [m].
            wind: in which it is flown.

        Raises:
            MissionError: the vehicle has no time model, or does not get on in this wind.
        """
        return cls(speed)
