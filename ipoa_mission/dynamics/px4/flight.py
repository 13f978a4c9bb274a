"""A whole flight of a PX4 multicopter: order after order; the same lines as plain Python and compiled by numba."""

import math
from collections.abc import Sequence

import numpy as np

from ipoa_mission.dynamics.px4.senses import no_errors
from ipoa_mission.dynamics.px4.state import TAKE_OFF, Enu, Law, Order
from ipoa_mission.dynamics.px4.step import at_rest, begun, is_over, step
from ipoa_mission.geometry import Points, Vector

ROOM = 64  # samples for which there is room to begin with


def fly(
    orders: Sequence[Order], laws: Sequence[Law], height: float, seeds: tuple[float, float], every: int
) -> tuple[Vector, Points]:
    """When each order is done, after the time of the begin (n + 1,) [s]; and a sample every so many steps (0: none).

    A sample is time, place and believed speed: (m, 7).

    It begins over home, at rest, so high; from the ground it takes off after spooling up. It ends early at an order
    that is not reached within its patience: then there are fewer times than orders.
    """
    law = laws[0]
    state = at_rest(Enu(0.0, 0.0, height), 0.0, math.nan, no_errors(seeds[0], seeds[1]))
    done, samples, taken = np.zeros(len(orders) + 1), np.zeros((ROOM, 7)), 1
    samples[0, 3] = height
    for n in range(len(orders)):
        order = orders[n]
        if order.kind == TAKE_OFF and (state.body.on_ground or state.contact.stands):
            there = state.body.place
            place, ready = Enu(there.east, there.north, 0.0), state.time + law.limits.spool_up
            state = at_rest(place, ready, state.nose.yaw, state.errors)
        state, steps = begun(state, order), 0
        while not is_over(state, order):
            if state.reached < 0.0 and state.time - state.begun > order.patience:
                return done[: n + 1].copy(), samples[:taken].copy()
            state, steps = step(state, order, law), steps + 1
            if every > 0 and steps % every == 0:
                if taken == len(samples):
                    samples = np.concatenate((samples, np.zeros((taken, 7))))
                at, speed, row = state.body.place, state.body.speed, samples[taken]
                row[0], row[1], row[2], row[3] = state.time, at.east, at.north, at.up
                row[4], row[5], row[6] = speed.east, speed.north, speed.up
                taken += 1
        done[n + 1] = state.reached + order.holds
    return done, samples[:taken].copy()
