"""Fly PX4's orders from start to end; long cruises are skipped."""

import math
from collections.abc import Sequence

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.vehicles.px4_multicopter.dynamics.body import CORRECTED_FOR, no_errors
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import (
    GO,
    LAND,
    NOT_BEGUN,
    NOT_YET,
    ON_LINE,
    TAKE_OFF,
    Axis,
    Body,
    Enu,
    Order,
    Progress,
    SimulationConstants,
    State,
    Trajectory,
)
from ipoa_mission.vehicles.px4_multicopter.dynamics.step import at_rest, begun, is_over, step

SETTLED_S = 30.0  # of steady flight before a part of a leg is skipped [s]


def past_cruise(state: State, order: Order, constants: SimulationConstants) -> State:
    """Skip the steady middle of a long level leg; sensor errors stay."""
    x, y, body = state.trajectory.east, state.trajectory.north, state.body
    speed, since = math.sqrt(x.speed * x.speed + y.speed * y.speed), body.airborne_since
    if order.kind != GO or state.guidance.side != ON_LINE or state.time - state.begun < SETTLED_S or speed < 0.1:
        return state
    east, north = order.goal.east - x.place, order.goal.north - y.place
    far = math.sqrt(east * east + north * north)
    coast = far - speed * SETTLED_S - speed * speed / constants.limits.accel
    if coast < speed * SETTLED_S or order.goal.up != order.start.up or state.time - since < CORRECTED_FOR + SETTLED_S:
        return state
    if x.acceleration * x.acceleration + y.acceleration * y.acceleration > 0.0:
        return state
    east, north, time = east * coast / far, north * coast / far, state.time + coast / speed
    x = Axis(x.place + east, x.speed, x.acceleration)
    y = Axis(y.place + north, y.speed, y.acceleration)
    trajectory = Trajectory(x, y, state.trajectory.up)
    place = Enu(body.place.east + east, body.place.north + north, body.place.up)
    moved = Body(place, body.speed, body.acceleration, body.asked, body.thrust, body.on_ground, since)
    return State(
        time, moved, state.nose, trajectory, state.guidance, state.control, state.errors, state.contact,
        state.begun, state.reached, state.been_there,
    )  # fmt: skip


def at_start(height: float, seed: int) -> Progress:
    first, second = (float(1 + x % 2_000_000_000) for x in np.random.SeedSequence(seed).generate_state(2))
    state = at_rest(Enu(0.0, 0.0, height), 0.0, math.nan, no_errors(first, second), height <= 0.0)
    return Progress(state, NOT_BEGUN, NOT_YET)


def fly(
    orders: Sequence[Order], each_constants: Sequence[SimulationConstants], flight: Progress, until: float, every: int
) -> tuple[Vector, Points, Progress]:
    """Fly on; return times [s] after each order that ended, samples, and the progress.

    Samples (m, 7): time, place, estimated speed, each `every` steps (0: none). The flight starts at rest over home, or
    takes off. It ends at the time `until` [s], or early if an order's patience ends.
    """
    constants, state = each_constants[0], flight.state
    steps, touched = flight.steps, flight.touched
    done, samples, taken = np.zeros(len(orders)), np.zeros((64, 7)), 0
    for n in range(len(orders)):
        order = orders[n]
        if steps == NOT_BEGUN:
            if order.kind == TAKE_OFF and (state.body.on_ground or state.contact.stands):
                lifts = state.time + constants.limits.spool_up
                state = at_rest(state.body.place, lifts, state.nose.yaw, state.errors, True)
            state, steps = begun(state, order), 0
        while state.time < until and not is_over(state, order):
            if state.reached < 0.0 and state.time - state.begun > order.patience:
                break
            state, steps = step(state, order, constants), steps + 1
            if until == math.inf:
                state = past_cruise(state, order, constants)
            if order.kind == LAND and not state.contact.stands:
                touched = state.time
            if every > 0 and steps % every == 0:
                if taken == len(samples):
                    samples = np.concatenate((samples, np.zeros((taken, 7))))
                at, speed, row = state.body.place, state.body.speed, samples[taken]
                row[0], row[1], row[2], row[3] = state.time, at.east, at.north, at.up
                row[4], row[5], row[6] = speed.east, speed.north, speed.up
                taken += 1
        if state.time >= until or not is_over(state, order):
            return done[:n].copy(), samples[:taken].copy(), Progress(state, steps, touched)
        done[n] = state.reached + order.hold_s if until == math.inf else state.time
        steps = NOT_BEGUN
    return done, samples[:taken].copy(), Progress(state, steps, touched)
