"""ArduCopter step by step, as Python and compiled; `motion` defines the arguments."""

import math
from collections.abc import Sequence

from ipoa_mission.geometry import GRAVITY, ZERO, Enu, Samples, Vector, horizontal_norm, minus, norm, plus, scaled
from ipoa_mission.geometry import dot as enu_dot
from ipoa_mission.vehicles.arducopter.dynamics.motion import (
    STEP,
    THINNING,
    CopterLeg,
    Kind,
    MotionLimits,
    State,
    Tuning,
)
from ipoa_mission.vehicles.arducopter.dynamics.shaping import (
    along,
    climb_at,
    dot,
    leg_motion,
    level_off,
    orbit,
    rest_target,
    shape_to_rest,
    size,
    sqrt_controller,
    square,
)
from ipoa_mission.wind import wind_velocity

SAMPLE_STEPS = 5  # between samples
SETTLED_S, STEADY = 30.0, 1e-6  # age and acceleration of a steady cruise [s, m/s^2]


def along_limit(direction: Enu, limits: MotionLimits) -> float:
    """Return the limit along a unit vector."""
    horizontal = horizontal_norm(direction)
    vertical = limits.up if direction.up > 0.0 else limits.down
    if horizontal < 1e-9:
        return vertical
    if abs(direction.up) < 1e-9:
        return limits.horizontal / horizontal
    return min(limits.horizontal / horizontal, vertical / abs(direction.up))


def spline_at(leg: CopterLeg, u: float) -> tuple[Enu, Enu, float, float]:
    """Return place, direction, length of the derivative, and speed limit at parameter u."""
    a, b, c, d = leg.cubic[0], leg.cubic[1], leg.cubic[2], leg.cubic[3]
    place = plus(a, scaled(plus(b, scaled(plus(c, scaled(d, u)), u)), u))
    derivative = plus(b, scaled(plus(scaled(c, 2.0), scaled(d, 3.0 * u)), u))
    second = plus(scaled(c, 2.0), scaled(d, 6.0 * u))
    rate = norm(derivative)
    if rate < 1e-6:  # at rest: along its second derivative
        size = norm(second)
        if size < 1e-9:
            return place, ZERO, 0.0, 0.0
        direction = divided(second, size)
        return place, direction, 0.0, along_limit(direction, leg.speeds)
    direction = divided(derivative, rate)
    top = along_limit(direction, leg.speeds)
    inward = minus(second, scaled(direction, enu_dot(second, direction)))
    across = norm(inward)
    if across > 1e-9:
        most = along_limit(divided(inward, across), leg.accel)
        top = min(top, rate * math.sqrt(most / across))
    return place, direction, rate, top


def divided(vector: Enu, divisor: float) -> Enu:
    return Enu(vector.east / divisor, vector.north / divisor, vector.up / divisor)


def scaled_step(state: State, tuning: Tuning) -> float:
    """Slow the path's time if the vehicle lags; return its step [s]."""
    rate = 1.0
    fast = square(state.vel_desired) + state.vz_desired**2
    if fast > 1e-12:
        flown = dot(state.velocity, state.vel_desired) + state.time_scale * state.vz_desired**2
        behind = dot(state.target - state.place, state.vel_desired)
        rate = min(max(0.05 + (flown - tuning.limits.p_position * behind) / fast, 0.0), 1.0)
    state.time_scale += (rate - state.time_scale) * tuning.time_scale_gain
    return state.time_scale * STEP


def add_leg(state: State, leg: CopterLeg, t: float, way_back: float) -> None:
    """Add a leg's motion to the target's; `way_back` as in `leg_motion`."""
    a, v, s = along(leg, t)
    place, z, velocity, vz, accel, _ = leg_motion(leg, a, v, s, way_back)
    state.target += place
    state.target_z += z
    state.vel_desired += velocity
    state.vz_desired += vz
    state.accel_desired += accel


def turn_is_gentle(this: CopterLeg, following: CopterLeg, elapsed: float, tuning: Tuning) -> bool:
    """Return whether the overlap's middle is within radius and corner acceleration."""
    half = (this.profile.lasts - elapsed) / 2
    a, v, s = along(this, elapsed + half)
    place, z, _, _, accel, az = leg_motion(this, a, v, s, this.length)
    a, v, s = along(following, half)
    place_2, z_2, _, _, accel_2, az_2 = leg_motion(following, a, v, s, 0.0)
    place, z, accel, az = place + place_2, z + z_2, accel + accel_2, az + az_2
    if dot(place, place) + z * z >= tuning.limits.radius**2:
        return False
    return dot(accel, accel) < tuning.limits.corner_accel**2 and abs(az) < tuning.limits.accel_z


def along_legs(state: State, before: CopterLeg, this: CopterLeg, following: CopterLeg, tuning: Tuning) -> bool:
    """Sum all three legs; return whether this one is over."""
    h = scaled_step(state, tuning)
    state.leg_time += h
    rest_target(state, this.origin)
    add_leg(state, this, state.leg_time, 0.0)
    if before.kind == Kind.STRAIGHT:
        state.leg_time_before += h
        add_leg(state, before, state.leg_time_before, before.length)
    rest = this.profile.lasts - state.leg_time
    finished = rest <= 0.0
    if following.kind == Kind.STRAIGHT:
        if state.leg_time_next > 0.0:
            state.leg_time_next += h
        elif (
            state.leg_time >= this.profile.falls
            and 0.0 < rest <= following.profile.risen
            and turn_is_gentle(this, following, state.leg_time, tuning)
        ):
            state.leg_time_next = h / 2
        if state.leg_time_next > 0.0:
            add_leg(state, following, state.leg_time_next, 0.0)
            finished = finished or state.leg_time_next >= rest
    state.speed = math.sqrt(square(state.vel_desired) + state.vz_desired**2)
    return finished


def along_spline(state: State, this: CopterLeg, h: float) -> bool:
    """Return whether the spline is over."""
    state.leg_time += h
    place, direction, length, top = spline_at(this, min(state.spline_u, 1.0))
    left = norm(minus(this.target, place))
    most = along_limit(direction, this.accel)
    top = min(top, math.sqrt(2 * most * left + this.leave**2))
    speed = state.speed
    speed = max(speed - most * h, top) if speed > top else min(speed + most * h, top)
    if state.spline_u >= 1.0:  # waits for the vehicle
        speed = 0.0
    state.target = complex(place.east, place.north)
    state.target_z = place.up
    state.vel_desired = complex(speed * direction.east, speed * direction.north)
    state.vz_desired = speed * direction.up
    state.accel_desired = 0j
    state.speed = speed
    if length > 1e-6:
        state.spline_u += speed * h / length
    else:
        size = 2 * norm(this.cubic[2])
        state.spline_u += math.sqrt(2 * speed * h / size) if size > 1e-9 else 1.0
    return state.spline_u >= 1.0


def braked(error: float, speed: float, accel: float, gain: float) -> float:
    """Return the square-root controller's speed, less its decrease."""
    limit = sqrt_controller(error, accel, gain)
    if limit * speed <= 0.0:
        return limit
    if abs(error) <= accel / (gain * gain):
        return limit - speed
    return limit - accel / abs(limit) * speed / gain


def along_vertical(state: State, this: CopterLeg, tuning: Tuning) -> bool:
    """Return whether the climb or descent is over."""
    top = this.target.up
    if this.leave > 0.0:
        shape_to_rest(state, tuning)
    else:
        state.target = complex(this.target.east, this.target.north)
        state.vel_desired = 0j
        state.accel_desired = 0j
    state.time_scale = 1.0
    if this.kind == Kind.HOLD:
        state.leg_time += STEP
        state.target_z = top
        state.vz_desired = 0.0
        return state.leg_time >= this.lasts
    gain = tuning.limits.jerk_z / tuning.limits.accel_z
    if this.kind == Kind.CLIMB and tuning.limits.brakes_climb:
        climb_rate = min(braked(top - state.z, state.vz, tuning.limits.accel_z, gain), this.speeds.up)
    elif this.kind == Kind.CLIMB:
        climb_rate = min(sqrt_controller(top - state.z, tuning.limits.accel_z / 2, gain / 2), this.speeds.up)
    else:
        fall = sqrt_controller(tuning.limits.land_low - state.z, tuning.limits.accel_z, tuning.limits.p_height)
        climb_rate = min(
            max(fall, -max(tuning.limits.land_speed_high, tuning.limits.land_speed)), -tuning.limits.land_speed
        )
    climb_at(state, climb_rate, tuning)
    if this.kind == Kind.DESCENT:
        return state.target_z <= top
    slow = 0.1 * this.speeds.up
    if tuning.limits.brakes_climb:
        return state.target_z >= top - 0.5 * slow * slow / tuning.limits.accel_z and state.vz_desired < slow
    return state.target_z >= this.origin.up + 0.9 * (top - this.origin.up) and state.vz_desired < slow


def control(state: State, tuning: Tuning) -> None:
    limits = tuning.limits
    position_error = state.target - state.place - state.velocity * STEP
    distance = size(position_error)
    if distance > limits.accel / limits.p_position**2:
        position_error *= sqrt_controller(distance, limits.accel, limits.p_position) / (limits.p_position * distance)
    raw_error = state.vel_desired + limits.p_position * position_error - state.velocity - state.accel * STEP
    error_change = tuning.smoothing * (raw_error - state.error)
    error = state.error + error_change
    setpoint = (
        state.accel_desired + limits.p_velocity * error + state.integral + limits.d_velocity * error_change / STEP
    )
    integral = state.integral + limits.i_velocity * error * STEP
    if dot(setpoint, setpoint) > tuning.max_tilt_accel**2:
        setpoint = within_tilt(setpoint, state.vel_desired, tuning.max_tilt_accel)
        grown = math.sqrt(square(integral))
        integrated = math.sqrt(square(state.integral))
        if dot(error, setpoint) > 0.0 and grown > integrated:  # anti-windup
            integral = integral * integrated / grown
    state.error, state.integral, state.setpoint = error, integral, setpoint


def within_tilt(setpoint: complex, velocity: complex, most: float) -> complex:
    """The part across the path takes precedence."""
    speed = size(velocity)
    if speed < 1e-9:
        return setpoint * (most / size(setpoint))
    turned = setpoint * (velocity / speed).conjugate()
    across = min(max(turned.imag, -most), most)
    most_along = math.sqrt(most * most - across * across)
    return complex(min(max(turned.real, -most_along), most_along), across) * (velocity / speed)


def move(state: State, tuning: Tuning) -> None:
    state.shaped += (state.setpoint - state.shaped) * tuning.tilt_gain
    state.tilt += (state.shaped - state.tilt) * tuning.rotor_gain
    turn_yaw(state, tuning)
    climbed = state.vz_desired * state.time_scale
    state.vz = climbed + tuning.limits.p_height * (state.target_z - state.z - climbed * STEP)
    drag_accel, lift = drag(state, tuning)
    state.load = 1.0 - lift / GRAVITY
    state.accel = state.tilt * state.load + drag_accel
    state.velocity += state.accel * STEP
    state.place, state.z = state.place + state.velocity * STEP, state.z + state.vz * STEP
    state.time += STEP


def turn_yaw(state: State, tuning: Tuning) -> None:
    fast = square(state.vel_desired)
    if tuning.slew <= 0.0 or fast <= tuning.turning_from**2:
        return
    onward = dot(state.heading, state.vel_desired)
    if onward > 0.0 and fast - onward * onward < 1e-12 * fast:  # aligned
        return
    error = (math.atan2(state.vel_desired.real, state.vel_desired.imag) - state.yaw + math.pi) % (
        2.0 * math.pi
    ) - math.pi
    state.yaw += min(max(error, -tuning.slew), tuning.slew)
    state.heading = complex(math.sin(state.yaw), math.cos(state.yaw))


def drag(state: State, tuning: Tuning) -> tuple[complex, float]:
    """Return the horizontal and upward acceleration by drag [m/s^2]."""
    wind_east, wind_north = wind_velocity(state.z, tuning.wind)
    air = Enu(state.velocity.real - wind_east, state.velocity.imag - wind_north, state.vz)
    length = math.sqrt(GRAVITY**2 + state.tilt.real**2 + state.tilt.imag**2)
    upward = Enu(state.tilt.real / length, state.tilt.imag / length, GRAVITY / length)
    heading = state.heading
    forward_tilt = heading.real * upward.east + heading.imag * upward.north
    length = math.sqrt(1.0 - forward_tilt * forward_tilt)
    east = (heading.real - forward_tilt * upward.east) / length
    forward = Enu(east, (heading.imag - forward_tilt * upward.north) / length, -forward_tilt * upward.up / length)
    left = Enu(
        upward.north * forward.up - upward.up * forward.north,
        upward.up * forward.east - upward.east * forward.up,
        upward.east * forward.north - upward.north * forward.east,
    )
    thinner = THINNING * state.z
    rotors = tuning.airframe.rotor_drag * (1.0 - thinner / 2.0) * math.sqrt(state.load / upward.up)
    body = tuning.airframe.body_drag * (1.0 - thinner)
    accel = scaled(air, -rotors)
    for axis in (upward, forward, left):
        speed = enu_dot(air, axis)
        accel = minus(accel, scaled(axis, body * speed * abs(speed)))
    return complex(accel.east, accel.north), accel.up


def step(state: State, before: CopterLeg, this: CopterLeg, following: CopterLeg, tuning: Tuning) -> bool:
    """Return whether the leg counts as passed."""
    if this.kind == Kind.STRAIGHT:
        finished = along_legs(state, before, this, following, tuning)
    elif this.kind == Kind.SPLINE:
        finished = along_spline(state, this, scaled_step(state, tuning))
    elif this.kind == Kind.ORBIT:
        finished = orbit(state, this, tuning)
    elif this.kind == Kind.LEVEL_OFF:
        finished = level_off(state, this, tuning)
    else:
        finished = along_vertical(state, this, tuning)
    control(state, tuning)
    move(state, tuning)
    if this.kind > Kind.SPLINE or following.kind > Kind.NOTHING or this.leave > 0.0:
        return finished
    left = complex(this.target.east, this.target.north) - state.place
    return (finished or this.ends_near > 0.0) and dot(left, left) <= tuning.limits.radius**2


def pass_over_cruise(state: State, this: CopterLeg) -> None:
    left = this.profile.falls - state.leg_time - SETTLED_S
    if (
        this.kind != Kind.STRAIGHT
        or this.turn != 0.0
        or left < SETTLED_S
        or state.leg_time < this.profile.risen + SETTLED_S
        or state.time_scale <= 0.0
    ):
        return
    if this.direction.up != 0.0 or abs(state.accel.real) + abs(state.accel.imag) > STEADY:
        return
    distance = left * along(this, state.leg_time)[1]
    skipped = complex(distance * this.direction.east, distance * this.direction.north)
    state.place += skipped
    state.target += skipped
    state.time += left / state.time_scale
    state.leg_time += left


def fly_leg(
    states: Sequence[State],
    before: Sequence[CopterLeg],
    this: Sequence[CopterLeg],
    following: Sequence[CopterLeg],
    tuning: Tuning,
    samples: Samples,
) -> int:
    """Fly until this leg is passed; return the number of samples.

    -1: no room for more samples, -2: blown off. States and legs are sequences of one.
    """
    state = states[0]
    leg = this[0]
    used = 0
    count = 0
    passed = False
    while not passed:
        passed = step(state, before[0], leg, following[0], tuning)
        pass_over_cruise(state, leg)
        count += 1
        if count % SAMPLE_STEPS == 0:
            if used >= len(samples):
                return -1
            write_sample(state, samples[used])
            used += 1
            lag = state.target - state.place
            if dot(lag, lag) > tuning.most_astray**2:
                return -2
    return used


def write_sample(state: State, row: Vector) -> None:
    row[0], row[1], row[2], row[3] = state.time, state.place.real, state.place.imag, state.z
    row[4], row[5], row[6] = state.velocity.real, state.velocity.imag, state.vz
