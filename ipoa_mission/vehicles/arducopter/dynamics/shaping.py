"""Target of ArduCopter's position controller: along an S-curve leg, or shaped.

Read in 4.8.0-dev (AC_PosControl, control.cpp: shape_pos_vel_accel_xy, shape_vel_accel_xy).
"""

import math

from ipoa_mission.geometry import Enu
from ipoa_mission.vehicles.arducopter.dynamics.motion import STEP, CopterLeg, State, Tuning
from ipoa_mission.vehicles.arducopter.dynamics.scurve import Triple, motion_in


def along(leg: CopterLeg, t: float) -> Triple:
    """Return acceleration, speed and distance after t seconds."""
    segments = leg.profile.segments
    n = len(segments) - 1
    if t <= 0.0:
        return 0.0, segments[0].speed, 0.0
    if t >= leg.profile.lasts:
        return 0.0, leg.profile.leave, leg.length
    while n > 0 and segments[n].begin > t:
        n -= 1
    return motion_in(segments[n], t - segments[n].begin)


def leg_motion(
    leg: CopterLeg, a: float, v: float, s: float, way_back: float
) -> tuple[complex, float, complex, float, complex, float]:
    """Return place, velocity and acceleration, each horizontal and upwards [m, m/s, m/s^2].

    The place is relative to the origin, or with the length as `way_back` to the target.
    """
    if leg.turn == 0.0:
        horizontal = complex(leg.direction.east, leg.direction.north)
        up = leg.direction.up
        s -= way_back
        return s * horizontal, s * up, v * horizontal, v * up, a * horizontal, a * up
    center = complex(leg.center.east, leg.center.north)
    from_center = complex(leg.origin.east, leg.origin.north) - center
    angle = leg.turn * s / leg.length
    radius = size(from_center)
    arm = from_center * complex(math.cos(angle), -math.sin(angle))
    tangent = complex(arm.imag, -arm.real)
    start = leg.target if way_back > 0.0 else leg.origin
    rise = (leg.target.up - leg.origin.up) / leg.length
    upward = rise / math.sqrt(1.0 + rise * rise)
    onward = (1.0 if leg.turn > 0.0 else -1.0) / (radius * math.sqrt(1.0 + rise * rise))
    place = arm + center - complex(start.east, start.north)
    inward = (v / radius) ** 2
    accel = a * onward * tangent - inward * arm
    return place, (s - way_back) * rise, v * onward * tangent, v * upward, accel, a * upward


def size(v: complex) -> float:
    return math.sqrt(v.real * v.real + v.imag * v.imag)


def dot(a: complex, b: complex) -> float:
    return a.real * b.real + a.imag * b.imag


def square(v: complex) -> float:
    return v.real**2 + v.imag**2


LEVEL_OFF_TOLERANCE = 0.03  # replaces LOITER_TO_ALT's 5 cm and 0.5 s, as flown [m]


def orbit(state: State, this: CopterLeg, tuning: Tuning) -> bool:
    """Follow a circle; return whether the turn is complete. A radius of 0 leads to the center."""
    circle = this.orbit
    state.spin = min(state.spin + circle.spin_up * STEP, circle.spin)
    state.turned += state.spin * STEP
    angle = state.bearing + math.copysign(state.turned, this.turn)
    x, y = this.center.east + circle.radius * math.sin(angle), this.center.north + circle.radius * math.cos(angle)
    shape_to_place(state, complex(x, y), this.speeds.horizontal, tuning)
    state.target_z, state.vz_desired, state.time_scale = this.target.up, 0.0, 1.0
    return state.turned >= abs(this.turn)


def level_off(state: State, this: CopterLeg, tuning: Tuning) -> bool:
    """Return whether the height is reached."""
    before = state.z - this.target.up
    shape_to_rest(state, tuning)
    climb_rate = sqrt_controller(-before, tuning.limits.accel_z, tuning.limits.p_height)
    climb_at(state, min(max(climb_rate, -this.speeds.down), this.speeds.up), tuning)
    state.time_scale = 1.0
    passed = before * state.above < 0.0
    state.above = before
    return passed or abs(before) < LEVEL_OFF_TOLERANCE


def climb_at(state: State, climb_rate: float, tuning: Tuning) -> None:
    jerk = tuning.limits.jerk_z * STEP
    gain = tuning.limits.jerk_z / tuning.limits.accel_z
    accel = min(max(gain * (climb_rate - state.vz), -tuning.limits.accel_z), tuning.limits.accel_z)
    state.az += min(max(accel - state.az, -jerk), jerk)
    state.vz_desired = state.vz + state.az * STEP
    state.target_z = state.z + state.vz_desired * STEP


def sqrt_controller(error: float, accel: float, gain: float) -> float:
    """Return the speed for a position error, as ArduPilot's function of this name."""
    linear = accel / (gain * gain)
    if abs(error) <= linear:
        return gain * error
    return math.copysign(math.sqrt(2 * accel * (abs(error) - linear / 2)), error)


def shape_to_place(state: State, place: complex, fastest: float, tuning: Tuning) -> None:
    advance(state)
    gain = tuning.limits.shaping_jerk / tuning.limits.accel
    accel = tuning.limits.accel
    error = place - state.target
    velocity = 0j
    far = size(error)
    if far > 0.0:
        closing = dot(state.vel_desired, error) / far
        speed = min(sqrt_controller(far, accel, gain), far / STEP)
        if closing > 0.0:
            speed -= closing * (1.0 if far <= accel / (gain * gain) else accel / (speed * gain))
        speed = min(max(speed, -fastest), fastest)
        velocity = error * speed / far
    shape(state, gain * (velocity - state.vel_desired), tuning)


def shape_to_rest(state: State, tuning: Tuning) -> None:
    advance(state)
    speed = math.sqrt(square(state.vel_desired))
    jerk = tuning.limits.shaping_jerk
    slowed = sqrt_controller(speed, jerk, jerk / tuning.limits.accel) / speed if speed > 0.0 else 0.0
    shape(state, -slowed * state.vel_desired, tuning)


def rest_target(state: State, place: Enu) -> None:
    state.target = complex(place.east, place.north)
    state.target_z = place.up
    state.vel_desired = state.accel_desired = 0j
    state.vz_desired = 0.0


def advance(state: State) -> None:
    state.target += STEP * (state.vel_desired + state.accel_desired * STEP / 2)
    state.vel_desired += state.accel_desired * STEP


def shape(state: State, target_accel: complex, tuning: Tuning) -> None:
    """Approach this target acceleration; braking takes precedence over turning."""
    most = tuning.limits.accel
    target_accel = within(target_accel, 2.0 * most)
    speed = math.sqrt(square(state.vel_desired))
    if speed > 0.0:
        direction = state.vel_desired / speed
        turned = target_accel * direction.conjugate()
        along, across = turned.real, turned.imag
        if along > 0.0:
            across = min(max(across, -most), most)
            along = min(along, math.sqrt(most**2 - across * across))
        else:
            along = max(along, -most)
            most_across = math.sqrt(most**2 - along * along)
            across = min(max(across, -most_across), most_across)
        target_accel = complex(along, across) * direction
    target_accel = within(target_accel, most)
    state.accel_desired += within(target_accel - state.accel_desired, tuning.limits.shaping_jerk * STEP)


def within(v: complex, most: float) -> complex:
    length = size(v)
    return v if length <= most else v * most / length
