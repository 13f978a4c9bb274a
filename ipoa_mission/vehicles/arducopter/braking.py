"""ArduCopter's braking path.

Read in 4.8.0-dev (AC_PosControl::input_vel_accel_NE_m, shape_vel_accel_xy, ModeLand, ModeBrake) and flown. LAND starts
with the path's speed and acceleration, BRAKE with the vehicle's speed.
"""

import math
from typing import NamedTuple

import numpy as np

from ipoa_mission.geometry import Points, Vector

STEP = 0.02  # [s]
BATCH_SIZE = 8000  # rows in the cache
BRAKING_LIMIT_S = 12.0  # [s]
BRAKE_ACCEL = 7.5  # BRAKE_MODE_DECEL_RATE [m/s^2]
LAND_LEAD_S = 0.25  # lead of the target's speed, as flown [s]


class Shaping(NamedTuple):
    """Limits of acceleration [m/s^2] and jerk [m/s^3]."""

    accel: float
    jerk: float

    def wanted(self, speed: Vector) -> Vector:
        gain = self.jerk / self.accel
        near = self.jerk / gain**2
        root = np.sqrt(2.0 * self.jerk * np.maximum(speed - near / 2.0, 0.0))
        return np.minimum(np.where(speed <= near, gain * speed, root), self.accel)

    def way(self, velocity: Points, accel: Points) -> Points:
        """Return the displacement to rest, (n, 2) [m]."""
        parts = (slice(n, n + BATCH_SIZE) for n in range(0, len(velocity), BATCH_SIZE))
        ways = [self._way(velocity[part].T.copy(), accel[part].T.copy()).T for part in parts]
        return np.concatenate([np.zeros((0, 2)), *ways])

    def _way(self, velocity: Points, accel: Points) -> Points:
        """`way` with axes first (2, n): faster."""
        way, most = np.zeros_like(velocity), self.jerk * STEP
        for _ in range(math.ceil(BRAKING_LIMIT_S / STEP)):
            speed = np.hypot(*velocity)
            slowed = -velocity * (self.wanted(speed) / np.maximum(speed, 1e-9)) - accel
            accel = accel + slowed * np.minimum(most / np.maximum(np.hypot(*slowed), 1e-9), 1.0)
            way = way + velocity * STEP
            velocity = velocity + accel * STEP
        return way
