"""PX4's guidance: velocity setpoints along legs, speeds at corners, yaw, and the land detector."""

import math
from typing import NamedTuple

from ipoa_mission.geometry import GRAVITY, ZERO, Enu, dot, horizontal_norm, minus, norm, plus, scaled
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    BEFORE,
    BEYOND,
    LAND,
    OFF_LINE,
    ON_LINE,
    TAKE_OFF,
    Body,
    Contact,
    Guidance,
    Motion,
    SimulationConstants,
    State,
    Yaw,
    as_tuple,
)
from ipoa_mission.vehicles.px4_multicopter.limits import RANGE_LAG_S, STAGES, Px4Limits


def speed_to(distance: float, leave: float, accel: float, jerk: float) -> float:
    """Return the speed, at least `leave`, that can slow to it: v^2 + (4 a^2/j) v = leave^2 + 2 a `distance`."""
    half = 2.0 * accel * accel / jerk
    return max(math.sqrt(half * half + 2.0 * accel * distance + leave * leave) - half, leave)


def half_tangent(cosine: float) -> float:
    """Return tan(angle / 2); very large for a straight line."""
    return math.sqrt(max(1.0 - cosine, 0.0) / max(1.0 + cosine, 1e-14))


def corner_speed(ahead: Enu, onward: Enu, motion: Motion, limits: Px4Limits) -> float:
    """Return the horizontal speed [m/s] with the way `ahead` to a goal [m], and `onward` to the next one.

    At the goal: that of the circle touching both legs at the acceptance radius, with MPC_XY_TRAJ_P of the acceleration.
    It is 0 if the next leg is shorter than that.
    """
    distance = horizontal_norm(ahead)
    next_distance = horizontal_norm(onward)
    leave = 0.0
    if speed_to(distance, leave, limits.accel, limits.jerk) >= motion.cruise:
        return motion.cruise
    if next_distance > 0.001 and next_distance >= motion.radius:
        product = ahead.east * onward.east + ahead.north * onward.north
        cosine = 0.0 if distance < 1e-9 else -product / (distance * next_distance)
        turn = math.sqrt(limits.corner_gain * limits.accel * motion.radius * half_tangent(cosine))
        leave = min(turn, speed_to(next_distance, 0.0, limits.accel, limits.jerk), motion.cruise)
    return min(motion.cruise, speed_to(distance, leave, limits.accel, limits.jerk))


class Triplet(NamedTuple):
    start: Enu
    goal: Enu
    beyond: Enu


class Climb(NamedTuple):
    rate: float
    accel: float


def vertical_speed(place: Enu, waypoints: Triplet, climb: Climb, limits: Px4Limits) -> float:
    """Return the vertical speed at the goal's height, within the limits of the climb.

    As in PX4 the angle is in the plane of height and distance from the origin.
    """
    leave = 0.0
    goal = waypoints.goal
    if abs(waypoints.beyond.up - goal.up) > 0.001:
        from_here = horizontal_norm(goal) - horizontal_norm(place)
        from_beyond = horizontal_norm(goal) - horizontal_norm(waypoints.beyond)
        up_from_here = goal.up - place.up
        up_from_beyond = goal.up - waypoints.beyond.up
        here_squared = from_here * from_here + up_from_here * up_from_here
        beyond_squared = from_beyond * from_beyond + up_from_beyond * up_from_beyond
        size = math.sqrt(here_squared * beyond_squared)
        product = from_here * from_beyond + up_from_here * up_from_beyond
        cosine = product / size if size > 1e-9 else 0.0
        leave = min(math.sqrt(climb.accel * limits.height_radius * half_tangent(cosine)), climb.rate)
    return min(climb.rate, speed_to(abs(goal.up - place.up), leave, climb.accel, limits.jerk))


def sink_rate(state: State, motion: Motion, constants: SimulationConstants) -> float:
    """Return MPC_Z_V_AUTO_DN above MPC_LAND_ALT1, MPC_LAND_SPEED at MPC_LAND_ALT2, then a crawl.

    Between them it interpolates from MPC_Z_VEL_MAX_DN. Only a range finder measures over the ground, with a lag, and
    allows the crawl.
    """
    limits, sees = constants.limits, constants.sensors.sees_ground
    height = state.body.place.up - (motion.goal.up + RANGE_LAG_S * state.body.speed.up if sees else 0.0)
    if sees and height <= limits.crawl_below and not state.contact.lost:
        return limits.crawl_speed
    share = (height - limits.land_low) / max(limits.land_high - limits.land_low, 1e-6)
    return min(limits.land_speed + min(max(share, 0.0), 1.0) * (limits.sinks_from - limits.land_speed), limits.descent)


def touches_down(state: State, motion: Motion) -> bool:
    return motion.kind == LAND and (state.contact.on_ground or state.body.place.up <= motion.goal.up)


def detect_contact(state: State, body: Body, thrust: float, constants: SimulationConstants) -> Contact:
    """Return the land detector's state. The range finder loses the ground below an estimated height of 0."""
    before = state.contact
    limits, sees = constants.limits, constants.sensors.sees_ground
    on_ground = body.on_ground
    lost = before.lost or (before.on_ground and (state.errors.drift.up > 0.0 or not sees))
    low = before.stages > 0 or thrust <= GRAVITY * (limits.low_thrust - 1.0)
    if not on_ground or abs(body.speed.up) >= limits.max_touchdown or not low:
        return Contact(on_ground, lost, 0, state.time + constants.dt)
    stage = limits.land_detector_s * (STAGES if lost and sees else 1) / STAGES
    if state.time + constants.dt - before.since >= stage:
        return Contact(on_ground, lost, before.stages + 1, state.time + constants.dt)
    return Contact(on_ground, lost, before.stages, before.since)


def heading_wanted(state: State, motion: Motion) -> float:
    if not math.isnan(motion.heading):
        return motion.heading
    east, north = motion.goal.east - state.body.place.east, motion.goal.north - state.body.place.north
    if east * east + north * north <= motion.radius * motion.radius:
        return state.yaw.angle
    return math.atan2(east, north)


def heading_error(state: State, motion: Motion) -> float:
    error = heading_wanted(state, motion) - state.yaw.angle
    return 0.0 if math.isnan(error) else error - 2.0 * math.pi * math.floor(error / (2.0 * math.pi) + 0.5)


def turn_yaw(state: State, motion: Motion, limits: Px4Limits, dt: float) -> Yaw:
    yaw = state.yaw
    if math.isnan(yaw.angle):
        return Yaw(heading_wanted(state, motion), 0.0)
    error = heading_error(state, motion)
    accel = limits.yaw_accel
    most = min(limits.yaw_rate, math.sqrt(2.0 * accel * abs(error)), abs(error) / dt)
    rate = yaw.rate + min(max(math.copysign(most, error) - yaw.rate, -accel * dt), accel * dt)
    return Yaw(yaw.angle + rate * dt, rate)


AT_GOAL = 1e-5  # no velocity setpoint nearer [m]
TURNING = 0.98  # cosine between velocity and way to the goal in a turn
LEAST_AHEAD = 5.0  # look-ahead in a turn, at least the acceptance radius [m]
MOVING = 0.2  # least speed of a turn [m/s]
SEPARATE_AXES_SPEED = 0.5  # below, horizontal and vertical parts are cut separately [m/s]


def guide(state: State, motion: Motion, limits: Px4Limits) -> Guidance:
    """Return the guidance, restarted from the present place after a change."""
    if limits.decoupled_axes:
        return state.guidance
    place = state.body.place
    before = state.guidance
    error = reported_home_error(state, motion)
    reported_place = Enu(place.east, place.north, place.up - error)
    ahead, along, across = beside_leg(reported_place, as_tuple(motion.start), as_tuple(motion.goal))
    if ahead <= 1e-6:
        return Guidance(ON_LINE, as_tuple(motion.start), before.held, before.rising)
    side = ON_LINE
    if along > ahead:
        side = BEYOND
    elif along < 0.0 and along * along + across * across > motion.radius * motion.radius:
        side = BEFORE
    elif motion.kind != LAND and across > motion.radius:
        side = OFF_LINE
    if side == before.side and side != OFF_LINE:
        return before
    return Guidance(side, reported_place, before.held, before.rising)


def beside_leg(place: Enu, start: Enu, goal: Enu) -> tuple[float, float, float]:
    """Return the leg's length, and the place along and lateral to it [m]."""
    leg = minus(goal, start)
    length = norm(leg)
    if length <= 1e-6:
        return 0.0, 0.0, 0.0
    flown = minus(place, start)
    along = dot(flown, leg) / length
    return length, along, math.sqrt(max(dot(flown, flown) - along * along, 0.0))


def triplet(guidance: Guidance, motion: Motion) -> Triplet:
    """Return the leg's waypoints, or the way back to its end, start or nearest point."""
    anchor = guidance.anchor
    start = as_tuple(motion.start)
    goal = as_tuple(motion.goal)
    beyond = as_tuple(motion.beyond)
    if guidance.side == BEYOND:
        return Triplet(anchor, goal, beyond)
    if guidance.side == BEFORE:
        return Triplet(anchor, start, goal)
    if guidance.side == OFF_LINE:
        length, along, _ = beside_leg(anchor, start, goal)
        return Triplet(anchor, plus(start, scaled(minus(goal, start), along / length)), goal)
    return Triplet(start, goal, beyond)


def reported_home_error(state: State, motion: Motion) -> float:
    """Return the guidance's error of home's height [m]."""
    return state.errors.reported if motion.follows_home else 0.0


def is_low_take_off(state: State, motion: Motion, limits: Px4Limits) -> bool:
    return motion.kind == TAKE_OFF and state.body.place.up < limits.land_high


def climb_limits(rising: bool, low: bool, limits: Px4Limits) -> Climb:
    if not rising:
        return Climb(limits.descent, limits.accel_down)
    if low:
        return Climb(limits.takeoff_speed, min(limits.accel_up, limits.takeoff_speed / limits.takeoff_ramp))
    return Climb(limits.climb, limits.accel_up)


def velocity_setpoint(
    state: State, motion: Motion, constants: SimulationConstants, guidance: Guidance
) -> tuple[Enu, Guidance]:
    """Return velocity setpoint before jerk limits, and guidance; in a turn it aims ahead at constant speed."""
    limits = constants.limits
    x, y = state.trajectory.east, state.trajectory.north
    waypoints = triplet(guidance, motion)
    place = Enu(x.place, y.place, state.trajectory.up.place - reported_home_error(state, motion))
    to_point = minus(waypoints.goal, place)
    distance = horizontal_norm(to_point)
    horizontal_speed = corner_speed(to_point, minus(waypoints.beyond, waypoints.goal), motion, limits)
    held = horizontal_speed
    speed = math.sqrt(x.speed * x.speed + y.speed * y.speed)
    is_turning = x.speed * to_point.east + y.speed * to_point.north < TURNING * speed * distance
    if speed > MOVING and distance > motion.radius and is_turning:
        held = guidance.held
        horizontal_speed = min(held, horizontal_speed)
        to_point = ahead_on_leg(place, waypoints, to_point, motion.radius)
    if motion.kind == LAND:
        scale = horizontal_speed / distance if distance > AT_GOAL else 0.0
        velocity = Enu(to_point.east * scale, to_point.north * scale, -sink_rate(state, motion, constants))
    else:
        climb = climb_limits(guidance.rising, is_low_take_off(state, motion, limits), limits)
        rise = vertical_speed(place, waypoints, climb, limits)
        velocity = (
            decoupled_velocity(to_point, horizontal_speed, rise)
            if limits.decoupled_axes
            else coupled_velocity(to_point, horizontal_speed, rise)
        )
    if limits.turns_first and motion.may_turn_first and abs(heading_error(state, motion)) > limits.yaw_error:
        velocity = ZERO
    return velocity, Guidance(guidance.side, guidance.anchor, held, velocity.up > 0.0)


def ahead_on_leg(place: Enu, waypoints: Triplet, to_point: Enu, radius: float) -> Enu:
    """Return the way from `place` to a point of the leg, `radius` or LEAST_AHEAD away [m]."""
    leg = minus(waypoints.goal, waypoints.start)
    length = norm(leg)
    if length <= 1e-6:
        return to_point
    direction = Enu(leg.east / length, leg.north / length, leg.up / length)
    nearest = plus(waypoints.start, scaled(direction, dot(minus(place, waypoints.start), direction)))
    aside = minus(nearest, place)
    reach = max(radius, LEAST_AHEAD)
    squared = reach * reach - aside.east * aside.east - aside.north * aside.north - aside.up * aside.up
    return plus(aside, scaled(direction, math.sqrt(max(squared, 0.0))))


def decoupled_velocity(to_point: Enu, horizontal_speed: float, rise: float) -> Enu:
    """Return a velocity along `to_point`, of a horizontal and a vertical speed [m/s]."""
    far = horizontal_norm(to_point)
    scale = horizontal_speed / far if far > 0.0 else 0.0
    up = 0.0 if to_point.up == 0.0 else math.copysign(rise, to_point.up)
    return Enu(to_point.east * scale, to_point.north * scale, up)


def coupled_velocity(to_point: Enu, horizontal_speed: float, rise: float) -> Enu:
    """Return a velocity along `to_point`, cut to a horizontal and a vertical speed [m/s]."""
    length = norm(to_point)
    if length <= AT_GOAL:
        return ZERO
    east, north, up = scaled(to_point, math.sqrt(horizontal_speed * horizontal_speed + rise * rise) / length)
    flat = math.sqrt(east * east + north * north)
    if flat > horizontal_speed:
        east, north = east * horizontal_speed / flat, north * horizontal_speed / flat
        if horizontal_speed >= SEPARATE_AXES_SPEED or flat >= SEPARATE_AXES_SPEED:
            up *= horizontal_speed / flat
    if abs(up) > rise:
        if rise >= SEPARATE_AXES_SPEED or abs(up) >= SEPARATE_AXES_SPEED:
            east, north = east * rise / abs(up), north * rise / abs(up)
        up *= rise / abs(up)
    return Enu(east, north, up)
