"""PX4's flight state and orders; SI units, east, north, up.

Numba gets `Order` and `SimulationConstants` as records of the same names.
"""

import math
from typing import Annotated, NamedTuple

from ipoa_mission.vehicles.px4_multicopter.dynamics.airframe import Airframe, SensorModel
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import WindLevel

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
    """Constants of a flight: limits, vehicle, sensors, wind (towards), step.

    Below `gradient_height` wind is a power law with `wind_exponent`, or `wind_levels` if the first level is below the
    last. `most_lean`: g tan. `leaning`, `turning`: shares per step. `turns`: the yaw matters.
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
    """Error of `home`'s height, now and as `told` to guidance; `drift`; next fix [s]."""

    seed_1: float
    seed_2: float
    next_in: float
    home: float
    told: float
    told_at: float
    drift: Enu


class Contact(NamedTuple):
    """A landing: stages of the land detector and the last one's time."""

    stands: bool
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


class Progress(NamedTuple):
    """A flight's state, steps of its order or NOT_BEGUN, touchdown [s] or NOT_YET."""

    state: State
    steps: int
    touched: float


ZERO = Enu(0.0, 0.0, 0.0)


def of(place: Enu) -> Enu:
    """Convert a record to a tuple."""
    return Enu(place.east, place.north, place.up)
