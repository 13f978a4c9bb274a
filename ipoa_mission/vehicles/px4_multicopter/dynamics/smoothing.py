"""PX4's trajectory smoothing: three spans of constant jerk per axis, ending together."""

import math
from typing import NamedTuple

from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Axis, Enu, Trajectory
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits


class Profile(NamedTuple):
    """Jerk j [m/s^3, signed], durations of j, 0 and -j [s]."""

    jerk: float
    rise: float
    coast: float
    fall: float


def quickest(axis: Axis, goal: float, accel: float, jerk: float) -> Profile:
    """Return the fastest change to speed `goal`: peak acceleration p^2 = j (goal - v) + a^2/2."""
    v, a = axis.speed, axis.acceleration
    miss = goal - v - a * abs(a) / (2.0 * jerk)
    if miss == 0.0 and a == 0.0:
        return Profile(0.0, 0.0, 0.0, 0.0)
    j = math.copysign(jerk, miss if miss != 0.0 else a)
    p = math.copysign(math.sqrt(max(j * (goal - v) + a * a / 2.0, 0.0)), j)
    coast = 0.0
    if abs(p) > accel:
        p = math.copysign(accel, j)
        coast = max((goal - v - (2.0 * p * p - a * a) / (2.0 * j)) / p, 0.0)
    rise = (p - a) / j
    if rise < 0.0:
        return Profile(j, 0.0, coast, a / j)
    return Profile(j, rise, coast, p / j)


def stretched(axis: Axis, goal: float, accel: float, profile: Profile, lasts: float) -> Profile:
    """Return the change stretched to `lasts` s.

    Peak p: the smaller root in the direction of j of `p^2 - (j T + a) p + j (goal - v) + a^2/2 = 0`.
    """
    j, a = profile.jerk, axis.acceleration
    if j == 0.0 or profile.rise + profile.coast + profile.fall >= lasts:
        return profile
    b = j * lasts + a
    root = math.sqrt(max(b * b - 4.0 * (j * (goal - axis.speed) + a * a / 2.0), 0.0))
    p = (b - root) / 2.0 if j > 0.0 else (b + root) / 2.0
    p = min(max(p, -accel), accel)
    rise, fall = max((p - a) / j, 0.0), max(p / j, 0.0)
    return Profile(j, rise, max(lasts - rise - fall, 0.0), fall)


def moved(axis: Axis, profile: Profile, t: float) -> Axis:
    x, v, a, j = axis.place, axis.speed, axis.acceleration, profile.jerk
    d = min(t, profile.rise)
    if d > 0.0:
        x, v, a = x + d * (v + d * (a / 2.0 + d * j / 6.0)), v + d * (a + d * j / 2.0), a + d * j
        t -= d
    d = min(t, profile.coast)
    if d > 0.0:
        x, v = x + d * (v + d * a / 2.0), v + d * a
        t -= d
    d = min(t, profile.fall)
    if d > 0.0:
        x, v, a = x + d * (v + d * (a / 2.0 - d * j / 6.0)), v + d * (a - d * j / 2.0), a - d * j
        t -= d
    if t > 0.0:
        x, a = x + t * v, 0.0
    return Axis(x, v, a)


def smoothed(
    trajectory: Trajectory, velocity: Enu, limits: Px4Limits, accel_up: float, t: float, t_up: float
) -> Trajectory:
    """Return the trajectory t s later (`t_up` upwards)."""
    x, y, z = trajectory
    accel, jerk = limits.accel, limits.jerk
    east, north = quickest(x, velocity.east, accel, jerk), quickest(y, velocity.north, accel, jerk)
    up = quickest(z, velocity.up, accel_up, jerk)
    longest = max(east.rise + east.coast + east.fall, north.rise + north.coast + north.fall)
    longest = max(longest, up.rise + up.coast + up.fall)
    return Trajectory(
        moved(x, stretched(x, velocity.east, accel, east, longest), t),
        moved(y, stretched(y, velocity.north, accel, north, longest), t),
        moved(z, stretched(z, velocity.up, accel_up, up, longest), t_up),
    )
