"""ArduPilot's simulated multirotor: drag and response lag, fitted to flights (docs/lab/flight-time.md)."""

import math
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.geometry import GRAVITY, Points

TROPOSPHERE = -500.0, 11_000.0  # altitudes [m]
THINNING = 9.6e-5  # of air density with height [1/m]


class Airframe(NamedTuple):
    rotor_drag: float  # per mass at one g [1/s]; grows with thrust's square root
    body_drag: float  # per mass, along each body axis [1/m]
    lag: float  # of rotors and rate loop [s]
    lift_delay: float = 0.0  # of lift-off [s]
    landing_delay: float = 0.0  # of disarming [s]

    def at_altitude(self, altitude: float) -> "Airframe":
        """Return the airframe at an altitude of home [m].

        >>> round(Airframe(0.25, 0.036, 0.02).at_altitude(1000.0).body_drag, 4)
        0.0327
        """
        low, high = TROPOSPHERE
        density = (1 - 2.25577e-5 * min(max(altitude, low), high)) ** 4.2559 if math.isfinite(altitude) else 1.0
        return self._replace(rotor_drag=self.rotor_drag * math.sqrt(density), body_drag=self.body_drag * density)

    def top_speed(self, lean: float) -> float:
        """Solve (r + q v) v = g tan(lean) for v [m/s], lean [rad]."""
        pull = GRAVITY * math.tan(lean)
        q = self.body_drag * math.cos(lean)
        r = self.rotor_drag / math.sqrt(math.cos(lean))
        if r <= 0 and q <= 0:
            return math.inf
        return 2 * pull / (r + math.sqrt(r**2 + 4 * q * pull))

    def slowing(self, through_air: Points, axes: Points) -> Points:
        """Return the drag deceleration (n, 3) [m/s^2] for `axes` (n, 3, 3): the body's as columns, down last."""
        along = np.einsum("nij,ni->nj", axes, through_air)
        body = np.einsum("nij,nj->ni", axes, along * np.abs(along))
        return np.asarray(self.body_drag * body + self.rotor_drag / np.sqrt(axes[:, 2, 2, None]) * through_air)


#: The built-in quadrotor of 3 kg, at sea level: a lean of 45 degrees holds 15.08 m/s at 593 m AMSL. Rotor drag: 0.2 v
#: sqrt(T rho A), A = 0.385 m^2.
ARDUPILOT_SIMULATOR = Airframe(rotor_drag=0.2484, body_drag=0.0356, lag=0.02)


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return the learned airframe, or the simulator's.

    >>> airframe_of(None) is ARDUPILOT_SIMULATOR
    True
    """
    if vehicle is None:
        return ARDUPILOT_SIMULATOR
    drag = vehicle.value("drag", 1.0)
    same = ARDUPILOT_SIMULATOR
    return Airframe(
        same.rotor_drag * drag,
        same.body_drag * drag,
        vehicle.value("lag", same.lag),
        vehicle.value("lift_delay", 0.0),
        vehicle.value("landing_delay", 0.0),
    )
