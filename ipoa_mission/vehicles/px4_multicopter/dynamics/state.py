"""PX4's orders, flight state, body in wind, and sensor errors; SI units, east, north, up.

Numba gets `Order` and `SimulationConstants` as records of the same names. From 1.17 on (pull request 25003), for two
minutes after take-off, home and waypoints move if the measured height differs by 1 m. The navigator knows at once, the
guidance later.
"""

import math
from typing import NamedTuple

from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics.airframe import Airframe, SensorModel
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import WindTable, wind_at

CORRECTED_BEYOND, CORRECTED_FOR = 1.0, 120.0  # [m, s]
NOTICED_S = 0.075  # half the navigator's cycle, and the setpoint's latency [s]
#: Two congruences (L'Ecuyer, 1988) with products exact in floating point.
FACTOR, MODULUS = 40014.0, 2147483563.0
FACTOR_2, MODULUS_2 = 40692.0, 2147483399.0
GO, TAKE_OFF, LAND = 0, 1, 2  # orders
ON_LINE, BEYOND, BEFORE, OFF_LINE, UNKNOWN = 0, 1, 2, 3, 4
NOT_YET, NOT_BEGUN = -1.0, -1


class Enu(NamedTuple):
    east: float
    north: float
    up: float


class Order(NamedTuple):
    """Fly from `start` to `goal`, and on to `beyond` (the goal: stop).

    Done `hold_s` after arrival: `radius`, `height_radius`, `heading` [rad] unless NaN. `follows_home`: above the
    estimated home. `may_turn_first`: MPC_YAW_MODE 4. Lost after `patience` s.
    """

    kind: int
    start: Enu
    goal: Enu
    beyond: Enu
    radius: float
    height_radius: float
    cruise: float
    hold_s: float = 0.0
    heading: float = math.nan
    may_turn_first: bool = False
    follows_home: bool = True
    patience: float = math.inf


class SimulationConstants(NamedTuple):
    """Constants of a flight: limits, vehicle, sensors, wind, step.

    `most_lean`: g tan. `leaning`, `turning`: shares per step. `turns`: the yaw matters.
    """

    limits: Px4Limits
    airframe: Airframe
    senses: SensorModel
    wind: WindTable
    dt: float
    most_lean: float
    leaning: float
    turning: float
    turns: bool
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
    """`held`: speed limit in a turn. `rising`: the last setpoint."""

    side: int
    anchor: Enu
    held: float
    rising: bool


class Control(NamedTuple):
    """Velocity integrators, estimated over true hover thrust, upward setpoint."""

    integral: Enu
    hover: float
    thrust: float


class Level(NamedTuple):
    east: float
    north: float


class Body(NamedTuple):
    """Place, estimated speed, level acceleration, lean setpoint, lean, thrust.

    Lean is acceleration at one g; thrust counts above weight.
    """

    place: Enu
    speed: Enu
    acceleration: Level
    asked: Level
    thrust: Enu
    on_ground: bool
    airborne_since: float


class Yaw(NamedTuple):
    """Clockwise from north [rad], NaN: unknown; and its rate."""

    yaw: float
    rate: float


class Errors(NamedTuple):
    """Error of `home`'s height, now and as `reported` to guidance; `drift`; next fix [s]."""

    seed_1: float
    seed_2: float
    next_in: float
    home: float
    reported: float
    reported_at: float
    drift: Enu


class Contact(NamedTuple):
    """A landing: stages of the land detector and the last one's time."""

    on_ground: bool
    lost: bool
    stages: int
    since: float


class State(NamedTuple):
    time: float
    body: Body
    nose: Yaw
    trajectory: Trajectory
    guidance: Guidance
    control: Control
    errors: Errors
    contact: Contact
    begun: float
    reached: float
    been_there: bool


class FlightProgress(NamedTuple):
    """A flight's state, steps of its order or NOT_BEGUN, touchdown [s] or NOT_YET."""

    state: State
    steps: int
    touched: float


ZERO = Enu(0.0, 0.0, 0.0)


def as_tuple(place: Enu) -> Enu:
    """Return a place, which may be a record of Numba, as a tuple."""
    return Enu(place.east, place.north, place.up)


def normal(first: float, second: float) -> tuple[float, float, float, float]:
    """Return the next seeds, and two normal deviates (Box and Muller)."""
    first, second = remainder(first * FACTOR, MODULUS), remainder(second * FACTOR_2, MODULUS_2)
    size, angle = math.sqrt(-2.0 * math.log(first / MODULUS)), 2.0 * math.pi * second / MODULUS_2
    return first, second, size * math.cos(angle), size * math.sin(angle)


def remainder(value: float, modulus: float) -> float:
    """Return `value % modulus` for a small quotient: exact, and faster compiled."""
    return value - math.floor(value / modulus) * modulus


def no_errors(seed_1: float, seed_2: float) -> Errors:
    return Errors(seed_1, seed_2, 0.0, 0.0, 0.0, NOT_YET, ZERO)


def add_sensor_errors(state: State, constants: SimulationConstants) -> Errors:
    was, time = state.errors, state.time + constants.dt
    if not constants.noisy:
        return was
    reported, reported_at = was.reported, was.reported_at
    if reported_at >= 0.0 and time >= reported_at:
        reported, reported_at = was.home, NOT_YET
    if was.next_in > constants.dt:
        return Errors(was.seed_1, was.seed_2, was.next_in - constants.dt, was.home, reported, reported_at, was.drift)
    senses = constants.senses
    seed_1, seed_2, n_east, n_north = normal(was.seed_1, was.seed_2)
    seed_1, seed_2, n_up, n_height = normal(seed_1, seed_2)
    kept = math.exp(-senses.every / senses.drift_lasts)
    fresh = math.sqrt(1.0 - kept * kept)
    drift = Enu(
        kept * was.drift.east + fresh * senses.drift * n_east,
        kept * was.drift.north + fresh * senses.drift * n_north,
        kept * was.drift.up + fresh * senses.drift_up * n_up,
    )
    home, measured, flown = was.home, senses.height_noise * n_height, time - state.body.airborne_since
    if flown < CORRECTED_FOR and abs(measured - home) > CORRECTED_BEYOND:
        home = measured
        reported_at = time + NOTICED_S if reported_at < 0.0 else reported_at
    return Errors(seed_1, seed_2, was.next_in - constants.dt + senses.every, home, reported, reported_at, drift)


def integrate(state: State, asked: Enu, constants: SimulationConstants, is_held: bool) -> Body:
    body, drift, dt, drag = state.body, state.errors.drift, constants.dt, constants.airframe.drag
    asked_east = body.asked.east + (asked.east - body.asked.east) * constants.leaning
    asked_north = body.asked.north + (asked.north - body.asked.north) * constants.leaning
    thrust = Enu(
        body.thrust.east + (asked_east - body.thrust.east) * constants.turning,
        body.thrust.north + (asked_north - body.thrust.north) * constants.turning,
        body.thrust.up + (asked.up - body.thrust.up) * constants.turning,
    )
    lift, place, speed, since = 1.0 + thrust.up / GRAVITY, body.place, body.speed, body.airborne_since
    blows_east, blows_north = wind_at(place.up, constants.wind)
    felt_east = thrust.east * lift - drag * (speed.east - blows_east)
    felt_north = thrust.north * lift - drag * (speed.north - blows_north)
    on_ground = is_held or (body.on_ground and thrust.up <= 0.0)
    if is_held:
        speed = Enu(-drift.east, -drift.north, -drift.up)
    elif on_ground:
        since = state.time
    else:
        rise = speed.up + (thrust.up - drag * speed.up) * dt
        speed = Enu(speed.east + felt_east * dt, speed.north + felt_north * dt, rise)
        place = Enu(
            place.east + (speed.east + drift.east) * dt,
            place.north + (speed.north + drift.north) * dt,
            place.up + (speed.up + drift.up) * dt,
        )
    return Body(place, speed, Level(felt_east, felt_north), Level(asked_east, asked_north), thrust, on_ground, since)
