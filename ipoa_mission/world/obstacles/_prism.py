"""Compiled distance of a leg to an extruded polygon: roots of polynomials."""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit
from ipoa_mission.world._polygon import balance, from_edge, offset

TRIED_PER_EDGE = 8
TOUCHING = 1e-6  # below, a leg may be inside [m]


@njit(inline="always")
def _distance(prism, place, least):
    """Return the distance; one above `least` may be wrong."""
    starts, ends, base, top = prism
    x, y, z = place
    above = max(base - z, z - top)
    nearest = math.inf
    inside = False
    shallow = least * least * (1.0 - 1e-9) if least < 0.0 else 0.0
    for k in range(len(starts) if above <= least else 0):
        east, north, crosses = from_edge(starts[k], ends[k], x, y)
        nearest = min(nearest, east * east + north * north)
        if nearest < shallow:
            break
        inside = inside != crosses
    aside = -math.sqrt(nearest) if inside else math.sqrt(nearest)
    return math.hypot(max(aside, 0.0), max(above, 0.0)) + min(max(aside, above), 0.0)


@njit(inline="always")
def _least(prism, leg, tried, known):
    """Return the least distance at parameters (n,) of a leg, and its parameter."""
    a, step = leg
    least = math.inf
    where = 0.0
    for k in range(len(tried)):
        t = tried[k]
        if k < 2 or 0.0 < t < 1.0:
            place = a[0] + t * step[0], a[1] + t * step[1], a[2] + t * step[2]
            distance = _distance(prism, place, min(least, known))
            if distance < least:
                least, where = distance, t
    return least, where


@njit(inline="always")
def _feet(starts, ends, a, step, tried):
    """Add parameters nearest to a corner, across an edge, or abreast of its ends."""
    square = step[0] ** 2 + step[1] ** 2
    count = 0
    for k in range(len(starts)):
        away_e, away_n = offset(a, starts[k])
        along_e, along_n = offset(starts[k], ends[k])
        across = step[0] * along_n - step[1] * along_e
        slope = along_e * step[0] + along_n * step[1]
        if square > 0.0:
            tried[count] = (away_e * step[0] + away_n * step[1]) / square
            count += 1
        if across != 0.0:
            tried[count] = (away_e * along_n - away_n * along_e) / across
            count += 1
        if slope != 0.0:
            tried[count] = (away_e * along_e + away_n * along_n) / slope
            tried[count + 1] = tried[count] + (along_e * along_e + along_n * along_n) / slope
            count += 2
    return count


@njit(inline="always")
def _rims(starts, ends, a, step, tried):
    """Add parameters nearest to a rim; a[2]: height above it."""
    square = step[0] ** 2 + step[1] ** 2 + step[2] ** 2
    count = 0
    for k in range(len(starts)):
        away_e, away_n = offset(a, starts[k])
        along_e, along_n = offset(starts[k], ends[k])
        ahead = away_e * step[0] + away_n * step[1] - a[2] * step[2]
        mixed = along_e * step[0] + along_n * step[1]
        edge = along_e * along_e + along_n * along_n
        determinant = square * edge - mixed * mixed
        if square > 0.0:
            tried[count] = ahead / square
            count += 1
        if determinant > 0.0:
            tried[count] = (ahead * edge - (away_e * along_e + away_n * along_n) * mixed) / determinant
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def nearest(starts, ends, base, top, a, b):
    """Return the least distance [m] of the leg a-b to a prism with edges (m, 2), and its fraction."""
    prism = (starts, ends, base, top)
    step = b - a
    tried = np.zeros(TRIED_PER_EDGE * len(starts) + 5)
    tried[1] = 1.0
    count = 2 + _feet(starts, ends, a, step, tried[2:])
    if step[2] != 0.0:
        for height in (base, top, 0.5 * (base + top)):
            tried[count] = (height - a[2]) / step[2]
            count += 1
    caps = np.empty((2, 3))
    for k in range(2):
        height = a[2] - (top if k else base)
        count += _rims(starts, ends, (a[0], a[1], height), step, tried[count:])
        caps[k, 0] = height * height
        caps[k, 1] = 2.0 * height * step[2]
        caps[k, 2] = step[2] * step[2]
    least, where = _least(prism, (a, step), tried[:count], math.inf)
    if least <= TOUCHING:
        inner = balance(starts, ends, caps, a[:2], b[:2], True)
        deepest, there = _least(prism, (a, step), inner, least)
        if deepest < least or (deepest == least and there < where):
            return deepest, there
    return least, where
