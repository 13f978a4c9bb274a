"""Bounds of legs' heights above the paper's surface, by branch and bound.

A span differs from linear interpolation by at most the surface's deviation from its chord.
"""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit

PARTS = 4
REFINED = 1e-4  # [m]
DEEPEST = 30  # divisions to the floating-point resolution


@njit(error_model="numpy")
def _surfaces(landform, peaks, x, y):
    """Eqs. (1) and (2)."""
    a, b, c, d, e, f, g, high = landform
    r = math.hypot(x, y)
    low = math.sin(y + a) + b * math.sin(x) + c * math.cos(d * r) + (e + g) * math.cos(y) + f * math.sin(f * r)
    for k in range(len(peaks)):
        away_e, away_n = (x - peaks[k, 1]) / peaks[k, 3], (y - peaks[k, 2]) / peaks[k, 4]
        high += peaks[k, 0] * math.exp(-away_e * away_e - away_n * away_n)
    return low, high


@njit(error_model="numpy")
def _bends(landform, peaks, greatest):
    """Bound the rise (or sag) from a chord of 1 m, east and north [m].

    c cos(d r) curves by at most |c| d^2, f sin(f r) arches by at most |f|^3. A Gaussian exp(-w^2) has second
    derivatives between -2 and 4 exp(-3/2).
    """
    _, b, c, d, e, f, g, _ = landform
    round_about = abs(c) * d * d + abs(f) ** 3
    east, north, high_e, high_n = abs(b) + round_about, 1.0 + abs(e + g) + round_about, 0.0, 0.0
    for k in range(len(peaks)):
        sharp = 2.0 if (peaks[k, 0] > 0.0) != greatest else 4.0 * math.exp(-1.5)
        high_e += sharp * abs(peaks[k, 0]) / peaks[k, 3] ** 2
        high_n += sharp * abs(peaks[k, 0]) / peaks[k, 4] ** 2
    return east / 8.0, north / 8.0, high_e / 8.0, high_n / 8.0


@njit(error_model="numpy")
def _kink(f, x, y, run):
    """Bound the extra sag of f sin(f r) over a squared horizontal length `run` [m].

    Its curvature f^2 / r has a kink at the origin. Over a length s it sags by at most f^2 s / 2.
    """
    span = math.sqrt(run)
    nearest = max(math.hypot(x, y) - span / 2.0, 1e-12)
    return min(f * f / nearest * run / 8.0, f * f * span / 2.0)


@njit(cache=True, error_model="numpy")
def extreme(points, landform, peaks, greatest, enough):
    """Bound the least (or greatest) height of legs within `REFINED`, with leg and fraction.

    `points` (n, 3); `landform`: a to g, base; `peaks` (m, 5): heights, centers, slopes. A bound above `enough` may be
    loose.
    """
    sign = -1.0 if greatest else 1.0
    low_e, low_n, high_e, high_n = _bends(landform, peaks, greatest)
    best, leg, fraction, proven = math.inf, 0, 0.0, math.inf
    ends = np.empty((len(points), 2))
    for n in range(len(points)):
        low, high = _surfaces(landform, peaks, points[n, 0], points[n, 1])
        ends[n, 0], ends[n, 1] = points[n, 2] - low, points[n, 2] - high
        if math.isnan(ends[n, 0] + ends[n, 1]):
            return -sign * math.inf, min(n, len(points) - 2), 0.0
        height = sign * min(ends[n, 0], ends[n, 1])
        if height < best:
            best, leg, fraction = height, min(n, len(points) - 2), 1.0 if n > len(points) - 2 else 0.0
    spans = np.empty((PARTS * DEEPEST, 6))  # begin, width, heights at both ends
    for n in range(len(points) - 1):
        x0, y0, z0 = points[n, 0], points[n, 1], points[n, 2]
        dx, dy, dz = points[n + 1, 0] - x0, points[n + 1, 1] - y0, points[n + 1, 2] - z0
        spans[0, 0], spans[0, 1], count = 0.0, 1.0, 1
        for k in range(2):
            spans[0, 2 + k], spans[0, 4 + k] = ends[n, k], ends[n + 1, k]
        while count > 0:
            count -= 1
            begin, width, low, high = spans[count, 0], spans[count, 1], spans[count, 2], spans[count, 3]
            next_low, next_high = spans[count, 4], spans[count, 5]
            east, north = (dx * width) ** 2, (dy * width) ** 2
            strays_low, strays_high = low_e * east + low_n * north, high_e * east + high_n * north
            if greatest:
                middle = begin + width / 2.0
                strays_low += _kink(landform[5], x0 + middle * dx, y0 + middle * dy, east + north)
                bound = -min(max(low, next_low) + strays_low, max(high, next_high) + strays_high)
            else:
                bound = min(min(low, next_low) - strays_low, min(high, next_high) - strays_high)
            if bound >= min(best - REFINED, enough) or count + PARTS > len(spans):
                proven = min(proven, bound)
                continue
            width /= PARTS
            for part in range(1, PARTS + 1):
                spans[count, 0], spans[count, 1] = begin + (part - 1) * width, width
                spans[count, 2], spans[count, 3] = low, high
                low, high = next_low, next_high
                if part < PARTS:
                    at = begin + part * width
                    low, high = _surfaces(landform, peaks, x0 + at * dx, y0 + at * dy)
                    low, high = z0 + at * dz - low, z0 + at * dz - high
                    height = sign * min(low, high)
                    if height < best:
                        best, leg, fraction = height, n, at
                spans[count, 4], spans[count, 5] = low, high
                count += 1
    return sign * min(best, proven), leg, fraction


@njit(cache=True, error_model="numpy")
def least_heights(legs, landform, peaks, enough):
    """Bound the least height of each of legs (n, 2, 3), (n,), as `extreme`."""
    bends = _bends(landform, peaks, False)
    heights = np.empty(len(legs))
    under = (0.0, 0.0)
    for n in range(len(legs)):
        first = legs[n, 0]
        last = legs[n, 1]
        low, high = under
        if n == 0 or first[0] != legs[n - 1, 1, 0] or first[1] != legs[n - 1, 1, 1]:
            low, high = _surfaces(landform, peaks, first[0], first[1])
        under = _surfaces(landform, peaks, last[0], last[1])
        east = (last[0] - first[0]) ** 2
        north = (last[1] - first[1]) ** 2
        above_low = min(first[2] - low, last[2] - under[0]) - (bends[0] * east + bends[1] * north)
        above_high = min(first[2] - high, last[2] - under[1]) - (bends[2] * east + bends[3] * north)
        heights[n] = min(above_low, above_high)
        if not heights[n] >= enough:
            heights[n] = extreme(legs[n], landform, peaks, False, enough)[0]
    return heights
