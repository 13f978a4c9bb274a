"""The gentlest line beside a curve: what a vehicle that must slow down in bends flies faster.

Each place of the curve may move aside, level, by so much; of all such lines the one with the least sum of squared
curvatures is taken, a linear least-squares problem with bounds (in motor racing: the minimum-curvature line).
"""

import math

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.resample import lefts, through

PLACE_SPACING = 3.0  # between the places that move aside [m]
MAX_PLACES = 200  # of them
MAX_ROUNDS, SHARES, ENOUGH = 500, 0.5 ** np.arange(30), 1e-13  # of Newton's method


def relaxed(curve: Spline, room: float, via: Points) -> Points:
    """Places of the line that bends least within `room` [m] beside the curve, (n, 3); it keeps to via points (m, 3)."""
    count = int(np.clip(math.ceil(curve.length / PLACE_SPACING), 8, MAX_PLACES))
    samples, stops = through(curve.sample(count + 1), via)
    free = np.setdiff1d(np.arange(1, len(samples) - 1), stops)
    if room <= 0 or len(free) == 0:
        return samples
    aside = lefts(samples)[:, :2]
    bend = np.diff(np.eye(len(samples)), 2, axis=0)  # second differences: curvature, as the places are evenly far apart
    system = np.vstack([(bend * aside[:, axis])[:, free] for axis in (0, 1)])
    wanted = -np.concatenate([bend @ samples[:, axis] for axis in (0, 1)])
    moved = _least_squares(system, wanted, room)
    samples[free, :2] += moved[:, None] * aside[free]
    return samples


def _least_squares(system: Points, wanted: Vector, room: float) -> Vector:
    """The x (n,), each within `room` of 0, for which `system` x is nearest to `wanted`: Newton's method, projected.

    An element of x touches only such elements of `system` as its two neighbors on each side do (Bertsekas 1982).
    """
    from ipoa_mission.planning.banded import solve_banded

    hessian, toward = system.T @ system, system.T @ wanted
    x, cost = np.zeros(len(toward)), 0.0
    for _ in range(MAX_ROUNDS):
        slope = hessian @ x - toward
        free = np.nonzero(((x > -room) | (slope <= 0)) & ((x < room) | (slope >= 0)))[0]
        band = np.zeros((3, len(free)))
        for k in range(min(3, len(free))):
            band[k, : len(free) - k] = hessian[free[k:], free[: len(free) - k]]
        step = np.zeros_like(x)
        step[free] = solve_banded(band, slope[free])[0]
        for share in SHARES:
            trial = np.clip(x - share * step, -room, room)
            less = float(trial @ (hessian @ trial / 2 - toward))
            if less < cost:
                break
        if less >= cost - ENOUGH * abs(cost):
            break
        x, cost = trial, less
    return x
