"""PX4's position controller.

After a climb the hover thrust estimate is too large, as it ignores drag. Anti-windup then reduces the level integrator:
PX4 flies slower.
"""

import math

from ipoa_mission.geometry import GRAVITY
from ipoa_mission.vehicles.px4_multicopter.dynamics.speeds import level
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    TAKE_OFF,
    Axis,
    Body,
    Control,
    Enu,
    Law,
    Order,
    State,
    Trajectory,
)
from ipoa_mission.vehicles.px4_multicopter.limits import Px4Limits

HOVER_SURE, HOVER_SURE_UP = 10.0, 2.0  # of good hover thrust estimates: HTE_VXY_THR, HTE_VZ_THR [m/s]


def controlled(state: State, trajectory: Trajectory, order: Order, law: Law) -> tuple[Enu, Control]:
    """Return the acceleration setpoint: level as lean, upwards as thrust over weight.

    A take-off ramps up the climb limit, without acceleration feed-forward.
    """
    limits, body, was, dt = law.limits, state.body, state.control, law.dt
    east, north = level_velocity(trajectory, body, limits, dt)
    east, north = (
        east - body.speed.east - body.acceleration.east * dt,
        north - body.speed.north - body.acceleration.north * dt,
    )
    ask_east = (
        trajectory.east.acceleration + limits.p_v * east + was.integral.east - limits.d_v * body.acceleration.east
    )
    ask_north = (
        trajectory.north.acceleration + limits.p_v * north + was.integral.north - limits.d_v * body.acceleration.north
    )
    most_climb, foreseen, ramp = limits.most_climb, trajectory.up.acceleration, state.time - state.begun
    if order.kind == TAKE_OFF and ramp < limits.takeoff_ramp:
        none = -GRAVITY / limits.p_vz
        most_climb, foreseen = none + ramp / limits.takeoff_ramp * (most_climb - none), 0.0
    climb = trajectory.up.speed + limits.p_z * (trajectory.up.place - body.place.up)
    up = min(max(climb, -limits.most_descent), most_climb) - body.speed.up
    thrust = max(foreseen + limits.p_vz * up + was.integral.up, -GRAVITY)
    size = math.sqrt(ask_east * ask_east + ask_north * ask_north)
    share = 1.0 if size <= law.most_lean else law.most_lean / size
    # anti-windup: with too little lean or thrust
    back = 2.0 / limits.p_v * max(1.0 - share * (1.0 + thrust / GRAVITY) / was.hover, 0.0)
    integral = Enu(
        was.integral.east + limits.i_v * (east - back * ask_east) * dt,
        was.integral.north + limits.i_v * (north - back * ask_north) * dt,
        was.integral.up + (limits.i_vz * up * dt if up > 0.0 or thrust > -GRAVITY else 0.0),
    )
    return Enu(ask_east * share, ask_north * share, thrust), Control(integral, was.hover, thrust)


def level_velocity(trajectory: Trajectory, body: Body, limits: Px4Limits, dt: float) -> tuple[float, float]:
    x: Axis = trajectory.east
    y: Axis = trajectory.north
    east = x.speed + limits.p_xy * (x.place - body.place.east - body.speed.east * dt)
    north = y.speed + limits.p_xy * (y.place - body.place.north - body.speed.north * dt)
    size = math.sqrt(east * east + north * north)
    share = 1.0 if size <= limits.most_speed else limits.most_speed / size
    return east * share, north * share


def hover_learned(control: Control, body: Body, law: Law, time: float) -> Control:
    """Update the learned hover thrust, which counts drag in a climb as weight."""
    fast = level(body.speed)
    doubt = 1.0 + 10.0 * max(abs(body.speed.up) - HOVER_SURE_UP, fast - HOVER_SURE, 0.0)
    share = (1.0 / law.limits.hover_learning + 1.0 / max(time - body.airborne_since, 1.0)) * law.dt / doubt
    takes = 1.0 + law.airframe.drag * body.speed.up / GRAVITY
    return Control(control.integral, control.hover + (takes - control.hover) * min(share, 1.0), control.thrust)
