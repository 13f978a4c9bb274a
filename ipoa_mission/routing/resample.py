"""Where on (or beside) a curve its waypoints lie: pure geometry, in metres.

The vehicle flies straight legs between waypoints. `every` takes equal steps, as the paper's reader would expect;
`corridor` takes the fewest waypoints whose legs stay near the curve. Both have one at every via point.
"""

import math
from functools import lru_cache

import numpy as np

from ipoa_mission.forecast.timing import cubic
from ipoa_mission.geometry import Points, arc_lengths
from ipoa_mission.planning.spline import Spline

SAMPLES = 240  # spots on or beside the curve where a corridor may have a waypoint
SPARSE = 3.0  # where these would be farther apart they are as near as the curve bends [m]
CHORD_SHARE = 0.1  # of the tolerance, by which it may then leave the straight lines between them
COMPARING_STEP = 0.5  # at which a path is held against a curve [m]
ON_THE_CURVE = (0.0,)
NOWHERE = np.zeros((0, 3))


def every(curve: Spline, spacing: float, via: Points = NOWHERE) -> Points:
    """Waypoints along the curve, equally far apart and at most `spacing` [m] of arc, (k, 3): the paper's resampling.

    The nearest to each via point (m, 3) stand on it.
    """
    return through(curve.sample(max(2 + len(via), math.ceil(curve.length / spacing) + 1)), via)[0]


def stations(line: Points, spacing: float, last: float, via: Points) -> Points:
    """Waypoints on a line (n, 3), evenly and at most `spacing` [m] apart, but the last leg is `last` [m] long, (k, 3).

    The nearest to each via point (m, 3) stand on it.
    """
    traveled = arc_lengths(line)
    before = traveled[-1] - last
    count = max(1 + len(via), math.ceil(before / spacing))
    stops = np.append(np.linspace(0.0, before, count + 1), traveled[-1])
    return through(cubic.values(traveled, line, stops), via)[0]


def corridor(
    curve: Spline, tolerance: float, asides: tuple[float, ...] = ON_THE_CURVE, via: Points = NOWHERE
) -> Points:
    """The fewest waypoints whose straight legs stay within `tolerance` [m] of the curve, (k, 3), via points among them.

    Other inner waypoints lie beside the curve by one of `asides` [m, to the left]: outside a bend they save more. A
    shortest path over all pairs that a straight leg may join (Imai and Iri 1986); among routes of equal number the one
    with the least sum of squared deviations is taken.
    """
    from ipoa_mission.routing._corridor import fewest_legs

    samples, stops = through(_spots(curve, tolerance, SAMPLES // len(asides)), via)
    spots = samples[:, None, :] + np.asarray(asides)[:, None] * lefts(samples)[:, None, :]  # (n, sides, 3)
    spots[[0, *stops, -1]] = samples[[0, *stops, -1], None, :]
    n = len(samples)
    last = np.array([next((stop for stop in stops if stop > i), n - 1) for i in range(n)])
    before = fewest_legs(samples, spots, last, tolerance)
    chosen = [(n - 1, 0)]
    while chosen[-1][0] > 0:
        chosen.append(tuple(before[chosen[-1]].tolist()))
    return np.array([spots[spot] for spot in reversed(chosen)])


def _spots(curve: Spline, tolerance: float, most: int) -> Points:
    """Places of the curve that show all its bends, (n, 3): evenly apart, if so many are enough for that."""
    if curve.length > SPARSE * most:
        return curve.points(curve.chords(CHORD_SHARE * tolerance))
    return curve.sample(int(np.clip(math.ceil(curve.length / min(1.0, tolerance)) + 1, 20, most)))


def deviation(path: Points, curve: Spline) -> float:
    """How far a path of straight legs (n, 3) and a curve are apart [m], to a few centimetres.

    The greatest distance of either from the other (Hausdorff): a path that leaves a loop out is as far as the loop is
    wide.
    """
    from ipoa_mission.routing._hausdorff import farthest

    steps, samples = _steps(path), _fine(curve)
    spacing = curve.length / (len(samples) - 1)
    away = max(farthest(steps, samples), farthest(samples, steps))
    return math.sqrt(max(away**2 - spacing**2 / 4, 0.0))


def through(samples: Points, via: Points) -> tuple[Points, list[int]]:
    """The samples of a curve with the nearest to each via point, in their order, put on it; and which these are."""
    stops: list[int] = []
    for place, left in zip(via, range(len(via), 0, -1), strict=True):
        first = stops[-1] + 1 if stops else 1
        away = np.linalg.norm(samples[first : len(samples) - left] - place, axis=1)
        stops.append(first + int(np.argmin(away)))
    samples[stops] = via
    return samples, stops


def _steps(path: Points) -> Points:
    """The corners of a path and points between them, half a metre apart at most."""
    traveled = arc_lengths(path)
    stops = np.union1d(traveled, np.linspace(0.0, traveled[-1], math.ceil(traveled[-1] / COMPARING_STEP) + 1))
    return np.column_stack([np.interp(stops, traveled, axis) for axis in path.T])


@lru_cache(maxsize=8)
def _fine(curve: Spline) -> Points:
    """Samples of a curve half a metre apart."""
    return curve.sample(int(np.clip(curve.length / COMPARING_STEP, 200, 2000)))


def lefts(samples: Points) -> Points:
    """Level unit vectors to the left of the way at each sample, (n, 3); zero where the way is vertical."""
    ahead = np.gradient(samples[:, :2], axis=0)
    length = np.linalg.norm(ahead, axis=1, keepdims=True)
    level = np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 1e-9)
    return np.column_stack([-level[:, 1], level[:, 0], np.zeros(len(level))])
