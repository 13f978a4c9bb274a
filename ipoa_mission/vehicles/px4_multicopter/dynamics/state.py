"""Data types of PX4's flight state and its orders; SI units, east, north, up.

NamedTuples work in plain Python and numba: a step returns a new state. `Order` and `Law`, constant in a flight, are
passed to compiled code as NumPy records of the same names.
"""

import math
from typing import Annotated, NamedTuple

from ipoa_mission.vehicles.px4_multicopter.dynamics.airframe import Airframe, SensorModel
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import WindLevel

GO, TAKE_OFF, LAND = 0, 1, 2  # kinds of orders
ON_LINE, BEYOND, BEFORE, BESIDE, UNKNOWN = 0, 1, 2, 3, 4  # place of the vehicle relative to its leg
NOT_YET = -1.0  # no time yet


class Enu(NamedTuple):
    """A place or a rate of change."""

    east: float
    north: float
    up: float


class Order(NamedTuple):
    """Fly the leg from `start` to `goal`, and on to `beyond` (the goal again: stop there).

    It is done `holds` s after it is reached: within `radius` level and `height_radius`, with the yaw at `heading` [rad]
    unless NaN. `follows_home`: heights are above the estimated home. `may_turn_first`: MPC_YAW_MODE 4 applies. A
    vehicle that has not reached it within `patience` s is lost. At the time `until` [s] it is aborted.
    """

    kind: int
    start: Enu
    goal: Enu
    beyond: Enu
    radius: float
    height_radius: float
    cruise: float
    holds: float = 0.0
    heading: float = math.nan
    may_turn_first: bool = False
    follows_home: bool = True
    patience: float = math.inf
    until: float = math.inf


class Law(NamedTuple):
    """Constants of a flight: limits, vehicle, sensors, wind (towards), and the length of a step.

    Below `gradient_height` the wind is a power law of height with `wind_exponent`. `wind_levels` replace it if the
    first level is below the last. `most_lean`: g tan of the greatest lean. `leaning`, `turning`: shares by which lean
    and rotors approach their setpoints in a step. `turns`: whether the yaw matters.
    """

    limits: Px4Limits
    airframe: Airframe
    senses: SensorModel
    wind_east: float
    wind_north: float
    wind_exponent: float
    gradient_height: float
    wind_levels: Annotated[list[WindLevel], 8]
    dt: float
    most_lean: float
    leaning: float
    turning: float
    turns: bool
    noisy: bool


class Axis(NamedTuple):
    """The smoothed trajectory along one axis."""

    place: float
    speed: float
    acceleration: float


class Trajectory(NamedTuple):
    """The moving setpoint of the controllers."""

    east: Axis
    north: Axis
    up: Axis


class Guidance(NamedTuple):
    """The vehicle's side of its leg, and the place from which it was last led back.

    `held`: limit of the level speed in a turn. `rising`: whether the last setpoint was upwards.
    """

    side: int
    anchor: Enu
    held: float
    rising: bool


class Control(NamedTuple):
    """Integrators of the velocity controller, estimated over true hover thrust, upward acceleration setpoint."""

    integral: Enu
    hover: float
    thrust: float


class Level(NamedTuple):
    """A level vector."""

    east: float
    north: float


class Body(NamedTuple):
    """The vehicle: place, estimated speed, level acceleration, lean setpoint, lean and thrust.

    Lean is the level acceleration at a thrust of one g. Thrust counts above weight. `airborne_since`: the last
    lift-off.
    """

    place: Enu
    speed: Enu
    acceleration: Level
    asked: Level
    thrust: Enu
    on_ground: bool
    airborne_since: float


class Yaw(NamedTuple):
    """Yaw, clockwise from north [rad], NaN if unknown; and its rate."""

    yaw: float
    rate: float


class Errors(NamedTuple):
    """Sensor errors: the estimated height of `home` above its true one, and the later value that guidance was `told`.

    The place moves faster than estimated by `drift`. `next_in`: time to the next fix [s].
    """

    seed_1: float
    seed_2: float
    next_in: float
    home: float
    told: float
    told_at: float
    drift: Enu


class Contact(NamedTuple):
    """A landing: contact, range finder lost, stages of the land detector, and the time of the last stage."""

    stands: bool
    lost: bool
    stages: int
    since: float


class State(NamedTuple):
    """The whole state; times when the order was begun and reached, and whether its place was reached."""

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


ZERO = Enu(0.0, 0.0, 0.0)


def of(place: Enu) -> Enu:
    """Convert a place of an order, which may be a record, to a tuple."""
    return Enu(place.east, place.north, place.up)
