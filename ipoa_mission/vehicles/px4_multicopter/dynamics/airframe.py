"""PX4's simulated multirotor and sensor errors, fitted to flights (docs/lab/flight-time.md)."""

import math
from typing import NamedTuple

from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.geometry import GRAVITY, Points


class Airframe(NamedTuple):
    drag: float  # per mass [1/s]
    lag: float  # of rotors and rate loop [s]
    lift_delay: float = 0.0  # of lift-off [s]
    landing_delay: float = 0.0  # of disarming [s]

    def top_speed(self, lean: float) -> float:
        """Return the level speed [m/s] held by a lean [rad] in calm air."""
        return GRAVITY * math.tan(lean) / self.drag if self.drag > 0 else math.inf

    def slowing(self, through_air: Points, _axes: Points) -> Points:
        """Return the drag deceleration [m/s^2] (n, 3) of an air velocity."""
        return self.drag * through_air


class SensorModel(NamedTuple):
    """Errors of the position estimate; standard deviations."""

    every: float  # between GNSS heights [s]
    height_noise: float  # [m]
    drift: float  # of the speed, level axes [m/s]
    drift_up: float
    drift_lasts: float  # correlation time [s]
    sees_ground: bool  # a range finder


#: SIH's quadrotor (1 kg, drag 1 N s/m): 9.8 m/s at a lean of 45 degrees.
SIH = Airframe(drag=1.0, lag=0.06)
SIH_SENSES = SensorModel(every=0.125, height_noise=0.5, drift=0.2, drift_up=0.13, drift_lasts=4.5, sees_ground=True)
KNOWS = SensorModel(every=math.inf, height_noise=0.0, drift=0.0, drift_up=0.0, drift_lasts=1.0, sees_ground=False)


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return the learned airframe, or SIH's.

    >>> airframe_of(None) is SIH
    True
    """
    if vehicle is None:
        return SIH
    return Airframe(
        SIH.drag * vehicle.value("drag", 1.0),
        vehicle.value("lag", SIH.lag),
        vehicle.value("lift_delay", 0.0),
        vehicle.value("landing_delay", 0.0),
    )
