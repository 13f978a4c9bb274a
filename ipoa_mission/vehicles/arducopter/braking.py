"""How ArduCopter comes to a stand: LAND and BRAKE slow down what its position controller wants, within its jerk.

Read in 4.8.0-dev (AC_PosControl::input_vel_accel_NE_m, shape_vel_accel_xy, ModeLand, ModeBrake) and flown: LAND takes
over the speed and the acceleration of the path that it leaves, BRAKE begins with those of the vehicle, and no
acceleration. RTL and SmartRTL fly to a stopping point instead.
"""

import math
from typing import NamedTuple

import numpy as np

from ipoa_mission.geometry import Points, Vector

STEP = 0.02  # [s]
AT_ONCE = 8000  # so many at once stay where they are quick to reach
LASTS = 12.0  # longer than any braking from 20 m/s [s]
BRAKES_WITH = 7.5  # BRAKE_MODE_DECEL_RATE [m/s^2]
LAND_LEADS = 0.25  # the speed that its path asks for is that of the vehicle so much later, as flown [s]


class Shaping(NamedTuple):
    """The most acceleration [m/s^2] and jerk [m/s^3] with which a wanted speed is changed."""

    accel: float
    jerk: float

    def wanted(self, speed: Vector) -> Vector:
        """By how much (n,) a speed (n,) [m/s] that is to be nothing is slowed down [m/s^2]."""
        gain = self.jerk / self.accel
        near = self.jerk / gain**2
        root = np.sqrt(2.0 * self.jerk * np.maximum(speed - near / 2.0, 0.0))
        return np.minimum(np.where(speed <= near, gain * speed, root), self.accel)

    def way(self, velocity: Points, accel: Points) -> Points:
        """From velocity and acceleration (n, 2) to rest, (n, 2) [m]."""
        parts = (slice(n, n + AT_ONCE) for n in range(0, len(velocity), AT_ONCE))
        ways = [self._way(velocity[part].T.copy(), accel[part].T.copy()).T for part in parts]
        return np.concatenate([np.zeros((0, 2)), *ways])

    def _way(self, velocity: Points, accel: Points) -> Points:
        """The same with the axes (2, n) one after the other, which is quicker."""
        way, most = np.zeros_like(velocity), self.jerk * STEP
        for _ in range(math.ceil(LASTS / STEP)):
            speed = np.hypot(*velocity)
            slowed = -velocity * (self.wanted(speed) / np.maximum(speed, 1e-9)) - accel
            accel = accel + slowed * np.minimum(most / np.maximum(np.hypot(*slowed), 1e-9), 1.0)
            way = way + velocity * STEP
            velocity = velocity + accel * STEP
        return way
