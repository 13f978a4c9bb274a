"""What can be seen of a simulated vehicle: where it is, how it moves and leans, and where its nose points."""

from typing import TypeAlias

from ipoa_mission.simulator.conditions import USUAL, Conditions

Triple: TypeAlias = tuple[float, float, float]  # east, north, up


class Vehicle:
    """Place and motion, east, north, up [m, m/s]; lean as the level acceleration g tan(angle) [m/s^2]; yaw [rad]."""

    def __init__(self, conditions: Conditions = USUAL) -> None:
        self.conditions = conditions
        self.x = self.y = self.z = 0.0
        self.vx = self.vy = self.vz = 0.0
        self.lean_x = self.lean_y = 0.0
        self.yaw = 0.0
        self.on_ground = True

    @property
    def place(self) -> Triple:
        """East, north, up [m]."""
        return self.x, self.y, self.z

    @property
    def motion(self) -> Triple:
        """East, north, up [m/s]."""
        return self.vx, self.vy, self.vz
