"""A whole flight of a PX4 multicopter: order after order; the same lines as plain Python and compiled by numba."""

import math
from collections.abc import Sequence

from ipoa_mission.dynamics.px4.senses import no_errors
from ipoa_mission.dynamics.px4.state import TAKE_OFF, Enu, Law, Order
from ipoa_mission.dynamics.px4.step import at_rest, begun, is_over, step


def fly(
    orders: Sequence[Order], laws: Sequence[Law], height: float, seeds: tuple[float, float], every: int
) -> tuple[list[float], list[float]]:
    """When each order is done, after the time of the begin; and a sample every so many steps (0: none), all in a row.

    A sample is seven numbers: time, place and believed speed.

    It begins over home, at rest, so high; from the ground it takes off after spooling up. It ends early at an order
    that is not reached within its patience: then there are fewer times than orders.
    """
    law = laws[0]
    state = at_rest(Enu(0.0, 0.0, height), 0.0, math.nan, no_errors(seeds[0], seeds[1]), height <= 0.0)
    done, samples = [0.0], [0.0, 0.0, 0.0, height, 0.0, 0.0, 0.0]
    for n in range(len(orders)):
        order = orders[n]
        if order.kind == TAKE_OFF and (state.body.on_ground or state.contact.stands):
            state = at_rest(state.body.place, state.time + law.limits.spool_up, state.nose.yaw, state.errors, True)
        state, steps = begun(state, order), 0
        while not is_over(state, order):
            if state.reached < 0.0 and state.time - state.begun > order.patience:
                return done, samples
            state, steps = step(state, order, law), steps + 1
            if every > 0 and steps % every == 0:
                at, speed = state.body.place, state.body.speed
                for value in (state.time, at.east, at.north, at.up, speed.east, speed.north, speed.up):
                    samples.append(value)
        done.append(state.reached + order.holds)
    return done, samples
