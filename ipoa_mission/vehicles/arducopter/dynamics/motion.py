"""What the stepping code works on: a leg, the tuning, the state of a flight.

The types are such that plain Python and numba read the same lines: what is only read is a NamedTuple, and what changes
is an object with attributes; for numba legs and states are records with the same names.
"""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.arducopter.dynamics.airframe import Airframe
from ipoa_mission.vehicles.arducopter.dynamics.scurve import AT_REST, Profile
from ipoa_mission.vehicles.arducopter.limits import CopterLimits
from ipoa_mission.wind import MOST_LEVELS, Wind

STEP = 0.02  # [s]
ASTRAY, ASTRAY_S = 30.0, 3.0  # so far from its target, and so many seconds of flight, no copter falls behind in calm
STANDING_SHARE = 0.05  # of the speed: a target that is slower does not turn the nose

#: Kinds of legs; CLIMB and DESCENT are those of take-off and landing, which no S-curve shapes. An ORBIT is a circle,
#: LEVEL_OFF the end of LOITER_TO_ALT.
NOTHING, STRAIGHT, SPLINE, CLIMB, DESCENT, HOLD, ORBIT, LEVEL_OFF = -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0


class Vector(NamedTuple):
    """East, north, up."""

    x: float
    y: float
    z: float


ZERO = Vector(0.0, 0.0, 0.0)


class MotionLimits(NamedTuple):
    """The most level, upwards and downwards: of speed [m/s], or of acceleration [m/s^2]."""

    level: float
    up: float
    down: float


class Orbit(NamedTuple):
    """A circle of a `radius` [m]; the rate of turn is up to `spin` [rad/s], and grows by `spin_up` [rad/s^2]."""

    radius: float
    spin: float
    spin_up: float


NO_ORBIT = Orbit(0.0, 0.0, 0.0)


class CopterLeg(NamedTuple):
    """From `origin` to `target` at up to `speeds`: straight with a `profile`, along a `cubic`, or straight up or down.

    A spline keeps `accel` and leaves at up to `leave` [m/s]; its tangent there is `end`. A HOLD `lasts` [s].
    A straight leg with a `turn` [rad] is an arc: by so much it turns around its `center`, clockwise positive, and so
    does an `orbit`. One that `ends_near` (1) is over within the acceptance radius of its target, under way or not. A
    DESCENT with a speed to `leave` begins in motion.
    """

    kind: float
    origin: Vector
    target: Vector
    direction: Vector
    length: float
    speeds: MotionLimits
    profile: Profile = AT_REST
    cubic: Annotated[list[Vector], 4] = [ZERO] * 4
    end: Vector = ZERO
    accel: MotionLimits = MotionLimits(0.0, 0.0, 0.0)
    leave: float = 0.0
    lasts: float = 0.0
    turn: float = 0.0
    center: Vector = ZERO
    orbit: Orbit = NO_ORBIT
    ends_near: float = 0.0


NO_LEG = CopterLeg(NOTHING, ZERO, ZERO, ZERO, 0.0, MotionLimits(0.0, 0.0, 0.0))


Level = tuple[float, float, float]
Levels = tuple[Level, Level, Level, Level, Level, Level, Level, Level]


class Tuning(NamedTuple):
    """The constants of a flight; shares are those of a first-order lag within one step."""

    radius: float
    corner_accel: float
    accel: float
    shaping_jerk: float
    accel_z: float
    jerk_z: float
    land_low: float
    land_speed: float
    land_speed_high: float
    p_position: float
    p_velocity: float
    i_velocity: float
    d_velocity: float
    p_height: float
    most_lean: float
    smoothing: float  # share: of the velocity error
    leaning: float  # share: of the lean that is asked for
    turning: float  # share: of the lean itself
    slowing: float  # share: of the path's clock
    rotor_drag: float
    body_drag: float
    wind_east: float
    wind_north: float
    wind_exponent: float
    gradient_height: float
    wind_levels: Levels  # a profile in place of all that, where the first lies below the last
    slew: float  # of the nose, in one step [rad]; 0: it keeps its heading
    most_astray: float  # a copter that is farther from its target is blown off its path [m]
    turning_from: float  # the nose follows a target that moves at more than this [m/s]
    brakes_climb: float  # 1: with all of its acceleration, as since 4.8; 0: with half of it


def levels_of(wind: Wind) -> Levels:
    """Height, and what it blows towards the east and the north there, the last level repeated; all 0 of no profile."""
    given = [tuple(level) for level in wind.levels] or [(0.0, 0.0, 0.0)]
    return tuple(given + given[-1:] * (MOST_LEVELS - len(given)))  # type: ignore[return-value]


def tuning(limits: CopterLimits, airframe: Airframe, wind: Wind) -> Tuning:
    """What the parameters, the airframe and the wind come to."""

    def share(lag: float) -> float:
        return 1 - math.exp(-STEP / lag)

    return Tuning(
        limits.radius,
        limits.corner_accel,
        limits.accel,
        limits.shaping_jerk,
        limits.accel_z,
        limits.jerk_z,
        limits.land_low,
        limits.land_speed,
        limits.land_speed_high,
        limits.p_position,
        limits.p_velocity,
        limits.i_velocity,
        limits.d_velocity,
        limits.p_height,
        most_lean=GRAVITY * math.tan(limits.lean),
        smoothing=share(1 / (2 * math.pi * limits.velocity_filter)),
        leaning=share(limits.lean_lag),
        turning=share(airframe.lag),
        slowing=share(max(limits.accel / limits.jerk, STEP)),
        rotor_drag=airframe.rotor_drag,
        body_drag=airframe.body_drag,
        wind_east=wind.east,
        wind_north=wind.north,
        wind_exponent=wind.exponent,
        gradient_height=wind.gradient_height,
        wind_levels=levels_of(wind),
        slew=limits.yaw_rate * STEP,
        most_astray=ASTRAY + ASTRAY_S * limits.speed if wind.speed > 0 else math.inf,
        turning_from=STANDING_SHARE * limits.speed,
        brakes_climb=float(limits.brakes_climb),
    )


@dataclass(slots=True)
class State:
    """A flight at one moment: the vehicle (east, north, up), its controllers, the path's clock and its target."""

    time: float = 0.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    vz: float = 0.0
    ax: float = 0.0
    ay: float = 0.0
    az: float = 0.0
    asked_x: float = 0.0  # the lean asked for, as level acceleration: g tan(angle)
    asked_y: float = 0.0
    shaped_x: float = 0.0  # what the attitude controller makes of it
    shaped_y: float = 0.0
    lean_x: float = 0.0
    lean_y: float = 0.0
    load: float = 1.0  # what the rotors carry of the weight; the air the rest
    yaw: float = 0.0  # clockwise from north
    nose_x: float = 0.0  # its unit vector
    nose_y: float = 1.0
    error_x: float = 0.0  # filtered error of velocity, and its integral
    error_y: float = 0.0
    integral_x: float = 0.0
    integral_y: float = 0.0
    rate: float = 1.0  # of the path's clock
    clock_before: float = 0.0  # on the leg before, on this one and on the next [s]
    clock: float = 0.0
    clock_next: float = 0.0
    share: float = 0.0  # of a spline
    bearing: float = 0.0  # from the center of an orbit to where it began
    spin: float = 0.0  # the rate of turn on it, and how far it has turned [rad]
    turned: float = 0.0
    above: float = 0.0  # how much higher it was than it has to be [m]
    speed: float = 0.0  # of the target
    target_x: float = 0.0
    target_y: float = 0.0
    target_z: float = 0.0
    aim_x: float = 0.0  # velocity of the target
    aim_y: float = 0.0
    aim_z: float = 0.0
    push_x: float = 0.0  # and its acceleration
    push_y: float = 0.0
