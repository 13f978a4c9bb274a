"""Fly PX4's orders from start to end; long cruises are skipped."""

import math
from collections.abc import Sequence

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.vehicles.px4_multicopter.dynamics.body import CORRECTED_FOR, no_errors
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    GO,
    LAND,
    NOT_YET,
    ON_LINE,
    TAKE_OFF,
    Axis,
    Body,
    Enu,
    Order,
    SimulationConstants,
    State,
    Trajectory,
)
from ipoa_mission.vehicles.px4_multicopter.dynamics.step import at_rest, begun, is_over, step

ROOM = 64  # for samples

SETTLED_S = 30.0  # of steady flight before a part of a leg is skipped [s]


def past_cruise(state: State, order: Order, constants: SimulationConstants) -> State:
    """Skip the steady middle of a long level leg; sensor errors stay."""
    x, y, body = state.trajectory.east, state.trajectory.north, state.body
    speed, since = math.sqrt(x.speed * x.speed + y.speed * y.speed), body.airborne_since
    if order.kind != GO or state.guidance.side != ON_LINE or state.time - state.begun < SETTLED_S or speed < 0.1:
        return state
    if order.until < math.inf:
        return state
    east, north = order.goal.east - x.place, order.goal.north - y.place
    far = math.sqrt(east * east + north * north)
    coast = far - speed * SETTLED_S - speed * speed / constants.limits.accel
    if coast < speed * SETTLED_S or order.goal.up != order.start.up or state.time - since < CORRECTED_FOR + SETTLED_S:
        return state
    if x.acceleration * x.acceleration + y.acceleration * y.acceleration > 0.0:
        return state
    east, north, up, time = east * coast / far, north * coast / far, state.trajectory.up, state.time + coast / speed
    trajectory = Trajectory(
        Axis(x.place + east, x.speed, x.acceleration),
        Axis(y.place + north, y.speed, y.acceleration),
        Axis(up.place, up.speed, up.acceleration),
    )
    place = Enu(body.place.east + east, body.place.north + north, body.place.up)
    moved = Body(place, body.speed, body.acceleration, body.asked, body.thrust, body.on_ground, since)
    return State(
        time, moved, state.nose, trajectory, state.guidance, state.control, state.errors, state.contact,
        state.begun, state.reached, state.been_there,
    )  # fmt: skip


def fly(
    orders: Sequence[Order],
    each_constants: Sequence[SimulationConstants],
    height: float,
    seeds: tuple[float, float],
    every: int,
) -> tuple[Vector, Points, float]:
    """Return times [s] at the start and after each order (n + 1,), samples, and the touchdown [s] or NOT_YET.

    Samples (m, 7): time, place, estimated speed, each `every` steps (0: none). The flight starts at rest over home at
    `height` [m], or takes off. It ends at an abort, or early if an order's patience ends.
    """
    constants = each_constants[0]
    state = at_rest(Enu(0.0, 0.0, height), 0.0, math.nan, no_errors(seeds[0], seeds[1]), height <= 0.0)
    done, samples, taken = np.zeros(len(orders) + 1), np.zeros((ROOM, 7)), 1
    samples[0, 3], touched = height, NOT_YET
    for n in range(len(orders)):
        order = orders[n]
        if order.kind == TAKE_OFF and (state.body.on_ground or state.contact.stands):
            state = at_rest(
                state.body.place, state.time + constants.limits.spool_up, state.nose.yaw, state.errors, True
            )
        state, steps = begun(state, order), 0
        while not is_over(state, order):
            if state.reached < 0.0 and state.time - state.begun > order.patience:
                return done[: n + 1].copy(), samples[:taken].copy(), touched
            state, steps = past_cruise(step(state, order, constants), order, constants), steps + 1
            if order.kind == LAND and not state.contact.stands:
                touched = state.time
            if every > 0 and steps % every == 0:
                if taken == len(samples):
                    samples = np.concatenate((samples, np.zeros((taken, 7))))
                at, speed, row = state.body.place, state.body.speed, samples[taken]
                row[0], row[1], row[2], row[3] = state.time, at.east, at.north, at.up
                row[4], row[5], row[6] = speed.east, speed.north, speed.up
                taken += 1
        done[n + 1] = state.reached + order.hold_s if order.until == math.inf else state.time
    return done, samples[:taken].copy(), touched
