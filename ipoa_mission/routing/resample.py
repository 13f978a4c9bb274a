"""Place waypoints on or near a curve."""

import math
from functools import lru_cache

import numpy as np

from ipoa_mission.forecast.timing.cubic import values as cubic_values
from ipoa_mission.geometry import Points, arc_lengths
from ipoa_mission.planning.spline import Spline

SAMPLES = 240  # of corridor waypoints
GREATEST_SPACING = 3.0  # before candidate places follow the bends [m]
CHORD_SHARE = 0.1  # of the tolerance
COMPARING_STEP = 0.5  # [m]
ON_THE_CURVE = (0.0,)
NO_PLACES = np.zeros((0, 3))


def every(curve: Spline, spacing: float, via: Points = NO_PLACES) -> Points:
    """Return waypoints at most `spacing` [m] apart, (k, 3), via points (m, 3) among them."""
    return through(curve.sample(max(2 + len(via), math.ceil(curve.length / spacing) + 1)), via)[0]


def stations(line: Points, spacing: float, last: float, via: Points) -> Points:
    """Return waypoints at most `spacing` [m] apart, with a last leg of `last` [m]."""
    traveled = arc_lengths(line)
    before = traveled[-1] - last
    count = max(1 + len(via), math.ceil(before / spacing))
    stops = np.append(np.linspace(0.0, before, count + 1), traveled[-1])
    return through(cubic_values(traveled, line, stops), via)[0]


def corridor(
    curve: Spline, tolerance: float, asides: tuple[float, ...] = ON_THE_CURVE, via: Points = NO_PLACES
) -> Points:
    """Return the fewest waypoints (k, 3) whose straight legs stay within `tolerance` [m] of the curve.

    They are offset by `asides` [m, to the left]. A shortest path over all pairs (Imai and Iri 1986), with the least sum
    of squared deviations.
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
    """Return places that resolve all bends, (n, 3)."""
    if curve.length > GREATEST_SPACING * most:
        return curve.points(curve.chords(CHORD_SHARE * tolerance))
    return curve.sample(int(np.clip(math.ceil(curve.length / min(1.0, tolerance)) + 1, 20, most)))


def lateral_deviation(path: Points, curve: Spline) -> float:
    """Return the symmetric Hausdorff distance of straight legs and a curve, seen from above [m]."""
    from ipoa_mission.routing._corridor import farthest

    steps, samples = (points * (1.0, 1.0, 0.0) for points in (_steps(path), _dense(curve)))
    spacing = curve.length / (len(samples) - 1)
    away = max(farthest(steps, samples), farthest(samples, steps))
    return math.sqrt(max(away**2 - spacing**2 / 4, 0.0))


def through(samples: Points, via: Points) -> tuple[Points, list[int]]:
    """Move the nearest sample to each via point; return samples and indices."""
    stops: list[int] = []
    for place, left in zip(via, range(len(via), 0, -1), strict=True):
        first = stops[-1] + 1 if stops else 1
        away = np.linalg.norm(samples[first : len(samples) - left] - place, axis=1)
        stops.append(first + int(np.argmin(away)))
    samples[stops] = via
    return samples, stops


def _steps(path: Points) -> Points:
    traveled = arc_lengths(path)
    stops = np.union1d(traveled, np.linspace(0.0, traveled[-1], math.ceil(traveled[-1] / COMPARING_STEP) + 1))
    return np.column_stack([np.interp(stops, traveled, axis) for axis in path.T])


@lru_cache(maxsize=8)
def _dense(curve: Spline) -> Points:
    return curve.sample(int(np.clip(curve.length / COMPARING_STEP, 200, 2000)))


def lefts(samples: Points) -> Points:
    """Return level unit vectors to the left of the path, (n, 3); zero if vertical."""
    ahead = np.gradient(samples[:, :2], axis=0)
    length = np.linalg.norm(ahead, axis=1, keepdims=True)
    level = np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 1e-9)
    return np.column_stack([-level[:, 1], level[:, 0], np.zeros(len(level))])
