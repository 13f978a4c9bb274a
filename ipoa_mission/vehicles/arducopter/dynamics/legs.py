"""Plan ArduCopter's legs: straight, arc, spline, vertical, hold and circle, with their speed limits."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

from ipoa_mission.forecast.itinerary.copter_curves import (
    arc_center,
    arc_length,
    arc_radius,
    cubic,
    is_arc,
    minus,
    spline_tangents,
)
from ipoa_mission.geometry import Place
from ipoa_mission.vehicles.arducopter.braking import circle_spin
from ipoa_mission.vehicles.arducopter.dynamics.motion import (
    HOLD,
    LEVEL_OFF,
    ORBIT,
    SPLINE,
    STRAIGHT,
    ZERO,
    CopterLeg,
    MotionLimits,
    Orbit,
    Vector,
)
from ipoa_mission.vehicles.arducopter.dynamics.scurve import AT_REST, SCurveLimits, change, profile
from ipoa_mission.vehicles.arducopter.dynamics.steps import along_limit, bend
from ipoa_mission.vehicles.arducopter.limits import CopterLimits

SPLINE_SHARE = 0.5  # of the acceleration limits
SLOWEST_SPIN_UP = math.radians(2.0)  # [rad/s^2]
ZERO_LENGTH = 1e-6  # [m]


def limits_along(origin: Place, target: Place, speeds: MotionLimits, copter: CopterLimits) -> SCurveLimits:
    """Return the limits along the path, by level and vertical ones."""
    length = math.dist(origin, target)
    if length < 1e-9:
        return SCurveLimits(speeds.level, copter.accel, copter.jerk, copter.snap)
    x, y, z = ((b - a) / length for a, b in zip(origin, target, strict=True))
    speed, accel = (
        along_limit(x, y, z, speeds),
        along_limit(x, y, z, MotionLimits(copter.accel, copter.accel_z, copter.accel_z)),
    )
    return SCurveLimits(speed, accel, copter.jerk, copter.snap)


class Stop(NamedTuple):
    """A destination: straight, an arc by `turn` [rad, clockwise], or a `spline` towards `after` (True: a spline)."""

    place: Place
    spline: bool = False
    after: tuple[Place, bool] | None = None
    turn: float = 0.0


class Course(NamedTuple):
    """Speeds at the ends of a leg [m/s]; the `turn` of an arc [rad]; `is_changed`: its speed, after planning."""

    enter: float = 0.0
    leave: float = 0.0
    turn: float = 0.0
    is_changed: bool = False


REST_TO_REST = Course()


@lru_cache(maxsize=256)
def straight_leg(
    origin: Place, target: Place, speeds: MotionLimits, copter: CopterLimits, course: Course = REST_TO_REST
) -> CopterLeg:
    """Return a straight leg, or an arc."""
    enter, leave, turn, is_changed = course
    leg = _leg(STRAIGHT, origin, target, speeds)
    if leg.length <= ZERO_LENGTH:
        return leg
    if is_arc(origin, target, turn):
        center = Vector(*arc_center(origin, target, turn), 0.0)
        leg = leg._replace(turn=turn, center=center, length=arc_length(origin, target, turn))
    limits = _changed_limits(leg, copter) if is_changed else _limits_of(leg, copter)
    return leg._replace(profile=profile(leg.length, limits, enter, leave))


def _limits_of(leg: CopterLeg, copter: CopterLimits) -> SCurveLimits:
    """Return those of the chord; corner acceleration limits an arc's speed."""
    speeds = leg.speeds
    if leg.turn != 0.0:
        radius = arc_radius(leg.origin, leg.target, leg.turn)
        speeds = speeds._replace(level=min(speeds.level, math.sqrt(copter.corner_accel * radius)))
    return limits_along(leg.origin, leg.target, speeds, copter)


def _changed_limits(leg: CopterLeg, copter: CopterLimits) -> SCurveLimits:
    limits = _limits_of(leg, copter)
    if leg.turn == 0.0:
        return limits
    rise = (leg.target[2] - leg.origin[2]) / leg.length
    return replace(limits, speed=along_limit(math.sqrt(1.0 - rise * rise), 0.0, rise, leg.speeds))


def spline_leg(
    origin: Place, stop: Stop, previous: CopterLeg | None, speeds: MotionLimits, copter: CopterLimits
) -> CopterLeg:
    """Return a spline that starts tangent to the previous leg (`spline_tangents`)."""
    flown_in, target = None, stop.place
    if previous is not None:
        flown_in = previous.end if previous.kind == SPLINE else minus(previous.target, previous.origin)
    tangents = spline_tangents(origin, target, flown_in, stop.after)
    level, vertical = SPLINE_SHARE * copter.accel, SPLINE_SHARE * copter.accel_z
    return _leg(SPLINE, origin, target, speeds)._replace(
        cubic=[Vector(*coefficient) for coefficient in cubic(origin, target, tangents)],
        end=Vector(*tangents[1]),
        accel=MotionLimits(level, vertical, vertical),
    )


def upright_leg(kind: float, place: Place, height: float, speeds: MotionLimits, lasts: float = 0.0) -> CopterLeg:
    """Return a vertical leg to `height` [m]; a HOLD `lasts` [s]."""
    return _leg(kind, place, (place[0], place[1], height), speeds)._replace(lasts=lasts)


def hold_leg(place: Place, lasts: float) -> CopterLeg:
    return upright_leg(HOLD, place, place[2], MotionLimits(0.0, 0.0, 0.0), lasts)


def orbit_of(radius: float, speed: float, copter: CopterLimits) -> Orbit:
    spin, spin_up = copter.circle_rate, max(copter.circle_rate, SLOWEST_SPIN_UP)
    if radius > 0.0:
        spin = circle_spin(copter, radius, speed)
        spin_up = max(copter.accel / radius, SLOWEST_SPIN_UP)
    return Orbit(radius, spin, spin_up)


def orbit_leg(here: Place, center: Place, orbit: Orbit, turn: float, speeds: MotionLimits) -> CopterLeg:
    """Return a circle of `turn` [rad], clockwise."""
    leg = _leg(ORBIT, here, here, speeds)._replace(length=orbit.radius * abs(turn), turn=turn)
    return leg._replace(center=Vector(*center), orbit=orbit)


def level_off_leg(here: Place, up: float, speeds: MotionLimits) -> CopterLeg:
    return upright_leg(LEVEL_OFF, here, up, speeds)


def joined(this: CopterLeg, following: CopterLeg, copter: CopterLimits, left: float = math.inf) -> CopterLeg:
    """Return `this` with its end speed matched to a spline before or after.

    `left`: the leave speed of the last spline [m/s].
    """
    if this.kind == following.kind == STRAIGHT:
        return this
    speed = _speed_at(following, 0.0)
    if following.kind == SPLINE:
        brakes = along_limit(*bend(following, 0.0)[1], following.accel)
        speed = min(speed, math.sqrt(2 * brakes * following.length + left**2))
    if this.kind == SPLINE:
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
    if leg.kind == SPLINE or leg.profile is AT_REST:
        return changed
    return changed._replace(profile=change(leg.profile, elapsed, leg.length, _changed_limits(changed, copter)))


def _leg(kind: float, origin: Place, target: Place, speeds: MotionLimits) -> CopterLeg:
    length = math.dist(origin, target)
    direction = Vector(*(x / length for x in minus(target, origin))) if length > 1e-9 else ZERO
    return CopterLeg(kind, Vector(*origin), Vector(*target), direction, length, speeds)


def _speed_at(leg: CopterLeg, end: float) -> float:
    return leg.profile.peak if leg.kind == STRAIGHT else float(bend(leg, end)[3])
