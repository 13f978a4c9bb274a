"""Speeds that PX4's waypoints allow."""

import math

from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Enu, Order, Trajectory
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits


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


def vertical_speed(at: Enu, goal: Enu, beyond: Enu, top: float, accel: float, limits: Px4Limits) -> float:
    """Return the vertical speed at the goal's height; `top` and `accel` limit it.

    As in PX4 the angle is in the plane of height and distance from the origin.
    """
    leave = 0.0
    if abs(beyond.up - goal.up) > 0.001:
        now, then, next_then = level(at), level(goal), level(beyond)
        back, down, on, up = then - now, goal.up - at.up, then - next_then, goal.up - beyond.up
        size = math.sqrt((back * back + down * down) * (on * on + up * up))
        cosine = (back * on + down * up) / size if size > 1e-9 else 0.0
        leave = min(math.sqrt(accel * limits.height_radius * half_tangent(cosine)), top)
    return min(top, speed_to(abs(goal.up - at.up), leave, accel, limits.jerk))


def level(place: Enu) -> float:
    """Return the level length of a vector."""
    return math.sqrt(place.east * place.east + place.north * place.north)
