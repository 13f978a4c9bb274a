"""ArduCopter step by step, as Python and compiled; `motion` defines the arguments."""

import math
from collections.abc import Sequence

from ipoa_mission.geometry import GRAVITY, Points, Vector
from ipoa_mission.vehicles.arducopter.dynamics.airframe import THINNING
from ipoa_mission.vehicles.arducopter.dynamics.motion import STEP, CopterLeg, Kind, MotionLimits, State, Tuning
from ipoa_mission.vehicles.arducopter.dynamics.shaping import (
    along,
    climb_at,
    level_off,
    on_way,
    orbit,
    shape_to_rest,
    square_root_law,
)
from ipoa_mission.wind import wind_at

Triple = tuple[float, float, float]

SAMPLE_STEPS = 5  # between samples
SETTLED_S, STEADY = 30.0, 1e-6  # age and acceleration of a steady cruise [s, m/s^2]


def along_limit(x: float, y: float, z: float, limits: MotionLimits) -> float:
    level, vertical = math.sqrt(x * x + y * y), limits.up if z > 0.0 else limits.down
    if level < 1e-9:
        return vertical
    if abs(z) < 1e-9:
        return limits.level / level
    return min(limits.level / level, vertical / abs(z))


def bend(leg: CopterLeg, u: float) -> tuple[Triple, Triple, float, float]:
    """Return place, direction, length of the derivative, and speed limit at parameter u."""
    a, b, c, d = leg.cubic[0], leg.cubic[1], leg.cubic[2], leg.cubic[3]
    px, vx, ax = a.x + u * (b.x + u * (c.x + u * d.x)), b.x + u * (2 * c.x + 3 * u * d.x), 2 * c.x + 6 * u * d.x
    py, vy, ay = a.y + u * (b.y + u * (c.y + u * d.y)), b.y + u * (2 * c.y + 3 * u * d.y), 2 * c.y + 6 * u * d.y
    pz, vz, az = a.z + u * (b.z + u * (c.z + u * d.z)), b.z + u * (2 * c.z + 3 * u * d.z), 2 * c.z + 6 * u * d.z
    rate = math.sqrt(vx * vx + vy * vy + vz * vz)
    if rate < 1e-6:  # at rest: along its second derivative
        size = math.sqrt(ax * ax + ay * ay + az * az)
        if size < 1e-9:
            return (px, py, pz), (0.0, 0.0, 0.0), 0.0, 0.0
        vx, vy, vz = ax / size, ay / size, az / size
        return (px, py, pz), (vx, vy, vz), 0.0, along_limit(vx, vy, vz, leg.speeds)
    vx, vy, vz = vx / rate, vy / rate, vz / rate
    top = along_limit(vx, vy, vz, leg.speeds)
    inward = ax * vx + ay * vy + az * vz
    ax, ay, az = ax - inward * vx, ay - inward * vy, az - inward * vz
    across = math.sqrt(ax * ax + ay * ay + az * az)
    if across > 1e-9:
        most = along_limit(ax / across, ay / across, az / across, leg.accel)
        top = min(top, rate * math.sqrt(most / across))
    return (px, py, pz), (vx, vy, vz), rate, top


def clock_step(state: State, tuning: Tuning) -> float:
    """Slow the path's clock if the vehicle lags; return its step [s]."""
    wanted = 1.0
    square = state.aim_x**2 + state.aim_y**2 + state.aim_z**2
    if square > 1e-12:
        flown = state.vx * state.aim_x + state.vy * state.aim_y + state.rate * state.aim_z**2
        behind = (state.target_x - state.x) * state.aim_x + (state.target_y - state.y) * state.aim_y
        wanted = min(max(0.05 + (flown - tuning.limits.p_position * behind) / square, 0.0), 1.0)
    state.rate += (wanted - state.rate) * tuning.slowing
    return state.rate * STEP


def add_leg(state: State, leg: CopterLeg, t: float, way_back: float) -> None:
    """Add a leg's motion to the target's; `way_back` as in `on_way`."""
    a, v, s = along(leg, t)
    (x, y, z), (vx, vy, vz), (ax, ay, _) = on_way(leg, a, v, s, way_back)
    state.target_x, state.aim_x, state.push_x = state.target_x + x, state.aim_x + vx, state.push_x + ax
    state.target_y, state.aim_y, state.push_y = state.target_y + y, state.aim_y + vy, state.push_y + ay
    state.target_z, state.aim_z = state.target_z + z, state.aim_z + vz


def turn_is_gentle(this: CopterLeg, following: CopterLeg, elapsed: float, tuning: Tuning) -> bool:
    """Return whether the overlap's middle is within radius and corner acceleration."""
    half = (this.profile.lasts - elapsed) / 2
    a, v, s = along(this, elapsed + half)
    (x, y, z), _, (ax, ay, az) = on_way(this, a, v, s, this.length)
    a, v, s = along(following, half)
    (x2, y2, z2), _, (ax2, ay2, az2) = on_way(following, a, v, s, 0.0)
    x, y, z = x + x2, y + y2, z + z2
    if x * x + y * y + z * z >= tuning.limits.radius**2:
        return False
    x, y, z = ax + ax2, ay + ay2, az + az2
    return x * x + y * y < tuning.limits.corner_accel**2 and abs(z) < tuning.limits.accel_z


def along_legs(state: State, before: CopterLeg, this: CopterLeg, following: CopterLeg, tuning: Tuning) -> bool:
    """Sum all three legs; return whether this one is over."""
    h = clock_step(state, tuning)
    state.clock += h
    state.target_x, state.target_y, state.target_z = this.origin.x, this.origin.y, this.origin.z
    state.aim_x = state.aim_y = state.aim_z = state.push_x = state.push_y = 0.0
    add_leg(state, this, state.clock, 0.0)
    if before.kind == Kind.STRAIGHT:
        state.clock_before += h
        add_leg(state, before, state.clock_before, before.length)
    rest = this.profile.lasts - state.clock
    finished = rest <= 0.0
    if following.kind == Kind.STRAIGHT:
        if state.clock_next > 0.0:
            state.clock_next += h
        elif (
            state.clock >= this.profile.falls
            and 0.0 < rest <= following.profile.risen
            and turn_is_gentle(this, following, state.clock, tuning)
        ):
            state.clock_next = h / 2
        if state.clock_next > 0.0:
            add_leg(state, following, state.clock_next, 0.0)
            finished = finished or state.clock_next >= rest
    state.speed = math.sqrt(state.aim_x**2 + state.aim_y**2 + state.aim_z**2)
    return finished


def along_spline(state: State, this: CopterLeg, h: float) -> bool:
    """Return whether the spline is over."""
    state.clock += h
    (x, y, z), (dx, dy, dz), length, top = bend(this, min(state.share, 1.0))
    left = math.sqrt((this.target.x - x) ** 2 + (this.target.y - y) ** 2 + (this.target.z - z) ** 2)
    most = along_limit(dx, dy, dz, this.accel)
    top, speed = min(top, math.sqrt(2 * most * left + this.leave**2)), state.speed
    speed = max(speed - most * h, top) if speed > top else min(speed + most * h, top)
    if state.share >= 1.0:  # waits for the vehicle
        speed = 0.0
    state.target_x, state.target_y, state.target_z = x, y, z
    state.aim_x, state.aim_y, state.aim_z = speed * dx, speed * dy, speed * dz
    state.push_x = state.push_y = 0.0
    state.speed = speed
    if length > 1e-6:
        state.share += speed * h / length
    else:
        c = this.cubic[2]
        size = 2 * math.sqrt(c.x * c.x + c.y * c.y + c.z * c.z)
        state.share += math.sqrt(2 * speed * h / size) if size > 1e-9 else 1.0
    return state.share >= 1.0


def braked(error: float, speed: float, accel: float, gain: float) -> float:
    """Return the square-root law's speed, less its decrease."""
    wanted = square_root_law(error, accel, gain)
    if wanted * speed <= 0.0:
        return wanted
    if abs(error) <= accel / (gain * gain):
        return wanted - speed
    return wanted - accel / abs(wanted) * speed / gain


def upright(state: State, this: CopterLeg, tuning: Tuning) -> bool:
    """Return whether the climb or descent is over."""
    top = this.target.z
    if this.leave > 0.0:
        shape_to_rest(state, tuning)
    else:
        state.target_x, state.target_y = this.target.x, this.target.y
        state.aim_x = state.aim_y = state.push_x = state.push_y = 0.0
    state.rate = 1.0
    if this.kind == Kind.HOLD:
        state.clock += STEP
        state.target_z, state.aim_z = top, 0.0
        return state.clock >= this.lasts
    gain = tuning.limits.jerk_z / tuning.limits.accel_z
    if this.kind == Kind.CLIMB and tuning.limits.brakes_climb:
        wanted = min(braked(top - state.z, state.vz, tuning.limits.accel_z, gain), this.speeds.up)
    elif this.kind == Kind.CLIMB:
        wanted = min(square_root_law(top - state.z, tuning.limits.accel_z / 2, gain / 2), this.speeds.up)
    else:
        fall = square_root_law(tuning.limits.land_low - state.z, tuning.limits.accel_z, tuning.limits.p_height)
        wanted = min(
            max(fall, -max(tuning.limits.land_speed_high, tuning.limits.land_speed)), -tuning.limits.land_speed
        )
    climb_at(state, wanted, tuning)
    if this.kind == Kind.DESCENT:
        return state.target_z <= top
    slow = 0.1 * this.speeds.up
    if tuning.limits.brakes_climb:
        return state.target_z >= top - 0.5 * slow * slow / tuning.limits.accel_z and state.aim_z < slow
    return state.target_z >= this.origin.z + 0.9 * (top - this.origin.z) and state.aim_z < slow


def control(state: State, tuning: Tuning) -> None:
    x, y = state.target_x - state.x - state.vx * STEP, state.target_y - state.y - state.vy * STEP
    far = math.sqrt(x * x + y * y)
    if far > tuning.limits.accel / tuning.limits.p_position**2:
        nearer = square_root_law(far, tuning.limits.accel, tuning.limits.p_position) / (tuning.limits.p_position * far)
        x, y = x * nearer, y * nearer
    x = state.aim_x + tuning.limits.p_position * x - state.vx - state.ax * STEP
    y = state.aim_y + tuning.limits.p_position * y - state.vy - state.ay * STEP
    gain_x, gain_y = tuning.smoothing * (x - state.error_x), tuning.smoothing * (y - state.error_y)
    ex, ey = state.error_x + gain_x, state.error_y + gain_y
    x = state.push_x + tuning.limits.p_velocity * ex + state.integral_x + tuning.limits.d_velocity * gain_x / STEP
    y = state.push_y + tuning.limits.p_velocity * ey + state.integral_y + tuning.limits.d_velocity * gain_y / STEP
    sum_x, sum_y = (
        state.integral_x + tuning.limits.i_velocity * ex * STEP,
        state.integral_y + tuning.limits.i_velocity * ey * STEP,
    )
    if x * x + y * y > tuning.most_lean**2:
        x, y = within_lean(x, y, state.aim_x, state.aim_y, tuning.most_lean)
        grown, was = math.sqrt(sum_x**2 + sum_y**2), math.sqrt(state.integral_x**2 + state.integral_y**2)
        if ex * x + ey * y > 0.0 and grown > was:  # anti-windup
            sum_x, sum_y = sum_x * was / grown, sum_y * was / grown
    state.error_x, state.error_y, state.integral_x, state.integral_y = ex, ey, sum_x, sum_y
    state.asked_x, state.asked_y = x, y


def within_lean(x: float, y: float, aim_x: float, aim_y: float, most: float) -> tuple[float, float]:
    """The part across the path takes precedence."""
    flat = math.sqrt(aim_x * aim_x + aim_y * aim_y)
    if flat < 1e-9:
        size = most / math.sqrt(x * x + y * y)
        return x * size, y * size
    dx, dy = aim_x / flat, aim_y / flat
    across = min(max(dx * y - dy * x, -most), most)
    room = math.sqrt(most * most - across * across)
    onward = min(max(dx * x + dy * y, -room), room)
    return onward * dx - across * dy, onward * dy + across * dx


def move(state: State, tuning: Tuning) -> None:
    state.shaped_x += (state.asked_x - state.shaped_x) * tuning.leaning
    state.shaped_y += (state.asked_y - state.shaped_y) * tuning.leaning
    state.lean_x += (state.shaped_x - state.lean_x) * tuning.turning
    state.lean_y += (state.shaped_y - state.lean_y) * tuning.turning
    turn_nose(state, tuning)
    climbed = state.aim_z * state.rate
    state.vz = climbed + tuning.limits.p_height * (state.target_z - state.z - climbed * STEP)
    x, y, lift = drag(state, tuning)
    state.load = 1.0 - lift / GRAVITY
    state.ax, state.ay = state.lean_x * state.load + x, state.lean_y * state.load + y
    state.vx, state.vy = state.vx + state.ax * STEP, state.vy + state.ay * STEP
    state.x, state.y, state.z = state.x + state.vx * STEP, state.y + state.vy * STEP, state.z + state.vz * STEP
    state.time += STEP


def turn_nose(state: State, tuning: Tuning) -> None:
    fast = state.aim_x**2 + state.aim_y**2
    if tuning.slew <= 0.0 or fast <= tuning.turning_from**2:
        return
    onward = state.nose_x * state.aim_x + state.nose_y * state.aim_y
    if onward > 0.0 and fast - onward * onward < 1e-12 * fast:  # aligned
        return
    error = (math.atan2(state.aim_x, state.aim_y) - state.yaw + math.pi) % (2.0 * math.pi) - math.pi
    state.yaw += min(max(error, -tuning.slew), tuning.slew)
    state.nose_x, state.nose_y = math.sin(state.yaw), math.cos(state.yaw)


def drag(state: State, tuning: Tuning) -> Triple:
    east, north = wind_at(state.z, tuning.wind)
    x, y, z = state.vx - east, state.vy - north, state.vz
    size = math.sqrt(GRAVITY**2 + state.lean_x**2 + state.lean_y**2)
    nx, ny, nz = state.lean_x / size, state.lean_y / size, GRAVITY / size  # axes: up, forward, left
    fx, fy = state.nose_x, state.nose_y
    tilt = fx * nx + fy * ny
    size = math.sqrt(1.0 - tilt * tilt)
    fx, fy, fz = (fx - tilt * nx) / size, (fy - tilt * ny) / size, -tilt * nz / size
    sx, sy, sz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
    up, on, aside = x * nx + y * ny + z * nz, x * fx + y * fy + z * fz, x * sx + y * sy + z * sz
    thinner = THINNING * state.z
    k = tuning.airframe.body_drag * (1.0 - thinner)
    up, on, aside = k * up * abs(up), k * on * abs(on), k * aside * abs(aside)
    k = tuning.airframe.rotor_drag * (1.0 - thinner / 2.0) * math.sqrt(state.load / nz)
    return (
        -k * x - up * nx - on * fx - aside * sx,
        -k * y - up * ny - on * fy - aside * sy,
        -k * z - up * nz - on * fz - aside * sz,
    )


def step(state: State, before: CopterLeg, this: CopterLeg, following: CopterLeg, tuning: Tuning) -> bool:
    """Return whether the leg counts as passed."""
    if this.kind == Kind.STRAIGHT:
        finished = along_legs(state, before, this, following, tuning)
    elif this.kind == Kind.SPLINE:
        finished = along_spline(state, this, clock_step(state, tuning))
    elif this.kind == Kind.ORBIT:
        finished = orbit(state, this, tuning)
    elif this.kind == Kind.LEVEL_OFF:
        finished = level_off(state, this, tuning)
    else:
        finished = upright(state, this, tuning)
    control(state, tuning)
    move(state, tuning)
    if this.kind > Kind.SPLINE or following.kind > Kind.NOTHING or this.leave > 0.0:
        return finished
    ex, ey = this.target.x - state.x, this.target.y - state.y
    return (finished or this.ends_near > 0.0) and ex * ex + ey * ey <= tuning.limits.radius**2


def pass_over_cruise(state: State, this: CopterLeg) -> None:
    left = this.profile.falls - state.clock - SETTLED_S
    if (
        this.kind != Kind.STRAIGHT
        or this.turn != 0.0
        or left < SETTLED_S
        or state.clock < this.profile.risen + SETTLED_S
        or state.rate <= 0.0
    ):
        return
    if this.direction.z != 0.0 or abs(state.ax) + abs(state.ay) > STEADY:
        return
    way = left * along(this, state.clock)[1]
    east, north = way * this.direction.x, way * this.direction.y
    state.x, state.y = state.x + east, state.y + north
    state.target_x, state.target_y = state.target_x + east, state.target_y + north
    state.time, state.clock = state.time + left / state.rate, state.clock + left


def fly_leg(
    states: Sequence[State],
    before: Sequence[CopterLeg],
    this: Sequence[CopterLeg],
    following: Sequence[CopterLeg],
    tuning: Tuning,
    samples: Points,
) -> int:
    """Fly until this leg is passed; return the number of samples (time, place, velocity; n, 7).

    -1: no room for more samples, -2: blown off. States and legs are sequences of one.
    """
    state, leg, used, count, passed = states[0], this[0], 0, 0, False
    while not passed:
        passed = step(state, before[0], leg, following[0], tuning)
        pass_over_cruise(state, leg)
        count += 1
        if count % SAMPLE_STEPS == 0:
            if used >= len(samples):
                return -1
            keep(state, samples[used])
            used += 1
            x, y = state.target_x - state.x, state.target_y - state.y
            if x * x + y * y > tuning.most_astray**2:
                return -2
    return used


def keep(state: State, row: Vector) -> None:
    row[0], row[1], row[2], row[3] = state.time, state.x, state.y, state.z
    row[4], row[5], row[6] = state.vx, state.vy, state.vz
