"""In what a simulated vehicle flies, and what sort of vehicle it is."""

from dataclasses import dataclass

from ipoa_mission.autopilots.learned import LearnedVehicle
from ipoa_mission.items import LEVEL, Ground
from ipoa_mission.wind import CALM, Wind


@dataclass(frozen=True)
class Conditions:
    """The wind, the ground's height above home, and what was learned of the vehicle; None: the simulators' own."""

    wind: Wind = CALM
    ground: Ground = LEVEL
    vehicle: LearnedVehicle | None = None


USUAL = Conditions()
