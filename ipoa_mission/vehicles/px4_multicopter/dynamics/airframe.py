"""The multirotor that PX4's model flies, and how well it knows where it is: read from recorded flights.

No mission and no parameter tells these, and every airframe has its own (found as docs/lab/flight-time.md says).
"""

import math
from typing import NamedTuple

from ipoa_mission.geometry import GRAVITY, Points
from ipoa_mission.vehicles.learned import LearnedVehicle


class Airframe(NamedTuple):
    """Drag for each m/s of airspeed, per mass [1/s]; the lag of rotors and rate loop [s].

    It lifts off and disarms so much later than modeled [s].
    """

    drag: float
    lag: float
    lift_delay: float = 0.0
    landing_delay: float = 0.0

    def top_speed(self, lean: float) -> float:
        """The level speed [m/s] at which drag meets what a lean [rad] gives in calm air."""
        return GRAVITY * math.tan(lean) / self.drag if self.drag > 0 else math.inf

    def slowing(self, through_air: Points, _axes: Points) -> Points:
        """What the air takes [m/s^2] (n, 3) of a velocity through it (n, 3), however the body stands."""
        return self.drag * through_air


class SensorModel(NamedTuple):
    """How well a vehicle knows where it is, as far as its guidance notices.

    A satellite height comes every `every` s with a standard deviation of `height_noise` m. The speed that is estimated
    does not quite agree with how the estimated place moves: by `drift` m/s level, along each axis, and `drift_up`
    upwards (standard deviations), for about `drift_lasts` s. One that `sees_ground`, by a range finder, crawls to it.
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
#: A vehicle that knows exactly where it is, and sees no ground.
KNOWS = SensorModel(every=math.inf, height_noise=0.0, drift=0.0, drift_up=0.0, drift_lasts=1.0, sees_ground=False)


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """The airframe of a vehicle that was learned; SIH's where nothing is known of it.

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
