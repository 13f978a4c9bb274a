"""Plan ArduCopter's legs: straight, arc, spline, vertical, hold and circle, with their speed limits."""

import math
from functools import lru_cache
from typing import NamedTuple

import ipoa_mission.forecast.itinerary.copter_curves as curves
from ipoa_mission.geometry import ZERO, Enu, Place
from ipoa_mission.vehicles.arducopter.dynamics.motion import CopterLeg, Kind, MotionLimits
from ipoa_mission.vehicles.arducopter.dynamics.scurve import AT_REST, SCurveLimits, change, profile
from ipoa_mission.vehicles.arducopter.dynamics.steps import along_limit, spline_at
from ipoa_mission.vehicles.arducopter.limits import CopterLimits

SPLINE_SHARE = 0.5  # of the acceleration limits
ZERO_LENGTH = 1e-6  # [m]


def limits_along(origin: Place, target: Place, speeds: MotionLimits, copter: CopterLimits) -> SCurveLimits:
    """Return the limits along the path, by horizontal and vertical ones."""
    length = math.dist(origin, target)
    if length < 1e-9:
        return SCurveLimits(speeds.horizontal, copter.accel, copter.jerk, copter.snap)
    direction = Enu(*((b - a) / length for a, b in zip(origin, target, strict=True)))
    accel = along_limit(direction, MotionLimits(copter.accel, copter.accel_z, copter.accel_z))
    return SCurveLimits(along_limit(direction, speeds), accel, copter.jerk, copter.snap)


class Stop(NamedTuple):
    """The destination of a straight leg, an arc or a spline."""

    place: Place
    spline: bool = False
    after: tuple[Place, bool] | None = None  # where a spline goes on to; True: as a spline
    turn: float = 0.0  # of an arc [rad, clockwise]


class Course(NamedTuple):
    enter: float = 0.0  # speed at its start [m/s]
    leave: float = 0.0
    turn: float = 0.0  # of an arc [rad]
    is_changed: bool = False  # its speed, after planning


REST_TO_REST = Course()


@lru_cache(maxsize=256)
def straight_leg(
    origin: Place, target: Place, speeds: MotionLimits, copter: CopterLimits, course: Course = REST_TO_REST
) -> CopterLeg:
    """Return a straight leg, or an arc."""
    leg = leg_between(Kind.STRAIGHT, origin, target, speeds)
    turn = course.turn
    if leg.length <= ZERO_LENGTH:
        return leg
    if curves.is_arc(origin, target, turn):
        center = Enu(*curves.arc_center(origin, target, turn), 0.0)
        leg = leg._replace(turn=turn, center=center, length=curves.arc_length(origin, target, turn))
    limits = _limits_of(leg, copter, course.is_changed)
    return leg._replace(profile=profile(leg.length, limits, course.enter, course.leave))


def _limits_of(leg: CopterLeg, copter: CopterLimits, is_changed: bool) -> SCurveLimits:
    """Return those of the chord; corner acceleration limits an arc's speed unless it `is_changed`."""
    if leg.turn == 0.0:
        return limits_along(leg.origin, leg.target, leg.speeds, copter)
    fastest = math.sqrt(copter.corner_accel * curves.arc_radius(leg.origin, leg.target, leg.turn))
    speeds = leg.speeds._replace(horizontal=min(leg.speeds.horizontal, fastest))
    limits = limits_along(leg.origin, leg.target, speeds, copter)
    if not is_changed:
        return limits
    rise = (leg.target[2] - leg.origin[2]) / leg.length
    return limits._replace(speed=along_limit(Enu(math.sqrt(1.0 - rise * rise), 0.0, rise), leg.speeds))


def spline_leg(
    origin: Place, stop: Stop, previous: CopterLeg | None, speeds: MotionLimits, copter: CopterLimits
) -> CopterLeg:
    """Return a spline that starts tangent to the previous leg (`spline_tangents`)."""
    flown_in = None
    target = stop.place
    if previous is not None:
        flown_in = previous.end if previous.kind == Kind.SPLINE else curves.minus(previous.target, previous.origin)
    tangents = curves.spline_tangents(origin, target, flown_in, stop.after)
    horizontal, vertical = SPLINE_SHARE * copter.accel, SPLINE_SHARE * copter.accel_z
    return leg_between(Kind.SPLINE, origin, target, speeds)._replace(
        cubic=[Enu(*coefficient) for coefficient in curves.cubic(origin, target, tangents)],
        end=Enu(*tangents[1]),
        accel=MotionLimits(horizontal, vertical, vertical),
    )


def upright_leg(kind: Kind, place: Place, height: float, speeds: MotionLimits) -> CopterLeg:
    return leg_between(kind, place, (place[0], place[1], height), speeds)


def hold_leg(place: Place, lasts: float) -> CopterLeg:
    return leg_between(Kind.HOLD, place, place, MotionLimits(0.0, 0.0, 0.0))._replace(lasts=lasts)


def join(this: CopterLeg, following: CopterLeg, copter: CopterLimits, left: float = math.inf) -> CopterLeg:
    """Return `this`, its end speed matched to an adjacent spline; `left`: leave speed of the last spline [m/s]."""
    if this.kind == following.kind == Kind.STRAIGHT:
        return this
    speed = following.profile.peak
    if following.kind != Kind.STRAIGHT:
        _, direction, _, fastest = spline_at(following, 0.0)
        speed = float(fastest)
        if following.kind == Kind.SPLINE:
            brakes = along_limit(direction, following.accel)
            speed = min(speed, math.sqrt(2 * brakes * following.length + left**2))
    if this.kind == Kind.SPLINE:
        return this._replace(leave=min(speed, _speed_at(this, 1.0)))
    return straight_leg(this.origin, this.target, this.speeds, copter, Course(leave=speed, turn=this.turn))


def speed_left(leg: CopterLeg) -> float:
    """Return the speed at a spline's end [m/s]."""
    return _speed_at(leg, 1.0) if any(leg.end) else 0.0


def at_speeds(leg: CopterLeg, speeds: MotionLimits, elapsed: float, copter: CopterLimits) -> CopterLeg:
    """Return the leg with other speeds from `elapsed` s after its start."""
    if speeds == leg.speeds:
        return leg
    changed = leg._replace(speeds=speeds)
    if leg.kind == Kind.SPLINE or leg.profile is AT_REST:
        return changed
    return changed._replace(profile=change(leg.profile, elapsed, leg.length, _limits_of(changed, copter, True)))


def leg_between(kind: Kind, origin: Place, target: Place, speeds: MotionLimits) -> CopterLeg:
    length = math.dist(origin, target)
    direction = Enu(*(x / length for x in curves.minus(target, origin))) if length > 1e-9 else ZERO
    return CopterLeg(kind, Enu(*origin), Enu(*target), direction=direction, length=length, speeds=speeds)


def _speed_at(leg: CopterLeg, end: float) -> float:
    return leg.profile.peak if leg.kind == Kind.STRAIGHT else float(spline_at(leg, end)[3])
