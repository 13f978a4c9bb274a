"""The gentlest line beside a curve: what a vehicle that must slow down in bends flies faster.

Each place of the curve may move aside, level, by so much; of all such lines the one with the least sum of squared
curvatures is taken, a linear least-squares problem with bounds (in motor racing: the minimum-curvature line).
"""

import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import lsq_linear

from ipoa_mission.geometry import Points, leg_lengths
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.resample import lefts, through

PLACE_SPACING = 3.0  # between the places that move aside [m]
MAX_PLACES = 200  # of them


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
    moved = lsq_linear(system, wanted, bounds=(-room, room), tol=1e-6).x
    samples[free, :2] += moved[:, None] * aside[free]
    return samples


def stations(line: Points, spacing: float, last: float, via: Points) -> Points:
    """Waypoints on a line (n, 3), evenly and at most `spacing` [m] apart, but the last leg is `last` [m] long, (k, 3).

    The nearest to each via point (m, 3) stand on it.
    """
    traveled = np.concatenate([[0.0], np.cumsum(leg_lengths(line))])
    before = traveled[-1] - last
    count = max(1 + len(via), math.ceil(before / spacing))
    stops = np.append(np.linspace(0.0, before, count + 1), traveled[-1])
    return through(np.asarray(CubicSpline(traveled, line)(stops)), via)[0]
