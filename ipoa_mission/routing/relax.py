"""Compute the gentlest line near a curve, which a vehicle that slows down in bends flies faster.

Each place of the curve may move laterally, within a limit. The line minimizes the sum of squared curvatures: a linear
least-squares problem with bounds (the minimum-curvature line of motor racing).
"""

import math

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.resample import lefts, through

PLACE_SPACING = 3.0  # [m]
MAX_PLACES = 200
MAX_ROUNDS, SHARES, ENOUGH = 500, 0.5 ** np.arange(30), 1e-13  # of Newton's method


def relaxed(curve: Spline, room: float, via: Points) -> Points:
    """Return places (n, 3) of the line with least bending within `room` [m] of the curve, through via points (m, 3)."""
    count = int(np.clip(math.ceil(curve.length / PLACE_SPACING), 8, MAX_PLACES))
    samples, stops = through(curve.sample(count + 1), via)
    free = np.setdiff1d(np.arange(1, len(samples) - 1), stops)
    if room <= 0 or len(free) == 0:
        return samples
    aside = lefts(samples)[:, :2]
    bend = np.diff(np.eye(len(samples)), 2, axis=0)  # curvature
    system = np.vstack([(bend * aside[:, axis])[:, free] for axis in (0, 1)])
    wanted = -np.concatenate([bend @ samples[:, axis] for axis in (0, 1)])
    moved = _least_squares(system, wanted, room)
    samples[free, :2] += moved[:, None] * aside[free]
    return samples


def _least_squares(system: Points, wanted: Vector, room: float) -> Vector:
    """Solve for x (n,), |x| <= `room`, that minimizes |`system` x - `wanted`|, by projected Newton.

    Normal equations couple each x with two neighbors on either side only (Bertsekas 1982).
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
