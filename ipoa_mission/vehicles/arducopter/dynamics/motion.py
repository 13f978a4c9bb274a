"""Leg, tuning and flight state; numba gets records of the same names."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np

from ipoa_mission.geometry import GRAVITY, ZERO, Enu, Points
from ipoa_mission.vehicles.arducopter.dynamics.scurve import AT_REST, Profile
from ipoa_mission.vehicles.arducopter.limits import CopterLimits
from ipoa_mission.wind import Wind, WindTable

STEP = 0.02  # [s]
ASTRAY = 30.0  # lag in calm air: [m], plus [s] of flight
ASTRAY_S = 3.0
STANDING_SHARE = 0.05  # of the speed: a slower target does not turn the yaw


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

    def top_speed(self, tilt: float) -> float:
        """Solve (r + q v) v = g tan(tilt) for v [m/s], tilt [rad]."""
        pull = GRAVITY * math.tan(tilt)
        q = self.body_drag * math.cos(tilt)
        r = self.rotor_drag / math.sqrt(math.cos(tilt))
        if r <= 0 and q <= 0:
            return math.inf
        return 2 * pull / (r + math.sqrt(r**2 + 4 * q * pull))

    def slowing(self, through_air: Points, axes: Points) -> Points:
        """Return the drag deceleration (n, 3) [m/s^2] for `axes` (n, 3, 3): the body's as columns, down last."""
        along = np.einsum("nij,ni->nj", axes, through_air)
        body = np.einsum("nij,nj->ni", axes, along * np.abs(along))
        return np.asarray(self.body_drag * body + self.rotor_drag / np.sqrt(axes[:, 2, 2, None]) * through_air)


#: The built-in quadrotor of 3 kg, at sea level: a tilt of 45 degrees holds 15.08 m/s at 593 m AMSL. Rotor drag: 0.2 v
#: sqrt(T rho A), A = 0.385 m^2.
ARDUPILOT_SIMULATOR = Airframe(rotor_drag=0.2484, body_drag=0.0356, lag=0.02)


class Kind(IntEnum):
    """Legs; CLIMB and DESCENT have no S-curve, LEVEL_OFF ends LOITER_TO_ALT."""

    NOTHING = -1
    STRAIGHT = 0
    SPLINE = 1
    CLIMB = 2
    DESCENT = 3
    HOLD = 4
    ORBIT = 5
    LEVEL_OFF = 6


class MotionLimits(NamedTuple):
    """Greatest horizontal, upward and downward values [m/s or m/s^2]."""

    horizontal: float
    up: float
    down: float


class Orbit(NamedTuple):
    radius: float  # [m]
    spin: float  # final turn rate [rad/s]
    spin_up: float


NO_ORBIT = Orbit(0.0, 0.0, 0.0)


class CopterLeg(NamedTuple):
    """A leg at up to `speeds`: straight with a `profile`, along a `cubic`, or vertical."""

    kind: int
    origin: Enu
    target: Enu
    direction: Enu
    length: float
    speeds: MotionLimits
    profile: Profile = AT_REST
    cubic: Annotated[list[Enu], 4] = [ZERO] * 4
    end: Enu = ZERO  # tangent of a spline
    accel: MotionLimits = MotionLimits(0.0, 0.0, 0.0)
    leave: float = 0.0  # greatest speed at the end of a spline [m/s]; of a DESCENT: it starts in motion
    lasts: float = 0.0  # of a HOLD [s]
    turn: float = 0.0  # of an arc around `center` [rad, clockwise]
    center: Enu = ZERO
    orbit: Orbit = NO_ORBIT
    ends_near: float = 0.0  # 1: it ends within the acceptance radius


NO_LEG = CopterLeg(Kind.NOTHING, ZERO, ZERO, ZERO, length=0.0, speeds=MotionLimits(0.0, 0.0, 0.0))


class Tuning(NamedTuple):
    """Constants of a flight; shares are of a first-order lag in one step."""

    limits: CopterLimits
    airframe: Airframe
    wind: WindTable
    max_tilt_accel: float
    smoothing: float  # share of the velocity error
    tilt_gain: float  # share of the tilt setpoint
    rotor_gain: float
    time_scale_gain: float
    slew: float  # of the yaw in one step [rad]; 0: fixed
    most_astray: float  # farther from its target it is lost [m]
    turning_from: float  # least target speed that turns the yaw [m/s]


def tuning(limits: CopterLimits, airframe: Airframe, wind: Wind) -> Tuning:
    def share(lag: float) -> float:
        return 1 - math.exp(-STEP / lag)

    blows = wind.table
    return Tuning(
        limits,
        airframe,
        blows._replace(levels=tuple(blows.levels)),
        max_tilt_accel=GRAVITY * math.tan(limits.max_tilt),
        smoothing=share(1 / (2 * math.pi * limits.velocity_filter)),
        tilt_gain=share(limits.tilt_lag),
        rotor_gain=share(airframe.lag),
        time_scale_gain=share(max(limits.accel / limits.jerk, STEP)),
        slew=limits.yaw_rate * STEP,
        most_astray=ASTRAY + ASTRAY_S * limits.speed if wind.speed > 0 else math.inf,
        turning_from=STANDING_SHARE * limits.speed,
    )


@dataclass(slots=True)
class State:
    """A flight at one moment; horizontal vectors are complex: east + north j."""

    time: float = 0.0
    place: complex = 0j
    z: float = 0.0
    velocity: complex = 0j
    vz: float = 0.0
    accel: complex = 0j
    az: float = 0.0
    setpoint: complex = 0j  # tilt setpoint: g tan(angle)
    shaped: complex = 0j  # of the attitude controller
    tilt: complex = 0j
    load: float = 1.0  # share of the weight on the rotors
    yaw: float = 0.0  # clockwise from north
    heading: complex = 1j  # unit vector of the yaw
    error: complex = 0j  # filtered velocity error, and its integral
    integral: complex = 0j
    time_scale: float = 1.0  # of the path's time
    leg_time_before: float = 0.0  # on the previous, this and next leg [s]
    leg_time: float = 0.0
    leg_time_next: float = 0.0
    spline_u: float = 0.0  # parameter of a spline, 0 to 1
    bearing: float = 0.0  # from an orbit's center to its start
    spin: float = 0.0  # turn rate [rad/s] and angle turned [rad]
    turned: float = 0.0
    above: float = 0.0  # over the goal one step ago [m]
    speed: float = 0.0
    target: complex = 0j
    target_z: float = 0.0
    vel_desired: complex = 0j  # of the target, as in AC_PosControl
    vz_desired: float = 0.0
    accel_desired: complex = 0j
