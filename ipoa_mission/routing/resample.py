"""Place waypoints on or near a curve."""

import math
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.forecast.timing.cubic import values as cubic_values
from ipoa_mission.forecast.timing.track import thinned
from ipoa_mission.geometry import Points, Vector, arc_lengths
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
) -> tuple[Points, Vector]:
    """Return the fewest waypoints (k, 3) with legs within `tolerance` [m] of the curve, and their stations (k,).

    They are offset by `asides` [m, to the left]. A shortest path over all pairs (Imai and Iri 1986), with the least sum
    of squared deviations.
    """
    from ipoa_mission.routing._corridor import fewest_legs

    samples = _spots(curve, tolerance, SAMPLES // len(asides))
    traveled = arc_lengths(samples)
    samples, stops = through(samples, via)
    spots = samples[:, None, :] + np.asarray(asides)[:, None] * lefts(samples)[:, None, :]  # (n, sides, 3)
    spots[[0, *stops, -1]] = samples[[0, *stops, -1], None, :]
    n = len(samples)
    last = np.array([next((stop for stop in stops if stop > i), n - 1) for i in range(n)])
    before = fewest_legs(samples, spots, last, tolerance)
    chosen = [(n - 1, 0)]
    while chosen[-1][0] > 0:
        chosen.append(tuple(before[chosen[-1]].tolist()))
    chosen.reverse()
    return np.array([spots[spot] for spot in chosen]), traveled[[n for n, _ in chosen]]


def _spots(curve: Spline, tolerance: float, most: int) -> Points:
    """Return places that resolve all bends, (n, 3)."""
    if curve.length > GREATEST_SPACING * most:
        return curve.points(curve.chords(CHORD_SHARE * tolerance))
    return curve.sample(int(np.clip(math.ceil(curve.length / min(1.0, tolerance)) + 1, 20, most)))


def strays(path: Points, curve: Spline, most: float) -> bool:
    """Return whether path (n, 3) and curve are anywhere farther than `most` [m] apart, seen from above."""
    steps = shapely.get_coordinates(shapely.segmentize(shapely.LineString(path[:, :2]), COMPARING_STEP))
    samples, line = curve_samples(curve)
    return bool(is_far(steps, line, most).any() or is_far(samples, path, most).any())


def is_far(points: Points, line: Points, most: float) -> NDArray[np.bool_]:
    """Return which points (n, 2 or 3) are farther than `most` [m] from a line (k, 2 or 3), seen from above."""
    legs = shapely.linestrings(np.stack([line[:-1, :2], line[1:, :2]], axis=1))
    far = np.ones(len(points), dtype=bool)
    far[shapely.STRtree(legs).query(shapely.points(points[:, :2]), "dwithin", most)[0]] = False
    return far


def through(samples: Points, via: Points) -> tuple[Points, list[int]]:
    """Move the nearest sample to each via point; return samples and indices."""
    stops: list[int] = []
    for place, left in zip(via, range(len(via), 0, -1), strict=True):
        first = stops[-1] + 1 if stops else 1
        away = np.linalg.norm(samples[first : len(samples) - left] - place, axis=1)
        stops.append(first + int(np.argmin(away)))
    samples[stops] = via
    return samples, stops


@lru_cache(maxsize=8)
def curve_samples(curve: Spline) -> tuple[Points, Points]:
    """Return places on a curve (n, 3), and a thinner line along it."""
    samples = curve.sample(2 + int(curve.length / COMPARING_STEP))
    return samples, thinned(samples)


def lefts(samples: Points) -> Points:
    """Return level unit vectors to the left of the path, (n, 3); zero if vertical."""
    ahead = np.gradient(samples[:, :2], axis=0)
    length = np.linalg.norm(ahead, axis=1, keepdims=True)
    level = np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 1e-9)
    return np.column_stack([-level[:, 1], level[:, 0], np.zeros(len(level))])
