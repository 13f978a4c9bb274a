"""How far a multicopter still flies when a mission is broken off, by pause, RTL or a failsafe."""

import numpy as np

from ipoa_mission.autopilots.ardupilot import copter_limits
from ipoa_mission.autopilots.px4 import px4_limits
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters
from ipoa_mission.geometry import Vector

#: For so long each flies on along its mission before it begins to brake, at most [s]. As flown: docs/safety.md.
REACTION = {Autopilot.ARDUPILOT: 0.1, Autopilot.PX4: 0.6}


def braking_distance(autopilot: Autopilot, parameters: Parameters, speed: Vector, accel: Vector) -> Vector:
    """The way straight on from where braking begins at `speed` (n,) [m/s], gaining `accel` (n,) [m/s^2], (n,) [m].

    ArduCopter aims at where its position controller can stop it (its stopping point), PX4 brakes with MPC_ACC_HOR,
    to which it changes by MPC_JERK_AUTO.

    >>> braking_distance(Autopilot.ARDUPILOT, {"WPNAV_ACCEL": 250.0}, np.array([10.0]), np.zeros(1)).round(2)
    array([21.25])
    """
    if autopilot is Autopilot.ARDUPILOT:
        copter = copter_limits(parameters)
        near = copter.accel / copter.p_position**2
        return np.where(speed <= near, speed / copter.p_position, near / 2 + speed**2 / (2 * copter.accel))
    px4 = px4_limits(parameters)
    brakes, gains = px4.accel, np.clip(accel, 0.0, px4.accel)
    turns = (gains + brakes) / px4.jerk  # seconds until it brakes with all it may
    slowed = np.maximum(speed + (gains - brakes) * turns / 2, 0.0)
    turning = turns * (speed + turns * (gains / 2 - px4.jerk * turns / 6))
    return np.asarray(turning + slowed**2 / (2 * brakes))
