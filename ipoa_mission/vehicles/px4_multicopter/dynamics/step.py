import math

from ipoa_mission.vehicles.px4_multicopter.dynamics.body import integrate
from ipoa_mission.vehicles.px4_multicopter.dynamics.control import controlled, hover_learned
from ipoa_mission.vehicles.px4_multicopter.dynamics.guidance import (
    climb_limits,
    guided,
    is_low_take_off,
    velocity_setpoint,
)
from ipoa_mission.vehicles.px4_multicopter.dynamics.heading import heading_error, turned
from ipoa_mission.vehicles.px4_multicopter.dynamics.landing import detect_contact, stands
from ipoa_mission.vehicles.px4_multicopter.dynamics.sensor_errors import NOTICED_S, add_sensor_errors
from ipoa_mission.vehicles.px4_multicopter.dynamics.smoothing import smoothed
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    LAND,
    NOT_YET,
    ON_LINE,
    TAKE_OFF,
    UNKNOWN,
    ZERO,
    Axis,
    Body,
    Contact,
    Control,
    Enu,
    Errors,
    Guidance,
    Law,
    Level,
    Order,
    State,
    Trajectory,
    Yaw,
    of,
)
from ipoa_mission.vehicles.px4_multicopter.limits import STAGES

STANDING = 1e-6  # a slower trajectory waits for the vehicle [m/s]
SPLIT = 2.0**29 + 1.0  # Veltkamp's, to single precision
GROUND_SINK = 0.7  # [m/s]


def step(state: State, order: Order, law: Law) -> State:
    limits, standing = law.limits, stands(state, order)
    velocity, guidance = velocity_setpoint(state, order, law, guided(state, order, limits))
    trajectory = track_setpoint(state, order, law, velocity)
    asked, control = controlled(state, trajectory, order, law)
    if not (standing or state.body.on_ground):
        control = hover_learned(control, state.body, law, state.time)
    body = integrate(state, asked, law, standing)
    errors = add_sensor_errors(state, law)
    if errors.told != state.errors.told:
        guidance = Guidance(UNKNOWN, guidance.anchor, guidance.held, guidance.rising)
    contact = detect_contact(state, body, asked.up, law) if order.kind == LAND else state.contact
    time = state.time + law.dt
    there = state.been_there or is_there(body, errors, contact, order)
    reached = state.reached
    if there and reached < 0.0 and (math.isnan(order.heading) or abs(heading_error(state, order)) <= limits.yaw_error):
        reached = time
    nose = turned(state, order, limits, law.dt) if law.turns else state.nose
    return State(time, body, nose, trajectory, guidance, control, errors, contact, state.begun, reached, there)


def track_setpoint(state: State, order: Order, law: Law, velocity: Enu) -> Trajectory:
    """Return the trajectory a step later, stretched while the vehicle lags."""
    limits, at, was = law.limits, state.body.place, state.trajectory
    low = is_low_take_off(state, order, limits)
    climb = climb_limits(state.guidance.rising, low, limits)
    if low:
        was = Trajectory(was.east, was.north, Axis(at.up, was.up.speed, was.up.acceleration))
    most = limits.most_speed
    within = Enu(
        min(max(velocity.east, -most), most),
        min(max(velocity.north, -most), most),
        min(max(velocity.up, -climb.rate), climb.rate),
    )
    east, north, behind = was.east.place - at.east, was.north.place - at.north, 0.0
    standing = math.sqrt(was.east.speed * was.east.speed + was.north.speed * was.north.speed) < STANDING
    if standing or east * was.east.speed + north * was.north.speed >= 0.0:
        behind = math.sqrt(east * east + north * north)
    pace = pace_up = 1.0 - min(behind / limits.most_error, 1.0)
    if limits.splits_axes:
        pace_up, lead = 1.0, was.up.place - at.up
        if limits.most_height_error > 0.0 and lead * was.up.speed >= 0.0:
            pace_up = 1.0 - min(abs(lead) / limits.most_height_error, 1.0)
    now = smoothed(was, within, limits, climb.accel, law.dt * pace, law.dt * pace_up)
    if order.kind != LAND:
        return now
    return Trajectory(in_single(now.east), in_single(now.north), now.up)


def in_single(axis: Axis) -> Axis:
    """Round places as PX4 does: lost steps leave a speed that delays a landing."""
    wide = SPLIT * axis.place
    return Axis(wide - (wide - axis.place), axis.speed, axis.acceleration)


def is_there(body: Body, errors: Errors, contact: Contact, order: Order) -> bool:
    """The navigator knows home's corrections at once."""
    if order.kind == LAND:
        return contact.stages >= STAGES
    home = errors.home if order.follows_home else 0.0
    if order.kind == TAKE_OFF:
        return body.place.up > order.goal.up + home - order.height_radius
    east, north = body.place.east - order.goal.east, body.place.north - order.goal.north
    near = east * east + north * north <= order.radius * order.radius
    return near and abs(body.place.up - home - order.goal.up) <= order.height_radius


def is_over(state: State, order: Order) -> bool:
    """Return whether it is done, as guidance knows, or aborted."""
    if state.time >= order.until:
        return True
    return state.reached >= 0.0 and state.time - state.reached >= max(order.holds, NOTICED_S)


def at_rest(place: Enu, time: float, yaw: float, errors: Errors, on_ground: bool) -> State:
    body = Body(place, ZERO, Level(0.0, 0.0), Level(0.0, 0.0), ZERO, on_ground, time)
    trajectory = Trajectory(Axis(place.east, 0.0, 0.0), Axis(place.north, 0.0, 0.0), Axis(place.up, 0.0, 0.0))
    return State(
        time, body, Yaw(yaw, 0.0), trajectory, Guidance(ON_LINE, place, 0.0, True), Control(ZERO, 1.0, 0.0), errors,
        Contact(False, False, 0, time), time, NOT_YET, False,
    )  # fmt: skip


def begun(state: State, order: Order) -> State:
    trajectory, body = state.trajectory, state.body
    on_ground = body.on_ground and order.kind == TAKE_OFF
    if on_ground:
        trajectory = Trajectory(trajectory.east, trajectory.north, Axis(trajectory.up.place, -GROUND_SINK, 0.0))
    body = Body(body.place, body.speed, body.acceleration, body.asked, body.thrust, on_ground, body.airborne_since)
    guidance = Guidance(ON_LINE, of(order.start), state.guidance.held, state.guidance.rising)
    return State(
        state.time, body, state.nose, trajectory, guidance, state.control, state.errors,
        Contact(False, False, 0, state.time), state.time, NOT_YET, False,
    )  # fmt: skip
