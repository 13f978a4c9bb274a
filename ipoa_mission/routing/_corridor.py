"""Compiled search for the fewest straight legs near a curve, and for the points of a path far from a line."""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit

FIRST_LOOK = 16  # samples


@njit(inline="always")
def _strays(samples, start, end, most):
    """Return the greatest distance of samples (n, 3) from the leg [m]."""
    x, y, z = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    square, farthest = max(x * x + y * y + z * z, 1e-12), 0.0
    for k in range(len(samples)):
        away_x, away_y, away_z = samples[k, 0] - start[0], samples[k, 1] - start[1], samples[k, 2] - start[2]
        share = min(max((away_x * x + away_y * y + away_z * z) / square, 0.0), 1.0)
        apart = (away_x - share * x) ** 2 + (away_y - share * y) ** 2 + (away_z - share * z) ** 2
        if apart > farthest:
            farthest = apart
            if apart > most * most:
                return math.inf
    return math.sqrt(farthest)


@njit(cache=True, error_model="numpy")
def fewest_legs(samples, spots, last, tolerance):
    """Return the predecessor (n, sides, 2) of each of `spots` (n, sides, 3) near samples (n, 3).

    Minimize the number of legs within `tolerance`, then the sum of squared deviations. A leg from sample i ends by
    `last[i]` (n,). The search stops after two growing windows without a fit.
    """
    n, sides = spots.shape[:2]
    legs, strain = np.full((n, sides), n + 1), np.full((n, sides), np.inf)
    before = np.zeros((n, sides, 2), np.int64)
    legs[0], strain[0] = 0, 0.0
    for i in range(n - 1):
        first, end, in_vain = i + 1, min(i + 1 + FIRST_LOOK, n), 0
        while in_vain < 2:
            fits = False
            for j in range(first, end):
                for side in range(sides if i else 1):
                    for other in range(sides):
                        away = _strays(samples[i + 1 : j + 1], spots[i, side], spots[j, other], tolerance)
                        if not away <= tolerance:
                            continue
                        fits = True
                        more, worn = legs[i, side] + 1, strain[i, side] + away * away
                        fewer = more < legs[j, other] or (more == legs[j, other] and worn < strain[j, other])
                        if j <= last[i] and fewer:
                            legs[j, other], strain[j, other] = more, worn
                            before[j, other, 0], before[j, other, 1] = i, side
            in_vain = 0 if fits else in_vain + 1
            if end >= n:
                break
            first, end = end, min(end + (end - i) // 2, n)
    return before


@njit(cache=True, error_model="numpy")
def far_points(points, line, most):
    """Return 1 for each of points (n, 2) that is farther than `most` [m] from a line (k, 2), else 0, (n,).

    Legs are tried outwards from the one that was near the point before.
    """
    far = np.ones(len(points), np.int8)
    legs = len(line) - 1
    at = 0
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for k in range(2 * legs):
            leg = at + (k + 1) // 2 if k % 2 else at - k // 2
            if leg < 0 or leg >= legs:
                continue
            east, north = line[leg + 1, 0] - line[leg, 0], line[leg + 1, 1] - line[leg, 1]
            away_e, away_n = x - line[leg, 0], y - line[leg, 1]
            share = min(max((away_e * east + away_n * north) / max(east * east + north * north, 1e-300), 0.0), 1.0)
            if (away_e - share * east) ** 2 + (away_n - share * north) ** 2 <= most * most:
                far[i] = 0
                at = leg
                break
    return far
