"""The simulated multirotor of ArduPilot: drag and response lag.

No mission and no autopilot parameter contains these values. They are fitted to the recorded flights (see
docs/lab/flight-time.md). Drag matters little below about 8 m/s, and limits the speed near the greatest lean.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.geometry import GRAVITY, Points
from ipoa_mission.vehicles.learned import LearnedVehicle

TROPOSPHERE = -500.0, 11_000.0  # altitudes [m]
THINNING = 9.6e-5  # relative decrease of air density with height [1/m]


@dataclass(frozen=True)
class Airframe:
    """Drag per mass, `lag` of rotors and rate loop, and later lift-off and disarming than modeled [s].

    Rotor drag is `rotor_drag` times airspeed at a thrust of one g, and grows with the square root of thrust [1/s]. Body
    drag is `body_drag` times airspeed squared, along each body axis [1/m].
    """

    rotor_drag: float
    body_drag: float
    lag: float
    lift_delay: float = 0.0
    landing_delay: float = 0.0

    def at_altitude(self, altitude: float) -> "Airframe":
        """Return the airframe in the standard atmosphere's density at an altitude of home [m].

        >>> round(Airframe(0.25, 0.036, 0.02).at_altitude(1000.0).body_drag, 4)
        0.0327
        """
        low, high = TROPOSPHERE
        density = (1 - 2.25577e-5 * min(max(altitude, low), high)) ** 4.2559 if math.isfinite(altitude) else 1.0
        return replace(self, rotor_drag=self.rotor_drag * math.sqrt(density), body_drag=self.body_drag * density)

    def top_speed(self, lean: float) -> float:
        """Solve (r + q v) v = g tan(lean) for the level speed v [m/s] of a lean [rad] in calm air.

        The leaning body meets v cos(lean), so q is the body's drag times that. The rotors' drag r is that at the
        thrust that carries the leaning vehicle.
        """
        pull, q = GRAVITY * math.tan(lean), self.body_drag * math.cos(lean)
        r = self.rotor_drag / math.sqrt(math.cos(lean))
        if r <= 0 and q <= 0:
            return math.inf
        return 2 * pull / (r + math.sqrt(r**2 + 4 * q * pull))

    def slowing(self, through_air: Points, axes: Points) -> Points:
        """Return the drag deceleration [m/s^2] (n, 3) of an air velocity (n, 3), down last, in level flight.

        `axes` (n, 3, 3): the body's axes as columns. It is `steps.drag`, vectorized.
        """
        along = np.einsum("nij,ni->nj", axes, through_air)
        body = np.einsum("nij,nj->ni", axes, along * np.abs(along))
        return np.asarray(self.body_drag * body + self.rotor_drag / np.sqrt(axes[:, 2, 2, None]) * through_air)


#: ArduPilot's built-in quadrotor of 3 kg: a lean of 45 degrees holds 15.08 m/s at 593 m AMSL. Rotor drag is
#: 0.2 v sqrt(T rho A) with A = 0.385 m^2. The values are for sea level (rho = 1.225 kg/m^3).
ARDUPILOT_SIMULATOR = Airframe(rotor_drag=0.2484, body_drag=0.0356, lag=0.02)


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return the airframe of a learned vehicle; None: the simulator's.

    >>> airframe_of(None) is ARDUPILOT_SIMULATOR
    True
    """
    if vehicle is None:
        return ARDUPILOT_SIMULATOR
    drag, same = vehicle.value("drag", 1.0), ARDUPILOT_SIMULATOR
    return Airframe(
        rotor_drag=same.rotor_drag * drag,
        body_drag=same.body_drag * drag,
        lag=vehicle.value("lag", same.lag),
        lift_delay=vehicle.value("lift_delay", 0.0),
        landing_delay=vehicle.value("landing_delay", 0.0),
    )
