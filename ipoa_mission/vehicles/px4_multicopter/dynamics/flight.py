"""One step of PX4: smoothed trajectory, position controller, body and sensors.

The trajectory has three spans of constant jerk per axis, ending together. After a climb the hover thrust estimate is
too large, as it ignores drag. Anti-windup then reduces the horizontal integrator: PX4 flies slower.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ipoa_mission.geometry import GRAVITY, ZERO, Enu, Samples, Vector, horizontal_norm
from ipoa_mission.vehicles.px4_multicopter.dynamics.guidance import (
    climb_limits,
    detect_contact,
    guide,
    heading_error,
    is_low_take_off,
    touches_down,
    turn_yaw,
    velocity_setpoint,
)
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    CORRECTED_FOR,
    GO,
    LAND,
    NOT_BEGUN,
    NOT_YET,
    NOTICED_S,
    ON_LINE,
    TAKE_OFF,
    UNKNOWN,
    Axis,
    Body,
    Contact,
    Control,
    EastNorth,
    Errors,
    FlightProgress,
    Guidance,
    Motion,
    SimulationConstants,
    State,
    Trajectory,
    Yaw,
    add_sensor_errors,
    as_tuple,
    integrate,
    no_errors,
)
from ipoa_mission.vehicles.px4_multicopter.limits import STAGES, Px4Limits

SETTLED_S = 30.0  # of steady flight before a part of a leg is skipped [s]
HOVER_SURE, HOVER_SURE_UP = 10.0, 2.0  # of good hover thrust estimates: HTE_VXY_THR, HTE_VZ_THR [m/s]


def control_velocity(
    state: State, trajectory: Trajectory, motion: Motion, constants: SimulationConstants
) -> tuple[Enu, Control]:
    """Return the acceleration setpoint (horizontal by tilt, up by thrust over weight), and the controller's next state.

    A take-off ramps up the climb limit, without acceleration feed-forward.
    """
    limits = constants.limits
    body = state.body
    before = state.control
    dt = constants.dt
    velocity = horizontal_velocity(trajectory, body, limits, dt)
    east = velocity.east - body.speed.east - body.acceleration.east * dt
    north = velocity.north - body.speed.north - body.acceleration.north * dt
    accel_east = trajectory.east.acceleration + limits.p_velocity * east + before.integral.east
    accel_north = trajectory.north.acceleration + limits.p_velocity * north + before.integral.north
    accel_east -= limits.d_velocity * body.acceleration.east
    accel_north -= limits.d_velocity * body.acceleration.north
    max_climb = limits.max_climb
    feed_forward = trajectory.up.acceleration
    ramp = state.time - state.begun
    if motion.kind == TAKE_OFF and ramp < limits.takeoff_ramp:
        none = -GRAVITY / limits.p_climb
        max_climb = none + ramp / limits.takeoff_ramp * (max_climb - none)
        feed_forward = 0.0
    climb = trajectory.up.speed + limits.p_height * (trajectory.up.place - body.place.up)
    up = min(max(climb, -limits.max_descent), max_climb) - body.speed.up
    thrust = max(feed_forward + limits.p_climb * up + before.integral.up, -GRAVITY)
    size = math.sqrt(accel_east * accel_east + accel_north * accel_north)
    scale = 1.0 if size <= constants.max_tilt_accel else constants.max_tilt_accel / size
    # anti-windup: with too little tilt or thrust
    back = 2.0 / limits.p_velocity * max(1.0 - scale * (1.0 + thrust / GRAVITY) / before.hover, 0.0)
    integral = Enu(
        before.integral.east + limits.i_velocity * (east - back * accel_east) * dt,
        before.integral.north + limits.i_velocity * (north - back * accel_north) * dt,
        before.integral.up + (limits.i_climb * up * dt if up > 0.0 or thrust > -GRAVITY else 0.0),
    )
    return Enu(accel_east * scale, accel_north * scale, thrust), Control(integral, before.hover, thrust)


def horizontal_velocity(trajectory: Trajectory, body: Body, limits: Px4Limits, dt: float) -> EastNorth:
    x: Axis = trajectory.east
    y: Axis = trajectory.north
    east = x.speed + limits.p_position * (x.place - body.place.east - body.speed.east * dt)
    north = y.speed + limits.p_position * (y.place - body.place.north - body.speed.north * dt)
    size = math.sqrt(east * east + north * north)
    scale = 1.0 if size <= limits.max_speed else limits.max_speed / size
    return EastNorth(east * scale, north * scale)


def learn_hover(control: Control, body: Body, constants: SimulationConstants, time: float) -> Control:
    """Update the learned hover thrust, which counts drag in a climb as weight."""
    horizontal_speed = horizontal_norm(body.speed)
    doubt = 1.0 + 10.0 * max(abs(body.speed.up) - HOVER_SURE_UP, horizontal_speed - HOVER_SURE, 0.0)
    share = (1.0 / constants.limits.hover_learning + 1.0 / max(time - body.airborne_since, 1.0)) * constants.dt / doubt
    hover = 1.0 + constants.airframe.drag * body.speed.up / GRAVITY
    return Control(control.integral, control.hover + (hover - control.hover) * min(share, 1.0), control.thrust)


class Profile(NamedTuple):
    jerk: float  # [m/s^3, signed]
    rise: float  # duration of the jerk [s]
    coast: float  # of none
    fall: float  # of the opposite jerk


def quickest_change(axis: Axis, goal: float, accel: float, jerk: float) -> Profile:
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


def stretch(axis: Axis, goal: float, accel: float, profile: Profile, lasts: float) -> Profile:
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


def move(axis: Axis, profile: Profile, t: float) -> Axis:
    """Return the axis `t` s later; after the profile its speed is constant."""
    for lasts, jerk in ((profile.rise, profile.jerk), (profile.coast, 0.0), (profile.fall, -profile.jerk)):
        d = min(t, lasts)
        if d > 0.0:
            a = axis.acceleration
            place = axis.place + d * (axis.speed + d * (a / 2.0 + d * jerk / 6.0))
            axis = Axis(place, axis.speed + d * (a + d * jerk / 2.0), a + d * jerk)
            t -= d
    return Axis(axis.place + t * axis.speed, axis.speed, 0.0) if t > 0.0 else axis


def smooth(
    trajectory: Trajectory, velocity: Enu, limits: Px4Limits, accel_up: float, times: tuple[float, float]
) -> Trajectory:
    """Return the trajectory later by `times` [s], horizontal and upwards."""
    x, y, z = trajectory
    t, t_up = times
    accel, jerk = limits.accel, limits.jerk
    east, north = quickest_change(x, velocity.east, accel, jerk), quickest_change(y, velocity.north, accel, jerk)
    up = quickest_change(z, velocity.up, accel_up, jerk)
    longest = max(east.rise + east.coast + east.fall, north.rise + north.coast + north.fall)
    longest = max(longest, up.rise + up.coast + up.fall)
    return Trajectory(
        move(x, stretch(x, velocity.east, accel, east, longest), t),
        move(y, stretch(y, velocity.north, accel, north, longest), t),
        move(z, stretch(z, velocity.up, accel_up, up, longest), t_up),
    )


STANDING = 1e-6  # a slower trajectory waits for the vehicle [m/s]
SPLIT = 2.0**29 + 1.0  # Veltkamp's, to single precision
GROUND_SINK = 0.7  # [m/s]


def step(state: State, motion: Motion, constants: SimulationConstants) -> State:
    limits = constants.limits
    standing = touches_down(state, motion)
    velocity, guidance = velocity_setpoint(state, motion, constants, guide(state, motion, limits))
    trajectory = track_setpoint(state, motion, constants, velocity)
    setpoint, control = control_velocity(state, trajectory, motion, constants)
    if not (standing or state.body.on_ground):
        control = learn_hover(control, state.body, constants, state.time)
    body = integrate(state, setpoint, constants, standing)
    errors = add_sensor_errors(state, constants)
    if errors.reported != state.errors.reported:
        guidance = Guidance(UNKNOWN, guidance.anchor, guidance.held, guidance.rising)
    contact = detect_contact(state, body, setpoint.up, constants) if motion.kind == LAND else state.contact
    time = state.time + constants.dt
    there = state.been_there or is_there(body, errors, contact, motion)
    reached = state.reached
    faces = math.isnan(motion.heading) or abs(heading_error(state, motion)) <= limits.yaw_error
    if there and reached < 0.0 and faces:
        reached = time
    yaw = turn_yaw(state, motion, limits, constants.dt) if constants.turns else state.yaw
    return State(
        time=time, body=body, yaw=yaw, trajectory=trajectory, guidance=guidance, control=control,
        errors=errors, contact=contact, begun=state.begun, reached=reached, been_there=there,
    )  # fmt: skip


def track_setpoint(state: State, motion: Motion, constants: SimulationConstants, velocity: Enu) -> Trajectory:
    """Return the trajectory a step later, stretched while the vehicle lags."""
    limits = constants.limits
    place = state.body.place
    before = state.trajectory
    low = is_low_take_off(state, motion, limits)
    climb = climb_limits(state.guidance.rising, low, limits)
    if low:
        before = Trajectory(before.east, before.north, Axis(place.up, before.up.speed, before.up.acceleration))
    most = limits.max_speed
    within = Enu(
        min(max(velocity.east, -most), most),
        min(max(velocity.north, -most), most),
        min(max(velocity.up, -climb.rate), climb.rate),
    )
    east = before.east.place - place.east
    north = before.north.place - place.north
    behind = 0.0
    standing = math.sqrt(before.east.speed * before.east.speed + before.north.speed * before.north.speed) < STANDING
    if standing or east * before.east.speed + north * before.north.speed >= 0.0:
        behind = math.sqrt(east * east + north * north)
    pace = pace_up = 1.0 - min(behind / limits.max_lag, 1.0)
    if limits.decoupled_axes:
        pace_up = 1.0
        lead = before.up.place - place.up
        if limits.max_height_error > 0.0 and lead * before.up.speed >= 0.0:
            pace_up = 1.0 - min(abs(lead) / limits.max_height_error, 1.0)
    now = smooth(before, within, limits, climb.accel, (constants.dt * pace, constants.dt * pace_up))
    if motion.kind != LAND:
        return now
    return Trajectory(in_single(now.east), in_single(now.north), now.up)


def in_single(axis: Axis) -> Axis:
    """Round places as PX4 does: lost steps leave a speed that delays a landing."""
    wide = SPLIT * axis.place
    return Axis(wide - (wide - axis.place), axis.speed, axis.acceleration)


def is_there(body: Body, errors: Errors, contact: Contact, motion: Motion) -> bool:
    """The navigator knows home's corrections at once."""
    if motion.kind == LAND:
        return contact.stages >= STAGES
    error = errors.home_height_error if motion.follows_home else 0.0
    if motion.kind == TAKE_OFF:
        return body.place.up > motion.goal.up + error - motion.height_radius
    east, north = body.place.east - motion.goal.east, body.place.north - motion.goal.north
    near = east * east + north * north <= motion.radius * motion.radius
    return near and abs(body.place.up - error - motion.goal.up) <= motion.height_radius


def is_over(state: State, motion: Motion) -> bool:
    return state.reached >= 0.0 and state.time - state.reached >= max(motion.hold_s, NOTICED_S)


def at_rest(place: Enu, time: float, yaw: float, errors: Errors, on_ground: bool) -> State:
    body = Body(
        place=place, speed=ZERO, acceleration=EastNorth(0.0, 0.0), setpoint=EastNorth(0.0, 0.0),
        thrust=ZERO, on_ground=on_ground, airborne_since=time,
    )  # fmt: skip
    east = Axis(place.east, 0.0, 0.0)
    trajectory = Trajectory(east, Axis(place.north, 0.0, 0.0), Axis(place.up, 0.0, 0.0))
    guidance = Guidance(ON_LINE, place, 0.0, True)
    control = Control(ZERO, 1.0, 0.0)
    contact = Contact(on_ground=False, lost=False, stages=0, since=time)
    return State(
        time=time, body=body, yaw=Yaw(yaw, 0.0), trajectory=trajectory, guidance=guidance, control=control,
        errors=errors, contact=contact, begun=time, reached=NOT_YET, been_there=False,
    )  # fmt: skip


def begin(state: State, motion: Motion) -> State:
    trajectory = state.trajectory
    body = state.body
    on_ground = body.on_ground and motion.kind == TAKE_OFF
    if on_ground:
        trajectory = Trajectory(trajectory.east, trajectory.north, Axis(trajectory.up.place, -GROUND_SINK, 0.0))
    body = Body(
        place=body.place, speed=body.speed, acceleration=body.acceleration, setpoint=body.setpoint,
        thrust=body.thrust, on_ground=on_ground, airborne_since=body.airborne_since,
    )  # fmt: skip
    guidance = Guidance(ON_LINE, as_tuple(motion.start), state.guidance.held, state.guidance.rising)
    return State(
        time=state.time, body=body, yaw=state.yaw, trajectory=trajectory, guidance=guidance,
        control=state.control, errors=state.errors,
        contact=Contact(on_ground=False, lost=False, stages=0, since=state.time),
        begun=state.time, reached=NOT_YET, been_there=False,
    )  # fmt: skip


def past_cruise(state: State, motion: Motion, constants: SimulationConstants) -> State:
    """Skip the steady middle of a long level leg; sensor errors stay."""
    x, y, body = state.trajectory.east, state.trajectory.north, state.body
    speed = math.sqrt(x.speed * x.speed + y.speed * y.speed)
    since = body.airborne_since
    is_on_line = motion.kind == GO and state.guidance.side == ON_LINE
    if not is_on_line or state.time - state.begun < SETTLED_S or speed < 0.1:
        return state
    east = motion.goal.east - x.place
    north = motion.goal.north - y.place
    far = math.sqrt(east * east + north * north)
    coast = far - speed * SETTLED_S - speed * speed / constants.limits.accel
    if coast < speed * SETTLED_S or state.time - since < CORRECTED_FOR + SETTLED_S:
        return state
    if motion.goal.up != motion.start.up or x.acceleration * x.acceleration + y.acceleration * y.acceleration > 0.0:
        return state
    skipped_east = east * coast / far
    skipped_north = north * coast / far
    time = state.time + coast / speed
    x = Axis(x.place + skipped_east, x.speed, x.acceleration)
    y = Axis(y.place + skipped_north, y.speed, y.acceleration)
    trajectory = Trajectory(x, y, state.trajectory.up)
    place = Enu(body.place.east + skipped_east, body.place.north + skipped_north, body.place.up)
    moved = Body(
        place=place, speed=body.speed, acceleration=body.acceleration, setpoint=body.setpoint,
        thrust=body.thrust, on_ground=body.on_ground, airborne_since=since,
    )  # fmt: skip
    return State(
        time=time, body=moved, yaw=state.yaw, trajectory=trajectory, guidance=state.guidance, control=state.control,
        errors=state.errors, contact=state.contact, begun=state.begun, reached=state.reached,
        been_there=state.been_there,
    )  # fmt: skip


def at_start(height: float, seed: int) -> FlightProgress:
    first, second = (float(1 + x % 2_000_000_000) for x in np.random.SeedSequence(seed).generate_state(2))
    state = at_rest(Enu(0.0, 0.0, height), 0.0, math.nan, no_errors(first, second), height <= 0.0)
    return FlightProgress(state, NOT_BEGUN, NOT_YET)


def fly(
    motions: Sequence[Motion],
    constants_as_records: Sequence[SimulationConstants],
    flight: FlightProgress,
    until: float,
    every: int,
) -> tuple[Vector, Samples, FlightProgress]:
    """Fly on; return times [s] after each motion that ended, samples, and the progress.

    Samples have the estimated velocity, each `every` steps (0: none). The flight starts at rest over home, or
    takes off. It ends at the time `until` [s], or early if a motion's timeout ends.
    """
    constants = constants_as_records[0]  # one: compiled code gets an array of records
    state = flight.state
    steps = flight.steps
    touched = flight.touched
    done = np.zeros(len(motions))
    samples = np.zeros((64, 7))
    taken = 0
    for n in range(len(motions)):
        motion = motions[n]
        if steps == NOT_BEGUN:
            if motion.kind == TAKE_OFF and (state.body.on_ground or state.contact.on_ground):
                lifts = state.time + constants.limits.spool_up
                state = at_rest(state.body.place, lifts, state.yaw.angle, state.errors, True)
            state = begin(state, motion)
            steps = 0
        while state.time < until and not is_over(state, motion):
            if state.reached < 0.0 and state.time - state.begun > motion.timeout:
                break
            state = step(state, motion, constants)
            steps = steps + 1
            if until == math.inf:
                state = past_cruise(state, motion, constants)
            if motion.kind == LAND and not state.contact.on_ground:
                touched = state.time
            if every > 0 and steps % every == 0:
                if taken == len(samples):
                    samples = np.concatenate((samples, np.zeros((taken, 7))))
                place = state.body.place
                speed = state.body.speed
                row = samples[taken]
                row[0], row[1], row[2], row[3] = state.time, place.east, place.north, place.up
                row[4], row[5], row[6] = speed.east, speed.north, speed.up
                taken += 1
        if state.time >= until or not is_over(state, motion):
            return done[:n].copy(), samples[:taken].copy(), FlightProgress(state, steps, touched)
        done[n] = state.reached + motion.hold_s if until == math.inf else state.time
        steps = NOT_BEGUN
    return done, samples[:taken].copy(), FlightProgress(state, steps, touched)
