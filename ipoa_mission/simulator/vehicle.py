"""What can be seen of a simulated vehicle: where it is, how it moves and leans, and where its nose points."""


class Vehicle:
    """Place and motion, east, north, up [m, m/s]; lean as the level acceleration g tan(angle) [m/s^2]; yaw [rad]."""

    def __init__(self, wind: tuple[float, float] = (0.0, 0.0)) -> None:
        self.wind = wind  # towards, east and north [m/s]
        self.x = self.y = self.z = 0.0
        self.vx = self.vy = self.vz = 0.0
        self.lean_x = self.lean_y = 0.0
        self.yaw = 0.0
        self.on_ground = True

    @property
    def place(self) -> tuple[float, float, float]:
        """East, north, up [m]."""
        return self.x, self.y, self.z

    @property
    def motion(self) -> tuple[float, float, float]:
        """East, north, up [m/s]."""
        return self.vx, self.vy, self.vz
