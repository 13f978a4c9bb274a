"""The simulated multirotor of PX4 and its sensor errors, fitted to recorded flights (docs/lab/flight-time.md).

No mission and no parameter contains these values, and they differ between airframes.
"""

import math
from typing import NamedTuple

from ipoa_mission.geometry import GRAVITY, Points
from ipoa_mission.vehicles.learned import LearnedVehicle


class Airframe(NamedTuple):
    """Drag per airspeed and mass [1/s], lag of rotors and rate loop [s], delays of lift-off and disarming [s]."""

    drag: float
    lag: float
    lift_delay: float = 0.0
    landing_delay: float = 0.0

    def top_speed(self, lean: float) -> float:
        """Return the level speed [m/s] at which drag equals the thrust of a lean [rad] in calm air."""
        return GRAVITY * math.tan(lean) / self.drag if self.drag > 0 else math.inf

    def slowing(self, through_air: Points, _axes: Points) -> Points:
        """Return the drag deceleration [m/s^2] (n, 3) of an air velocity (n, 3), independent of attitude."""
        return self.drag * through_air


class SensorModel(NamedTuple):
    """Errors of the position estimate, as far as they affect guidance.

    A GNSS height comes every `every` s with a standard deviation of `height_noise` m. The estimated speed differs from
    the estimated position's motion by `drift` along each level axis, and `drift_up` upwards. These are standard
    deviations [m/s], with a correlation time of `drift_lasts` s. `sees_ground`: by a range finder it
    crawls to the ground.
    """

    every: float
    height_noise: float
    drift: float
    drift_up: float
    drift_lasts: float
    sees_ground: bool


#: PX4's SIH quadrotor (1 kg, drag 1 N s/m): at 45 degrees of lean its drag allows 9.8 m/s level.
SIH = Airframe(drag=1.0, lag=0.06)
SIH_SENSES = SensorModel(every=0.125, height_noise=0.5, drift=0.2, drift_up=0.13, drift_lasts=4.5, sees_ground=True)
#: No position errors, and no range finder.
KNOWS = SensorModel(every=math.inf, height_noise=0.0, drift=0.0, drift_up=0.0, drift_lasts=1.0, sees_ground=False)


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return the airframe of a learned vehicle; None: SIH's.

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
