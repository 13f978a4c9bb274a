"""Compiled distances to a polygon, and parameters of a leg that may be farthest from its outline."""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit

MAX_SOLVED_EDGES, MIN_SPAN, MAX_WAITING = 6, 1e-8, 128  # edges; length of a span [m]; halvings


@njit(inline="always")
def offset(start, end):
    """Return the way between two places, east and north."""
    return end[0] - start[0], end[1] - start[1]


@njit(inline="always")
def from_edge(start, end, x, y):
    """Return the offset from an edge, and whether it crosses the ray to the east."""
    along_e, along_n = offset(start, end)
    away_e, away_n = offset(start, (x, y))
    share = (away_e * along_e + away_n * along_n) / (along_e * along_e + along_n * along_n)
    share = min(max(share, 0.0), 1.0)
    crosses = (start[1] > y) != (end[1] > y) and x < start[0] + away_n / along_n * along_e
    return away_e - share * along_e, away_n - share * along_n, crosses


@njit(cache=True, error_model="numpy")
def distances(starts, ends, points):
    """Return signed distances (n,) [m] of points (n, 2) to a polygon with edges (m, 2): negative inside."""
    signed = np.empty(len(points))
    for n in range(len(points)):
        nearest = math.inf
        inside = False
        for k in range(len(starts)):
            east, north, crosses = from_edge(starts[k], ends[k], points[n, 0], points[n, 1])
            square = east * east + north * north
            if not square >= nearest:  # NaN stays NaN
                nearest = square
            inside = inside != crosses
        signed[n] = -math.sqrt(nearest) if inside else math.sqrt(nearest)
    return signed


@njit(inline="always")
def _distances(starts, ends, x, y, away):
    """Write the distances to all edges to `away` (m,); return the least, and whether the place is inside."""
    least = math.inf
    inside = False
    for k in range(len(starts)):
        east, north, crosses = from_edge(starts[k], ends[k], x, y)
        away[k] = math.hypot(east, north)
        least = min(least, away[k])
        inside = inside != crosses
    return least, inside


@njit(inline="always")
def _squares(starts, ends, a, step, squares):
    """Write squared distances to edges and corners, coefficients of 1, t, t^2; return their number."""
    count = 0
    square = step[0] * step[0] + step[1] * step[1]
    for k in range(len(starts)):
        along_e, along_n = offset(starts[k], ends[k])
        from_e, from_n = offset(starts[k], a)
        length = math.hypot(along_e, along_n)
        aside = (from_n * along_e - from_e * along_n) / length
        drift = (step[1] * along_e - step[0] * along_n) / length
        squares[count, 0] = aside * aside
        squares[count, 1] = 2.0 * aside * drift
        squares[count, 2] = drift * drift
        for corner in range(2):
            east = from_e - corner * along_e
            north = from_n - corner * along_n
            row = squares[count + 1 + corner]
            row[0] = east * east + north * north
            row[1] = 2.0 * (east * step[0] + north * step[1])
            row[2] = square
        count += 3
    return count


@njit(cache=True, error_model="numpy")
def balance(starts, ends, walls, a, b, inside):
    """Return the parameters (n,) of the leg a-b, inside or outside, that may be farthest from edges (m, 2) and walls.

    There two squared distances are equal: to corners, edges, or walls with coefficients (k, 3) of 1, t, t^2. Long
    spans are halved until few edges are near.
    """
    step = b - a
    length = math.hypot(step[0], step[1])
    away = np.empty(len(starts))
    greatest = 0.0
    squares = np.empty((3 * MAX_SOLVED_EDGES + len(walls), 3))
    waiting = np.empty((MAX_WAITING, 2))
    waiting[0, 0] = 0.0
    waiting[0, 1] = 1.0
    spans = 1
    found = np.empty(64)
    found[0] = 0.0
    found[1] = 1.0
    count = 2
    while spans > 0:
        spans -= 1
        low, high = waiting[spans]
        middle = (low + high) / 2.0
        reach = (high - low) * length
        nearest, contained = _distances(starts, ends, a[0] + middle * step[0], a[1] + middle * step[1], away)
        wanted = contained == inside
        here = nearest
        for k in range(len(walls)):
            here = min(here, math.sqrt(max(walls[k, 0] + middle * (walls[k, 1] + middle * walls[k, 2]), 0.0)))
        most = count + 1 + 2 * len(squares) ** 2
        if most > len(found):
            longer = np.empty(2 * most)
            for k in range(count):
                longer[k] = found[k]
            found = longer
        if wanted and here > greatest:
            greatest = here
            found[count] = middle
            count += 1
        if reach < MIN_SPAN or nearest + reach / 2.0 < greatest or (not wanted and reach / 2.0 < nearest):
            continue
        near = np.flatnonzero(away <= nearest + reach)
        if len(near) > MAX_SOLVED_EDGES:
            waiting[spans, 0], waiting[spans, 1] = low, middle
            waiting[spans + 1, 0], waiting[spans + 1, 1] = middle, high
            spans += 2
            continue
        sides = _squares(starts[near], ends[near], a, step, squares)
        for k in range(len(walls)):
            for power in range(3):
                squares[sides + k, power] = walls[k, power]
        for first in range(sides + len(walls)):
            for second in range(first):
                c0 = squares[first, 0] - squares[second, 0]
                c1 = squares[first, 1] - squares[second, 1]
                c2 = squares[first, 2] - squares[second, 2]
                q = -0.5 * (c1 + math.copysign(math.sqrt(max(c1 * c1 - 4.0 * c2 * c0, 0.0)), c1))
                if c2 != 0.0:
                    found[count] = q / c2
                    count += 1
                if q != 0.0:
                    found[count] = c0 / q
                    count += 1
    return found[:count].copy()
