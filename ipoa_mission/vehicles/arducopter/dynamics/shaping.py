"""Target of ArduCopter's position controller: along an S-curve leg, or shaped.

Read in 4.8.0-dev (AC_PosControl, control.cpp: shape_pos_vel_accel_xy, shape_vel_accel_xy).
"""

import math

from ipoa_mission.vehicles.arducopter.dynamics.motion import STEP, CopterLeg, State, Tuning

Triple = tuple[float, float, float]


def along(leg: CopterLeg, t: float) -> Triple:
    """Return acceleration, speed and way after t seconds."""
    segments = leg.profile.segments
    at = len(segments) - 1
    if t <= 0.0:
        return 0.0, segments[0].speed, 0.0
    if t >= leg.profile.lasts:
        return 0.0, leg.profile.leave, leg.length
    while at > 0 and segments[at].begin > t:
        at -= 1
    segment = segments[at]
    t -= segment.begin
    lasts, j, a, v, way = segment.lasts, segment.jerk, segment.accel, segment.speed, segment.way
    if segment.shape == 0.0 or lasts <= 0.0:
        return a + j * t, v + t * (a + j * t / 2), way + t * (v + t * (a / 2 + j * t / 6))
    b = lasts / math.pi
    s = b if segment.shape == 1.0 else -b
    sine, cosine, half = math.sin(t / b), math.cos(t / b), j / 2
    return (
        a + half * (t - s * sine),
        v + a * t + half * (t * t / 2 + s * b * (cosine - 1.0)),
        way + v * t + a * t * t / 2 + half * (t * t * t / 6 + s * b * (b * sine - t)),
    )


def on_way(leg: CopterLeg, a: float, v: float, s: float, way_back: float) -> tuple[Triple, Triple, Triple]:
    """Return place, velocity and acceleration [m, m/s, m/s^2].

    The place is relative to the origin, or with the length as `way_back` to the target.
    """
    if leg.turn == 0.0:
        way = leg.direction
        s -= way_back
        return (s * way.x, s * way.y, s * way.z), (v * way.x, v * way.y, v * way.z), (a * way.x, a * way.y, a * way.z)
    east, north = leg.origin.x - leg.center.x, leg.origin.y - leg.center.y
    angle = leg.turn * s / leg.length
    sine, cosine = math.sin(angle), math.cos(angle)
    x, y = east * cosine + north * sine, north * cosine - east * sine
    start = leg.target if way_back > 0.0 else leg.origin
    radius, rise = math.sqrt(east * east + north * north), (leg.target.z - leg.origin.z) / leg.length
    upward = rise / math.sqrt(1.0 + rise * rise)
    onward = (1.0 if leg.turn > 0.0 else -1.0) / (radius * math.sqrt(1.0 + rise * rise))
    inward = (v / radius) ** 2
    return (
        (x + leg.center.x - start.x, y + leg.center.y - start.y, (s - way_back) * rise),
        (v * onward * y, -v * onward * x, v * upward),
        (a * onward * y - inward * x, -a * onward * x - inward * y, a * upward),
    )


LEVEL = 0.03  # replaces LOITER_TO_ALT's 5 cm and 0.5 s, as flown [m]


def orbit(state: State, this: CopterLeg, tuning: Tuning) -> bool:
    """Follow a point on a circle; return whether it completed its turn.

    With a radius of 0 the target moves to the center meanwhile.
    """
    way = this.orbit
    state.spin = min(state.spin + way.spin_up * STEP, way.spin)
    state.turned += state.spin * STEP
    angle = state.bearing + math.copysign(state.turned, this.turn)
    x, y = this.center.x + way.radius * math.sin(angle), this.center.y + way.radius * math.cos(angle)
    shape_to_place(state, x, y, this.speeds.level, tuning)
    state.target_z, state.aim_z, state.rate = this.target.z, 0.0, 1.0
    return state.turned >= abs(this.turn)


def level_off(state: State, this: CopterLeg, tuning: Tuning) -> bool:
    """Return whether the height is reached."""
    before = state.z - this.target.z
    shape_to_rest(state, tuning)
    wanted = square_root_law(-before, tuning.limits.accel_z, tuning.limits.p_height)
    climb_at(state, min(max(wanted, -this.speeds.down), this.speeds.up), tuning)
    state.rate = 1.0
    passed, state.above = before * state.above < 0.0, before
    return passed or abs(before) < LEVEL


def climb_at(state: State, wanted: float, tuning: Tuning) -> None:
    jerk, gain = tuning.limits.jerk_z * STEP, tuning.limits.jerk_z / tuning.limits.accel_z
    accel = min(max(gain * (wanted - state.vz), -tuning.limits.accel_z), tuning.limits.accel_z)
    state.az += min(max(accel - state.az, -jerk), jerk)
    state.aim_z = state.vz + state.az * STEP
    state.target_z = state.z + state.aim_z * STEP


def square_root_law(error: float, accel: float, gain: float) -> float:
    """Return the speed for a position error."""
    linear = accel / (gain * gain)
    if abs(error) <= linear:
        return gain * error
    return math.copysign(math.sqrt(2 * accel * (abs(error) - linear / 2)), error)


def shape_to_place(state: State, x: float, y: float, fastest: float, tuning: Tuning) -> None:
    advance(state)
    gain, accel = tuning.limits.shaping_jerk / tuning.limits.accel, tuning.limits.accel
    ex, ey = x - state.target_x, y - state.target_y
    far = math.sqrt(ex * ex + ey * ey)
    wanted_x = wanted_y = 0.0
    if far > 0.0:
        closing = (state.aim_x * ex + state.aim_y * ey) / far
        speed = min(square_root_law(far, accel, gain), far / STEP)
        if closing > 0.0:
            speed -= closing * (1.0 if far <= accel / (gain * gain) else accel / (speed * gain))
        speed = min(max(speed, -fastest), fastest)
        wanted_x, wanted_y = ex * speed / far, ey * speed / far
    shape(state, gain * (wanted_x - state.aim_x), gain * (wanted_y - state.aim_y), tuning)


def shape_to_rest(state: State, tuning: Tuning) -> None:
    advance(state)
    speed = math.sqrt(state.aim_x**2 + state.aim_y**2)
    slowed = 0.0
    if speed > 0.0:
        slowed = (
            square_root_law(speed, tuning.limits.shaping_jerk, tuning.limits.shaping_jerk / tuning.limits.accel) / speed
        )
    shape(state, -slowed * state.aim_x, -slowed * state.aim_y, tuning)


def advance(state: State) -> None:
    state.target_x += STEP * (state.aim_x + state.push_x * STEP / 2)
    state.target_y += STEP * (state.aim_y + state.push_y * STEP / 2)
    state.aim_x, state.aim_y = state.aim_x + state.push_x * STEP, state.aim_y + state.push_y * STEP


def shape(state: State, x: float, y: float, tuning: Tuning) -> None:
    """Approach this target acceleration; braking takes precedence over turning."""
    x, y = within(x, y, 2.0 * tuning.limits.accel)
    speed = math.sqrt(state.aim_x**2 + state.aim_y**2)
    if speed > 0.0:
        dx, dy = state.aim_x / speed, state.aim_y / speed
        along, across = x * dx + y * dy, dx * y - dy * x
        if along > 0.0:
            across = min(max(across, -tuning.limits.accel), tuning.limits.accel)
            along = min(along, math.sqrt(tuning.limits.accel**2 - across * across))
        else:
            along = max(along, -tuning.limits.accel)
            room = math.sqrt(tuning.limits.accel**2 - along * along)
            across = min(max(across, -room), room)
        x, y = along * dx - across * dy, along * dy + across * dx
    x, y = within(x, y, tuning.limits.accel)
    x, y = within(x - state.push_x, y - state.push_y, tuning.limits.shaping_jerk * STEP)
    state.push_x, state.push_y = state.push_x + x, state.push_y + y


def within(x: float, y: float, most: float) -> tuple[float, float]:
    size = math.sqrt(x * x + y * y)
    if size <= most:
        return x, y
    return x * most / size, y * most / size
