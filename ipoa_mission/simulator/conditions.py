from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.autopilot.version import Version
from ipoa_mission.wind import CALM, Wind
from ipoa_mission.world.ground import LEVEL, Ground


@dataclass(frozen=True)
class Conditions:
    """Ground is the height above home [m].

    `vehicle`: properties learned from logs. `version`: None: the newest measured.
    """

    wind: Wind = CALM
    ground: Ground = LEVEL
    vehicle: LearnedVehicle | None = None
    version: Version | None = None


USUAL = Conditions()


Triple: TypeAlias = tuple[float, float, float]  # east, north, up


class SimulatedVehicle:
    """Position [m] and velocity [m/s] are east, north, up; lean is the level acceleration g tan(angle) [m/s^2]; yaw
    [rad].
    """

    def __init__(self, conditions: Conditions = USUAL) -> None:
        self.conditions = conditions
        self.x = self.y = self.z = 0.0
        self.vx = self.vy = self.vz = 0.0
        self.lean_x = self.lean_y = 0.0
        self.yaw = 0.0
        self.on_ground = True

    @property
    def place(self) -> Triple:
        return self.x, self.y, self.z

    @property
    def motion(self) -> Triple:
        return self.vx, self.vy, self.vz
