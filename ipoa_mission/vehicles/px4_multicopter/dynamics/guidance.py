"""PX4's guidance: velocity setpoints along legs, speeds at corners, yaw, and the land detector."""

import math
from typing import NamedTuple

from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics import state as px4
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Enu, Order, State, Trajectory, as_tuple
from ipoa_mission.vehicles.px4_multicopter.limits import RANGE_LAG_S, STAGES, Px4Limits


def speed_to(distance: float, leave: float, accel: float, jerk: float) -> float:
    """Return the speed that can slow to `leave` within `distance`.

    v^2 + (4 a^2/j) v = leave^2 + 2 a d, at least `leave`.
    """
    half = 2.0 * accel * accel / jerk
    return max(math.sqrt(half * half + 2.0 * accel * distance + leave * leave) - half, leave)


def half_tangent(cosine: float) -> float:
    """Return tan(angle / 2); very large for a straight line."""
    return math.sqrt(max(1.0 - cosine, 0.0) / max(1.0 + cosine, 1e-14))


def corner_speed(at: Trajectory, goal: Enu, beyond: Enu, order: Order, limits: Px4Limits) -> float:
    """Return the level speed before a goal towards `beyond`.

    At the goal: that of the circle touching both legs at the acceptance radius, with MPC_XY_TRAJ_P of the acceleration.
    It is 0 if the next leg is shorter than that.
    """
    to_east, to_north = goal.east - at.east.place, goal.north - at.north.place
    on_east, on_north = beyond.east - goal.east, beyond.north - goal.north
    distance = math.sqrt(to_east * to_east + to_north * to_north)
    accel, jerk, leave = limits.accel, limits.jerk, 0.0
    if speed_to(distance, leave, accel, jerk) >= order.cruise:
        return order.cruise
    onward = math.sqrt(on_east * on_east + on_north * on_north)
    if onward > 0.001 and onward >= order.radius:
        cosine = 0.0 if distance < 1e-9 else -(to_east * on_east + to_north * on_north) / (distance * onward)
        turn = math.sqrt(limits.corner_gain * accel * order.radius * half_tangent(cosine))
        leave = min(turn, speed_to(onward, 0.0, accel, jerk), order.cruise)
    return min(order.cruise, speed_to(distance, leave, accel, jerk))


class Triplet(NamedTuple):
    start: Enu
    goal: Enu
    beyond: Enu


class Climb(NamedTuple):
    rate: float
    accel: float


def vertical_speed(at: Enu, to: Triplet, climb: Climb, limits: Px4Limits) -> float:
    """Return the vertical speed at the goal's height, within the limits of the climb.

    As in PX4 the angle is in the plane of height and distance from the origin.
    """
    leave, goal, beyond = 0.0, to.goal, to.beyond
    if abs(beyond.up - goal.up) > 0.001:
        now, then, next_then = horizontal_norm(at), horizontal_norm(goal), horizontal_norm(beyond)
        back, down, on, up = then - now, goal.up - at.up, then - next_then, goal.up - beyond.up
        size = math.sqrt((back * back + down * down) * (on * on + up * up))
        cosine = (back * on + down * up) / size if size > 1e-9 else 0.0
        leave = min(math.sqrt(climb.accel * limits.height_radius * half_tangent(cosine)), climb.rate)
    return min(climb.rate, speed_to(abs(goal.up - at.up), leave, climb.accel, limits.jerk))


def horizontal_norm(place: Enu) -> float:
    """Return the level length of a vector."""
    return math.sqrt(place.east * place.east + place.north * place.north)


def sink_rate(state: State, order: Order, constants: px4.SimulationConstants) -> float:
    """Return MPC_Z_V_AUTO_DN above MPC_LAND_ALT1, MPC_LAND_SPEED at MPC_LAND_ALT2, then a crawl.

    Between them it interpolates from MPC_Z_VEL_MAX_DN. Only a range finder measures over the ground, with a lag, and
    allows the crawl.
    """
    limits, sees = constants.limits, constants.senses.sees_ground
    height = state.body.place.up - (order.goal.up + RANGE_LAG_S * state.body.speed.up if sees else 0.0)
    if sees and height <= limits.crawl_below and not state.contact.lost:
        return limits.crawl_speed
    share = (height - limits.land_low) / max(limits.land_high - limits.land_low, 1e-6)
    return min(limits.land_speed + min(max(share, 0.0), 1.0) * (limits.sinks_from - limits.land_speed), limits.descent)


def touches_down(state: State, order: Order) -> bool:
    return order.kind == px4.LAND and (state.contact.on_ground or state.body.place.up <= order.goal.up)


def detect_contact(state: State, body: px4.Body, thrust: float, constants: px4.SimulationConstants) -> px4.Contact:
    """Return the land detector's state: low thrust and speed for long enough.

    The range finder loses the ground below an estimated height of 0.
    """
    was, limits = state.contact, constants.limits
    sees, on_ground = constants.senses.sees_ground, body.on_ground
    lost = was.lost or (was.on_ground and (state.errors.drift.up > 0.0 or not sees))
    low = was.stages > 0 or thrust <= GRAVITY * (limits.low_thrust - 1.0)
    if not on_ground or abs(body.speed.up) >= limits.most_touchdown or not low:
        return px4.Contact(on_ground, lost, 0, state.time + constants.dt)
    stage = limits.land_detector_s * (STAGES if lost and sees else 1) / STAGES
    if state.time + constants.dt - was.since >= stage:
        return px4.Contact(on_ground, lost, was.stages + 1, state.time + constants.dt)
    return px4.Contact(on_ground, lost, was.stages, was.since)


def heading_wanted(state: State, order: Order) -> float:
    if not math.isnan(order.heading):
        return order.heading
    east, north = order.goal.east - state.body.place.east, order.goal.north - state.body.place.north
    if east * east + north * north <= order.radius * order.radius:
        return state.nose.yaw
    return math.atan2(east, north)


def heading_error(state: State, order: Order) -> float:
    error = heading_wanted(state, order) - state.nose.yaw
    return 0.0 if math.isnan(error) else error - 2.0 * math.pi * math.floor(error / (2.0 * math.pi) + 0.5)


def turned(state: State, order: Order, limits: Px4Limits, dt: float) -> px4.Yaw:
    nose = state.nose
    if math.isnan(nose.yaw):
        return px4.Yaw(heading_wanted(state, order), 0.0)
    error, accel = heading_error(state, order), limits.yaw_accel
    most = min(limits.yaw_rate, math.sqrt(2.0 * accel * abs(error)), abs(error) / dt)
    rate = nose.rate + min(max(math.copysign(most, error) - nose.rate, -accel * dt), accel * dt)
    return px4.Yaw(nose.yaw + rate * dt, rate)


AT_GOAL = 1e-5  # no velocity setpoint nearer [m]
TURNING = 0.98  # cosine between velocity and aim in a turn
LEAST_AHEAD = 5.0  # look-ahead in a turn, at least the acceptance radius [m]
MOVING = 0.2  # least speed of a turn [m/s]
SEPARATE_AXES_SPEED = 0.5  # below, level and vertical parts are cut separately [m/s]


def guided(state: State, order: Order, limits: Px4Limits) -> px4.Guidance:
    """Return the guidance, restarted from the present place after a change."""
    if limits.splits_axes:
        return state.guidance
    place, was, home = state.body.place, state.guidance, reported_home_error(state, order)
    at = Enu(place.east, place.north, place.up - home)
    ahead, along, across = beside_leg(at, as_tuple(order.start), as_tuple(order.goal))
    if ahead <= 1e-6:
        return px4.Guidance(px4.ON_LINE, as_tuple(order.start), was.held, was.rising)
    side = px4.ON_LINE
    if along > ahead:
        side = px4.BEYOND
    elif along < 0.0 and along * along + across * across > order.radius * order.radius:
        side = px4.BEFORE
    elif order.kind != px4.LAND and across > order.radius:
        side = px4.OFF_LINE
    if side == was.side and side != px4.OFF_LINE:
        return was
    return px4.Guidance(side, at, was.held, was.rising)


def beside_leg(at: Enu, start: Enu, goal: Enu) -> tuple[float, float, float]:
    """Return the leg's length, and the place along and lateral to it [m]."""
    leg_east, leg_north, leg_up = goal.east - start.east, goal.north - start.north, goal.up - start.up
    length = math.sqrt(leg_east * leg_east + leg_north * leg_north + leg_up * leg_up)
    if length <= 1e-6:
        return 0.0, 0.0, 0.0
    off_east, off_north, off_up = at.east - start.east, at.north - start.north, at.up - start.up
    along = (off_east * leg_east + off_north * leg_north + off_up * leg_up) / length
    square = off_east * off_east + off_north * off_north + off_up * off_up - along * along
    return length, along, math.sqrt(max(square, 0.0))


def triplet(guidance: px4.Guidance, order: Order) -> Triplet:
    """Return the leg's waypoints, or the way back to its end, start or nearest point."""
    start, goal, beyond, at = as_tuple(order.start), as_tuple(order.goal), as_tuple(order.beyond), guidance.anchor
    if guidance.side == px4.BEYOND:
        return Triplet(at, goal, beyond)
    if guidance.side == px4.BEFORE:
        return Triplet(at, start, goal)
    if guidance.side == px4.OFF_LINE:
        length, along, _ = beside_leg(at, start, goal)
        share = along / length
        east, north = start.east + share * (goal.east - start.east), start.north + share * (goal.north - start.north)
        return Triplet(at, Enu(east, north, start.up + share * (goal.up - start.up)), goal)
    return Triplet(start, goal, beyond)


def reported_home_error(state: State, order: Order) -> float:
    """Return the guidance's error of home's height [m]."""
    return state.errors.reported if order.follows_home else 0.0


def is_low_take_off(state: State, order: Order, limits: Px4Limits) -> bool:
    return order.kind == px4.TAKE_OFF and state.body.place.up < limits.land_high


def climb_limits(rising: bool, low: bool, limits: Px4Limits) -> Climb:
    if not rising:
        return Climb(limits.descent, limits.accel_down)
    if low:
        return Climb(limits.takeoff_speed, min(limits.accel_up, limits.takeoff_speed / limits.takeoff_ramp))
    return Climb(limits.climb, limits.accel_up)


def velocity_setpoint(
    state: State, order: Order, constants: px4.SimulationConstants, guidance: px4.Guidance
) -> tuple[Enu, px4.Guidance]:
    """Return the velocity setpoint before jerk limits, and the guidance.

    In a turn it aims ahead on the leg and does not accelerate.
    """
    limits, x, y, z = constants.limits, state.trajectory.east, state.trajectory.north, state.trajectory.up
    to = triplet(guidance, order)
    at = Enu(x.place, y.place, z.place - reported_home_error(state, order))
    aim = Enu(to.goal.east - at.east, to.goal.north - at.north, to.goal.up - at.up)
    far, speed = horizontal_norm(aim), math.sqrt(x.speed * x.speed + y.speed * y.speed)
    fast, held = corner_speed(state.trajectory, to.goal, to.beyond, order, limits), guidance.held
    if speed > MOVING and far > order.radius and x.speed * aim.east + y.speed * aim.north < TURNING * speed * far:
        fast = min(held, fast)
        aim = ahead_on_leg(at, to, aim, order.radius)
    else:
        held = fast
    if order.kind == px4.LAND:
        share = fast / far if far > AT_GOAL else 0.0
        velocity = Enu(aim.east * share, aim.north * share, -sink_rate(state, order, constants))
    else:
        climb = climb_limits(guidance.rising, is_low_take_off(state, order, limits), limits)
        rise = vertical_speed(at, to, climb, limits)
        velocity = apart(aim, fast, rise) if limits.splits_axes else within(aim, fast, rise)
    if limits.turns_first and order.may_turn_first and abs(heading_error(state, order)) > limits.yaw_error:
        velocity = px4.ZERO
    return velocity, px4.Guidance(guidance.side, guidance.anchor, held, velocity.up > 0.0)


def ahead_on_leg(at: Enu, to: Triplet, aim: Enu, radius: float) -> Enu:
    east, north, up = to.goal.east - to.start.east, to.goal.north - to.start.north, to.goal.up - to.start.up
    size = math.sqrt(east * east + north * north + up * up)
    if size <= 1e-6:
        return aim
    east, north, up = east / size, north / size, up / size
    onto = (at.east - to.start.east) * east + (at.north - to.start.north) * north + (at.up - to.start.up) * up
    off_east, off_north = to.start.east + onto * east - at.east, to.start.north + onto * north - at.north
    off_up = to.start.up + onto * up - at.up
    reach = max(radius, LEAST_AHEAD)
    ahead = math.sqrt(max(reach * reach - off_east * off_east - off_north * off_north - off_up * off_up, 0.0))
    return Enu(off_east + ahead * east, off_north + ahead * north, off_up + ahead * up)


def apart(aim: Enu, fast: float, rise: float) -> Enu:
    far = horizontal_norm(aim)
    share = fast / far if far > 0.0 else 0.0
    up = 0.0 if aim.up == 0.0 else math.copysign(rise, aim.up)
    return Enu(aim.east * share, aim.north * share, up)


def within(aim: Enu, fast: float, rise: float) -> Enu:
    size = math.sqrt(aim.east * aim.east + aim.north * aim.north + aim.up * aim.up)
    if size <= AT_GOAL:
        return px4.ZERO
    share = math.sqrt(fast * fast + rise * rise) / size
    east, north, up = aim.east * share, aim.north * share, aim.up * share
    flat = math.sqrt(east * east + north * north)
    if flat > fast:
        east, north = east * fast / flat, north * fast / flat
        if fast >= SEPARATE_AXES_SPEED or flat >= SEPARATE_AXES_SPEED:
            up *= fast / flat
    if abs(up) > rise:
        if rise >= SEPARATE_AXES_SPEED or abs(up) >= SEPARATE_AXES_SPEED:
            east, north = east * rise / abs(up), north * rise / abs(up)
        up *= rise / abs(up)
    return Enu(east, north, up)
