"""What PX4's flight is made of at one moment, and what it is asked to do; all in SI units, east, north, up.

Tuples with names, which plain Python and numba take alike: a step makes a new state of the last one. What does not
change in a flight, `Order` and `Law`, goes to compiled code as numpy records of the same names.
"""

import math
from typing import Annotated, NamedTuple

from ipoa_mission.vehicles.px4_multicopter.dynamics.airframe import Airframe, SensorModel
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits
from ipoa_mission.wind import WindLevel

GO, TAKE_OFF, LAND = 0, 1, 2  # what an order asks for
ON_LINE, BEYOND, BEFORE, BESIDE, UNKNOWN = 0, 1, 2, 3, 4  # where the vehicle is, seen from its leg
NOT_YET = -1.0  # a time that has not come


class Enu(NamedTuple):
    """A place, or how something changes."""

    east: float
    north: float
    up: float


class Order(NamedTuple):
    """To fly the leg from `start` to `goal`, and on to `beyond` (the goal again: to stop there).

    It is done `holds` s after it is reached: by being within `radius` level and `height_radius`, with the nose along
    `heading` [rad] if that is a number. `follows_home`: its heights are over home, wherever that is believed to be.
    `may_turn_first`: MPC_YAW_MODE 4 counts here. Who has not reached it within `patience` s is lost. At the time
    `until` [s] it is over, whatever came of it.
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
    """What stays the same for a whole flight: limits, vehicle, sensors, wind (towards), and the length of a step.

    Below `gradient_height` the wind follows a power law of the height with `wind_exponent`; with `wind_levels` of which
    the first lies below the last it is as they say.
    `most_lean` is g tan of the greatest one. `leaning`, `turning`: by what share the lean and the rotors follow what is
    asked of them within a step. `turns`: whether it matters where the nose points.
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
    """The moving setpoint that the controllers follow."""

    east: Axis
    north: Axis
    up: Axis


class Guidance(NamedTuple):
    """Where the vehicle is seen from its leg, and from where it was last led back.

    `held`: the level speed that a turn may not exceed; `rising`: whether it was last led upwards.
    """

    side: int
    anchor: Enu
    held: float
    rising: bool


class Control(NamedTuple):
    """Integrators of the velocity controller; believed over true thrust to hover; acceleration asked for upwards."""

    integral: Enu
    hover: float
    thrust: float


class Level(NamedTuple):
    """What has no part upwards."""

    east: float
    north: float


class Body(NamedTuple):
    """The vehicle: place, believed speed, level acceleration; what lean and thrust are asked for and had.

    Lean is the level acceleration that it gives at a thrust of one g; thrust is counted over weight. `airborne_since`:
    when it last left the ground.
    """

    place: Enu
    speed: Enu
    acceleration: Level
    asked: Level
    thrust: Enu
    on_ground: bool
    airborne_since: float


class Yaw(NamedTuple):
    """Where it points, clockwise from north [rad], NaN where nobody knows; and how fast that changes."""

    yaw: float
    rate: float


class Errors(NamedTuple):
    """What the sensors get wrong: `home` is believed that high over its place, and the guidance `told` so, later.

    The place moves by `drift` faster than is believed. `next_in`: until the next fix [s].
    """

    seed_1: float
    seed_2: float
    next_in: float
    home: float
    told: float
    told_at: float
    drift: Enu


class Contact(NamedTuple):
    """A landing: whether it stands, has lost the ground from sight; stages of being sure, and since when the last."""

    stands: bool
    lost: bool
    stages: int
    since: float


class State(NamedTuple):
    """All of it; when the order was begun and reached, and whether its place has been."""

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
    """A place of an order as a tuple, which a record is not."""
    return Enu(place.east, place.north, place.up)
