"""PX4's simulated multirotor and sensor errors, fitted to flights (docs/lab/flight-time.md)."""

import math
from typing import NamedTuple

from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.geometry import GRAVITY, Points


class Airframe(NamedTuple):
    """Drag per mass [1/s], lag of rotors and rate loop [s], delays of lift-off and disarming [s]."""

    drag: float
    lag: float
    lift_delay: float = 0.0
    landing_delay: float = 0.0

    def top_speed(self, lean: float) -> float:
        """Return the level speed [m/s] held by a lean [rad] in calm air."""
        return GRAVITY * math.tan(lean) / self.drag if self.drag > 0 else math.inf

    def slowing(self, through_air: Points, _axes: Points) -> Points:
        """Return the drag deceleration [m/s^2] (n, 3) of an air velocity."""
        return self.drag * through_air


class SensorModel(NamedTuple):
    """Errors of the position estimate; standard deviations.

    Each `every` s a GNSS height with `height_noise` [m]. Speed errors `drift` (level axes) and `drift_up` [m/s],
    correlated over `drift_lasts` [s]. `sees_ground`: a range finder.
    """

    every: float
    height_noise: float
    drift: float
    drift_up: float
    drift_lasts: float
    sees_ground: bool


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
