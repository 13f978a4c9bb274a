"""Simplify outlines: fewer corners are flown faster and found sooner."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector, union_of

MAX_TURN = math.radians(60.0)


def wider(shape: Any, most: float) -> Any:
    """Return polygons around `shape` with fewer corners, wider by at most `most` [m]."""
    return _redrawn(shape, lambda ring: _pointed(_filled(ring, most), most))


def narrower(shape: Any, most: float) -> Any:
    """Return polygons within `shape` with fewer corners, narrower by at most `most` [m]."""
    return _redrawn(shape, lambda ring: _pointed(_filled(ring[::-1], most), most)[::-1])


def _redrawn(shape: Any, redraw: Callable[[Points], Points]) -> Any:
    """Redraw rings (n, 2), interior on the left; keep a part whose new rings would cross."""
    parts = []
    for part in shapely.get_parts(shapely.orient_polygons(shape)):
        outer, *inner = (redraw(shapely.get_coordinates(ring)[:-1]) for ring in shapely.get_rings(part))
        simple = shapely.Polygon(outer, inner)
        parts.append(simple if simple.is_valid else part)
    return union_of(parts)


def _turns(ring: Points) -> Vector:
    """Return the turns of an open ring (n, 2), left positive [rad]."""
    into, out = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return np.asarray(np.arctan2(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], (into * out).sum(axis=1)))


def _filled(ring: Points, most: float) -> Points:
    """Replace runs of small right turns by a straight edge."""
    turns = _turns(ring)
    if (turns >= 0.0).all():
        return ring
    first = int(turns.argmax())
    ring, turns = np.roll(ring, -first, axis=0), np.roll(turns, -first)
    kept, n, count = [0], 0, len(ring)
    while n < count:
        end, turned = n + 1, 0.0
        while end < count and turns[end] < 0.0 and turned - turns[end] <= MAX_TURN:
            begin, leg = ring[n], ring[(end + 1) % count] - ring[n]
            away = (ring[n + 1 : end + 1] - begin) @ np.array([-leg[1], leg[0]]) / max(math.hypot(*leg), 1e-12)
            if away.max() > most:
                break
            turned -= turns[end]
            end += 1
        kept.append(end)
        n = end
    return np.asarray(ring[kept[:-1]])


def _pointed(ring: Points, most: float) -> Points:
    """Replace runs of small left turns by one corner."""
    turns = _turns(ring)
    first = int(turns.argmax()) if turns.max() > MAX_TURN else int(turns.argmin())
    ring, turns = np.roll(ring, -first, axis=0), np.roll(turns, -first)
    corners, n, count = [ring[0]], 1, len(ring)
    while n < count:
        corner, turned, end = ring[n], turns[n], n + 1
        while end < count and min(turns[end], turns[end - 1]) > 0.0 and turned + turns[end] <= MAX_TURN:
            meets = _crossing(ring[n - 1], ring[n], ring[end], ring[(end + 1) % count])
            if shapely.LineString(ring[n : end + 1]).distance(shapely.Point(meets)) > most:
                break
            corner, turned, end = meets, turned + turns[end], end + 1
        corners.append(corner)
        n = end
    return np.array(corners)


def _crossing(a: Points, b: Points, c: Points, d: Points) -> Points:
    along, other = b - a, d - c
    share = ((c - a)[0] * other[1] - (c - a)[1] * other[0]) / (along[0] * other[1] - along[1] * other[0])
    return np.asarray(a + share * along)
