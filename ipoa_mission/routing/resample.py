"""Where on (or beside) a curve its waypoints lie: pure geometry, in metres.

The vehicle flies straight legs between waypoints. `every` takes equal steps, as the paper's reader would expect;
`corridor` takes the fewest waypoints whose legs stay near the curve. Both have one at every via point.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, leg_lengths
from ipoa_mission.planning.spline import Spline

SAMPLES = 240  # spots on or beside the curve where a corridor may have a waypoint
COMPARING_STEP = 0.5  # at which a path is held against a curve [m]
FIRST_LOOK = 16  # a leg may be looked for over so many samples at first
ON_THE_CURVE = (0.0,)
NOWHERE = np.zeros((0, 3))


def every(curve: Spline, spacing: float, via: Points = NOWHERE) -> Points:
    """Waypoints along the curve, equally far apart and at most `spacing` [m] of arc, (k, 3): the paper's resampling.

    The nearest to each via point (m, 3) stand on it.
    """
    return through(curve.sample(max(2 + len(via), math.ceil(curve.length / spacing) + 1)), via)[0]


def corridor(
    curve: Spline, tolerance: float, asides: tuple[float, ...] = ON_THE_CURVE, via: Points = NOWHERE
) -> Points:
    """The fewest waypoints whose straight legs stay within `tolerance` [m] of the curve, (k, 3), via points among them.

    Other inner waypoints lie beside the curve by one of `asides` [m, to the left]: outside a bend they save more. A
    shortest path over all pairs that a straight leg may join (Imai and Iri 1986); among routes of equal number the one
    with the least sum of squared deviations is taken.
    """
    count = np.clip(math.ceil(curve.length / min(1.0, tolerance)) + 1, 20, SAMPLES // len(asides))
    samples, stops = through(curve.sample(int(count)), via)
    spots = samples[:, None, :] + np.asarray(asides)[:, None] * lefts(samples)[:, None, :]  # (n, sides, 3)
    spots[[0, *stops, -1]] = samples[[0, *stops, -1], None, :]
    n, sides = spots.shape[:2]
    legs, strain = np.full((n, sides), n + 1), np.full((n, sides), np.inf)
    before = np.zeros((n, sides, 2), int)
    legs[0], strain[0] = 0, 0.0
    for i in range(n - 1):
        starts = spots[i] if i else spots[0, :1]
        reachable = _reachable(starts, samples[i:], spots[i:], tolerance)
        last = min(i + reachable.shape[1], next((stop for stop in stops if stop > i), n))
        ends = slice(i + 1, last + 1)
        for side, deviation in enumerate(reachable[:, : last - i]):
            more, worn = legs[i, side] + 1, strain[i, side] + deviation**2
            fewer = (more < legs[ends]) | ((more == legs[ends]) & (worn < strain[ends]))
            better = (deviation <= tolerance) & fewer
            legs[ends][better], strain[ends][better], before[ends][better] = more, worn[better], (i, side)
    chosen = [(n - 1, 0)]
    while chosen[-1][0] > 0:
        chosen.append(tuple(before[chosen[-1]]))
    return np.array([spots[spot] for spot in reversed(chosen)])


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
    traveled = np.concatenate([[0.0], np.cumsum(leg_lengths(path))])
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


def _reachable(starts: Points, samples: Points, spots: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """How far the samples in between leave the straight legs from `starts` to each later spot, (starts, m, sides) [m].

    The search widens, half as far again each time, until no leg of the last two widenings fits: a curve that comes
    back later is not looked for.
    """
    reachable: list[NDArray[np.float64]] = []
    first, end = 1, 1 + FIRST_LOOK
    while True:
        reachable.append(_deviations(starts, samples[1:end], spots[first:end]))
        if end >= len(samples) or (len(reachable) > 1 and all((away > tolerance).all() for away in reachable[-2:])):
            return np.concatenate(reachable, axis=1)
        first, end = end, end + end // 2


def _deviations(starts: Points, samples: Points, spots: NDArray[np.float64]) -> NDArray[np.float64]:
    """The greatest distance of samples (n, 3) from the legs to spots (m, sides, 3), (starts, m, sides) [m].

    The spots belong to the last m samples; for each only the samples up to its own count.
    """
    m, sides = spots.shape[:2]
    spokes, offsets = spots[None] - starts[:, None, None], samples - starts[:, None]
    spokes = spokes.reshape(len(starts), m * sides, 3)
    squares = np.maximum((spokes**2).sum(axis=2), 1e-12)[:, None]
    ahead = offsets @ spokes.transpose(0, 2, 1)  # (starts, samples, spots): what the squared distance is made of
    along = np.minimum(np.maximum(ahead / squares, 0.0), 1.0)
    apart = (offsets**2).sum(axis=2)[..., None] + along * (along * squares - 2 * ahead)
    own = np.tri(m, len(samples), len(samples) - m, dtype=bool).T[:, :, None]
    apart = np.where(own, apart.reshape(len(starts), len(samples), m, sides), 0.0).max(axis=1)
    return np.asarray(np.sqrt(np.maximum(apart, 0.0)))
