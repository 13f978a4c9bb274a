"""PX4's motions, flight state, body in wind, and sensor errors; SI units, east, north, up.

Airframe and errors are fitted to flights (docs/lab/flight-time.md).

Numba gets `Motion` and `SimulationConstants` as records of the same names. From 1.17 on (pull request 25003), for two
minutes after take-off, home and waypoints move if the measured height differs by 1 m. The navigator knows at once, the
guidance later.
"""

import math
from typing import NamedTuple

from ipoa_mission.geometry import GRAVITY, ZERO, Enu, Points, plus, scaled
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import WindTable, wind_velocity

CORRECTED_BEYOND, CORRECTED_FOR = 1.0, 120.0  # [m, s]
NOTICED_S = 0.075  # half the navigator's cycle, and the setpoint's latency [s]
#: Two congruences (L'Ecuyer, 1988) with products exact in floating point.
FACTOR, MODULUS = 40014.0, 2147483563.0
FACTOR_2, MODULUS_2 = 40692.0, 2147483399.0
GO, TAKE_OFF, LAND = 0, 1, 2  # motions
ON_LINE, BEYOND, BEFORE, OFF_LINE, UNKNOWN = 0, 1, 2, 3, 4
NOT_YET, NOT_BEGUN = -1.0, -1


class Airframe(NamedTuple):
    drag: float  # per mass [1/s]
    lag: float  # of rotors and rate loop [s]
    lift_delay: float = 0.0  # of lift-off [s]
    landing_delay: float = 0.0  # of disarming [s]

    def top_speed(self, tilt: float) -> float:
        """Return the horizontal speed [m/s] held by a tilt [rad] in calm air."""
        return GRAVITY * math.tan(tilt) / self.drag if self.drag > 0 else math.inf

    def slowing(self, through_air: Points, _axes: Points) -> Points:
        """Return the drag deceleration [m/s^2] (n, 3) of an air velocity."""
        return self.drag * through_air


class SensorModel(NamedTuple):
    """Errors of the position estimate; standard deviations."""

    every: float  # between GNSS heights [s]
    height_noise: float  # [m]
    drift: float  # of the speed, horizontal axes [m/s]
    drift_up: float
    drift_lasts: float  # correlation time [s]
    sees_ground: bool  # a range finder


#: SIH's quadrotor (1 kg, drag 1 N s/m): 9.8 m/s at a tilt of 45 degrees.
SIH = Airframe(drag=1.0, lag=0.06)
SIH_SENSORS = SensorModel(every=0.125, height_noise=0.5, drift=0.2, drift_up=0.13, drift_lasts=4.5, sees_ground=True)
NOISE_FREE = SensorModel(every=math.inf, height_noise=0.0, drift=0.0, drift_up=0.0, drift_lasts=1.0, sees_ground=False)


class Motion(NamedTuple):
    """Fly from `start` to `goal`: to its radii and heading, and hold."""

    kind: int
    start: Enu
    goal: Enu
    beyond: Enu  # the next goal; this goal: stop
    radius: float
    height_radius: float
    cruise: float
    hold_s: float = 0.0
    heading: float = math.nan  # [rad]; NaN: any
    may_turn_first: bool = False  # by MPC_YAW_MODE 4
    follows_home: bool = True  # heights count from the estimated home
    timeout: float = math.inf  # lost after this time [s]


class SimulationConstants(NamedTuple):
    limits: Px4Limits
    airframe: Airframe
    sensors: SensorModel
    wind: WindTable
    dt: float  # of a step [s]
    max_tilt_accel: float  # g tan(tilt)
    tilt_gain: float  # of first-order lags in one step
    rotor_gain: float
    turns: bool  # the yaw matters
    noisy: bool


class Axis(NamedTuple):
    place: float
    speed: float
    acceleration: float


class Trajectory(NamedTuple):
    """The controllers' setpoint."""

    east: Axis
    north: Axis
    up: Axis


class Guidance(NamedTuple):
    side: int
    anchor: Enu
    held: float  # speed limit in a turn
    rising: bool  # by the last setpoint


class Control(NamedTuple):
    integral: Enu  # of the velocity
    hover: float  # estimated over true hover thrust
    thrust: float  # upward setpoint


class EastNorth(NamedTuple):
    east: float
    north: float


class Body(NamedTuple):
    place: Enu
    speed: Enu  # estimated
    acceleration: EastNorth
    setpoint: EastNorth  # tilt setpoint: acceleration at one g
    thrust: Enu  # tilt, and thrust above weight
    on_ground: bool
    airborne_since: float


class Yaw(NamedTuple):
    angle: float  # clockwise from north [rad]; NaN: unknown
    rate: float


class Errors(NamedTuple):
    seed_1: float
    seed_2: float
    next_in: float  # time until the next fix [s]
    home_height_error: float  # [m]
    reported: float  # the same, as the guidance knows it
    reported_at: float
    drift: Enu


class Contact(NamedTuple):
    on_ground: bool
    lost: bool  # the range finder lost the ground
    stages: int  # of the land detector
    since: float  # time of the last one


class State(NamedTuple):
    time: float
    body: Body
    yaw: Yaw
    trajectory: Trajectory
    guidance: Guidance
    control: Control
    errors: Errors
    contact: Contact
    begun: float
    reached: float
    been_there: bool


class FlightProgress(NamedTuple):
    state: State
    steps: int  # of its motion, or NOT_BEGUN
    touched: float  # time of touchdown [s], or NOT_YET


def as_tuple(place: Enu) -> Enu:
    """Return a place, which may be a record of Numba, as a tuple."""
    return Enu(place.east, place.north, place.up)


def normal(first: float, second: float) -> tuple[float, float, float, float]:
    """Return the next seeds, and two normal deviates (Box and Muller)."""
    first, second = remainder(first * FACTOR, MODULUS), remainder(second * FACTOR_2, MODULUS_2)
    size = math.sqrt(-2.0 * math.log(first / MODULUS))
    angle = 2.0 * math.pi * second / MODULUS_2
    return first, second, size * math.cos(angle), size * math.sin(angle)


def remainder(value: float, modulus: float) -> float:
    """Return `value % modulus` for a small quotient: exact, and faster compiled."""
    return value - math.floor(value / modulus) * modulus


def no_errors(seed_1: float, seed_2: float) -> Errors:
    return Errors(
        seed_1=seed_1, seed_2=seed_2, next_in=0.0, home_height_error=0.0, reported=0.0,
        reported_at=NOT_YET, drift=ZERO,
    )  # fmt: skip


def add_sensor_errors(state: State, constants: SimulationConstants) -> Errors:
    last = state.errors
    time = state.time + constants.dt
    if not constants.noisy:
        return last
    reported, reported_at = last.reported, last.reported_at
    if reported_at >= 0.0 and time >= reported_at:
        reported, reported_at = last.home_height_error, NOT_YET
    if last.next_in > constants.dt:
        return Errors(
            seed_1=last.seed_1, seed_2=last.seed_2, next_in=last.next_in - constants.dt,
            home_height_error=last.home_height_error, reported=reported, reported_at=reported_at, drift=last.drift,
        )  # fmt: skip
    sensors = constants.sensors
    seed_1, seed_2, n_east, n_north = normal(last.seed_1, last.seed_2)
    seed_1, seed_2, n_up, n_height = normal(seed_1, seed_2)
    correlation = math.exp(-sensors.every / sensors.drift_lasts)
    fresh = math.sqrt(1.0 - correlation * correlation)
    drift = Enu(
        correlation * last.drift.east + fresh * sensors.drift * n_east,
        correlation * last.drift.north + fresh * sensors.drift * n_north,
        correlation * last.drift.up + fresh * sensors.drift_up * n_up,
    )
    error = last.home_height_error
    measured = sensors.height_noise * n_height
    flown = time - state.body.airborne_since
    if flown < CORRECTED_FOR and abs(measured - error) > CORRECTED_BEYOND:
        error = measured
        reported_at = time + NOTICED_S if reported_at < 0.0 else reported_at
    return Errors(
        seed_1=seed_1, seed_2=seed_2, next_in=last.next_in - constants.dt + sensors.every,
        home_height_error=error, reported=reported, reported_at=reported_at, drift=drift,
    )  # fmt: skip


def integrate(state: State, setpoint: Enu, constants: SimulationConstants, is_held: bool) -> Body:
    body = state.body
    drift = state.errors.drift
    dt = constants.dt
    drag = constants.airframe.drag
    tilt_east = body.setpoint.east + (setpoint.east - body.setpoint.east) * constants.tilt_gain
    tilt_north = body.setpoint.north + (setpoint.north - body.setpoint.north) * constants.tilt_gain
    thrust = Enu(
        body.thrust.east + (tilt_east - body.thrust.east) * constants.rotor_gain,
        body.thrust.north + (tilt_north - body.thrust.north) * constants.rotor_gain,
        body.thrust.up + (setpoint.up - body.thrust.up) * constants.rotor_gain,
    )
    lift = 1.0 + thrust.up / GRAVITY
    place = body.place
    speed = body.speed
    since = body.airborne_since
    blows_east, blows_north = wind_velocity(place.up, constants.wind)
    felt_east = thrust.east * lift - drag * (speed.east - blows_east)
    felt_north = thrust.north * lift - drag * (speed.north - blows_north)
    on_ground = is_held or (body.on_ground and thrust.up <= 0.0)
    if is_held:
        speed = scaled(drift, -1.0)
    elif on_ground:
        since = state.time
    else:
        rise = speed.up + (thrust.up - drag * speed.up) * dt
        speed = Enu(speed.east + felt_east * dt, speed.north + felt_north * dt, rise)
        place = plus(place, scaled(plus(speed, drift), dt))
    return Body(
        place=place, speed=speed, acceleration=EastNorth(felt_east, felt_north),
        setpoint=EastNorth(tilt_east, tilt_north), thrust=thrust, on_ground=on_ground, airborne_since=since,
    )  # fmt: skip
