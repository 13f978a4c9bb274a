"""ArduCopter's legs between two places: straight ones with an S-curve, splines with tangents; and as flat numbers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ipoa_mission.autopilots.ardupilot import CopterLimits
from ipoa_mission.itinerary.copter_spline import Place, cubic, minus, spline_tangents
from ipoa_mission.timing._ardupilot_steps import along_limit, bend
from ipoa_mission.timing.scurve import Limits, Profile, change, profile

STRAIGHT, SPLINE, NOTHING = 0.0, 1.0, -1.0
NO_LEG = (NOTHING, *[0.0] * 19)
AT_REST = Profile((), 0.0, 0.0, 0.0, 0.0)
SPLINE_SHARE = 0.5  # of the acceleration limits that a spline leg uses, along the curve and across it


@dataclass(frozen=True)
class Speeds:
    """The speeds in force: the parameters', or what DO_CHANGE_SPEED has set [m/s]."""

    level: float
    climb: float
    descent: float


@dataclass(frozen=True)
class Leg:
    """A leg: straight if it has a `shape`, a spline if it has `tangents`; a spline leaves at up to `leave` [m/s]."""

    origin: Place
    target: Place
    speeds: Speeds
    copter: CopterLimits
    shape: Profile | None = None
    tangents: tuple[Place, Place] | None = None
    leave: float = 0.0

    @property
    def length(self) -> float:
        """Straight from end to end [m]."""
        return math.dist(self.origin, self.target)

    @property
    def limits(self) -> Limits:
        """The most along the straight leg that keeps its level and its vertical part within their limits."""
        return limits_along(self.origin, self.target, self.speeds, self.copter)


def limits_along(origin: Place, target: Place, speeds: Speeds, copter: CopterLimits) -> Limits:
    """The largest speed and acceleration along the way whose level and vertical parts keep their limits."""
    length = math.dist(origin, target)
    if length < 1e-9:
        return Limits(speeds.level, copter.accel, copter.jerk, copter.snap)
    x, y, z = ((b - a) / length for a, b in zip(origin, target, strict=True))
    speed = float(along_limit(x, y, z, speeds.level, speeds.climb, speeds.descent))
    accel = float(along_limit(x, y, z, copter.accel, copter.accel_z, copter.accel_z))
    return Limits(speed, accel, copter.jerk, copter.snap)


def straight_leg(
    origin: Place, target: Place, speeds: Speeds, copter: CopterLimits, enter: float = 0.0, leave: float = 0.0
) -> Leg:
    """A straight leg; it starts and ends at rest, or next to a spline at the speeds given."""
    length = math.dist(origin, target)
    limits = limits_along(origin, target, speeds, copter)
    shape = profile(length, limits, enter, leave) if length > 1e-6 else AT_REST
    return Leg(origin, target, speeds, copter, shape)


def spline_leg(
    origin: Place,
    target: Place,
    previous: Leg | None,
    after: tuple[Place, bool] | None,
    speeds: Speeds,
    copter: CopterLimits,
) -> Leg:
    """A curve that begins as the leg before ended and ends towards `after`, as `spline_tangents` has it."""
    flown_in = None
    if previous is not None:
        flown_in = previous.tangents[1] if previous.tangents else minus(previous.target, previous.origin)
    tangents = spline_tangents(origin, target, flown_in, after)
    return Leg(origin, target, speeds, copter, tangents=tangents)


def joined(this: Leg, following: Leg) -> Leg:
    """`this` with the speed at its end agreed with the next leg, where one of the two is a spline."""
    if this.shape is not None and following.shape is not None:
        return this
    speed = _speed_at(following, 0.0)
    if this.shape is None:
        return replace(this, leave=min(speed, _speed_at(this, 1.0)))
    return straight_leg(this.origin, this.target, this.speeds, this.copter, leave=speed)


def at_speeds(leg: Leg, speeds: Speeds, elapsed: float) -> Leg:
    """The leg with other speeds in force, `elapsed` s after its start."""
    if speeds == leg.speeds:
        return leg
    changed = replace(leg, speeds=speeds)
    if leg.shape is None:
        return changed
    return replace(changed, shape=change(leg.shape, elapsed, leg.length, changed.limits))


def as_numbers(leg: Leg) -> Sequence[float]:
    """The leg for the stepping code.

    0 kind, 1-3 origin, 4-6 direction, 7 length, 8 duration, 9 braking begins, 10 acceleration ends, 11 segments,
    13 speed at the end, 14-18 limits (level, climb, descent; acceleration level, vertical), 20- segments or the cubic.
    """
    length = leg.length
    unit = [x / length for x in minus(leg.target, leg.origin)] if length > 1e-9 else [0.0, 0.0, 0.0]
    speeds, copter, shape = leg.speeds, leg.copter, leg.shape
    share = SPLINE_SHARE if shape is None else 1.0
    limits = (speeds.level, speeds.climb, speeds.descent, share * copter.accel, share * copter.accel_z, 0.0)
    if shape is None:
        assert leg.tangents is not None
        coefficients = cubic(leg.origin, leg.target, leg.tangents)
        return [SPLINE, *leg.origin, *unit, length, 0.0, 0.0, 0.0, 0.0, 0.0, leg.leave, *limits, *coefficients]
    times = (shape.lasts, shape.falls, shape.risen, float(len(shape.segments)))
    numbers = [STRAIGHT, *leg.origin, *unit, length, *times, 0.0, 0.0, *limits]
    for s in shape.segments:
        numbers += (s.begin, s.lasts, s.shape, s.jerk, s.accel, s.speed, s.way)
    return numbers


def _speed_at(leg: Leg, end: float) -> float:
    """The speed at which a leg can be entered (end 0) or left (end 1): the bend's, or a straight leg's peak."""
    return leg.shape.peak if leg.shape is not None else float(bend(as_numbers(leg), end)[7])
