"""Compiled values at a place, inlined at every node. A grid is unpacked first, else it is reference-counted there."""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit
from ipoa_mission.planning.obstacle_grid import FENCE, LEAST
from ipoa_mission.world.obstacles.obstacle import CYLINDER, SPHERE

FASTMATH = {"reassoc", "contract", "arcp", "nsz"}  # for vectorized sums


@njit(inline="always")
def _on_map(raster, x, y):
    """Return fractional column and row; 0 for NaN."""
    u, v = (x - raster.east) * raster.per_meter, (y - raster.north) * raster.per_meter
    u, v = u if u > 0.0 else 0.0, v if v > 0.0 else 0.0
    return min(u, raster.columns - 1.0), min(v, raster.rows - 1.0)


@njit(inline="always")
def _ground(raster, heights, x, y):
    """Return the height of the ground and its slopes along east and north."""
    u, v = _on_map(raster, x, y)
    i, j = min(int(u), raster.columns - 2), min(int(v), raster.rows - 2)
    u, v = u - i, v - j
    south, north = heights[j, i + 1] - heights[j, i], heights[j + 1, i + 1] - heights[j + 1, i]
    low, high = heights[j, i] + u * south, heights[j + 1, i] + u * north
    return low + v * (high - low), ((1.0 - v) * south + v * north) * raster.per_meter, (high - low) * raster.per_meter


@njit(inline="always")
def _cell(raster, x, y):
    u, v = _on_map(raster, x, y)
    return np.int32(np.floor(v) * raster.columns + np.floor(u))


@njit(inline="always")
def _least_height(low_zones, height, x, y):
    for k in range(low_zones.shape[0]):
        if (x - low_zones[k, 0]) ** 2 + (y - low_zones[k, 1]) ** 2 <= low_zones[k, 2] ** 2:
            height = min(height, low_zones[k, 3])
    return height


@njit(inline="always")
def _aside(kind, shape, edges, body, x, y):
    """Return the signed plane distance, and its direction."""
    if kind[body] == CYLINDER:
        e, n = x - shape[body, 0], y - shape[body, 1]
        r = math.sqrt(e * e + n * n) + 1e-12
        aside = r - shape[body, 2]
    else:
        e, n, nearest, inside = 0.0, 0.0, 1e300, False
        for k in range(int(shape[body, 0]), int(shape[body, 1])):
            e0, n0, e1, n1 = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
            share = ((x - e0) * (e1 - e0) + (y - n0) * (n1 - n0)) / ((e1 - e0) ** 2 + (n1 - n0) ** 2)
            share = min(max(share, 0.0), 1.0)
            away_e, away_n = x - e0 - share * (e1 - e0), y - n0 - share * (n1 - n0)
            square = away_e * away_e + away_n * away_n
            if square < nearest:
                nearest, e, n = square, away_e, away_n
            if (n0 > y) != (n1 > y) and x < e0 + (y - n0) / (n1 - n0) * (e1 - e0):
                inside = not inside
        r = math.sqrt(nearest) + 1e-12
        if inside != (kind[body] == FENCE):
            r = -r
        aside = r
    return aside, e / r, n / r


@njit(inline="always")
def _distance(kind, shape, edges, body, x, y, z):
    """Return the signed distance, and its direction."""
    if kind[body] == SPHERE:
        e, n, u = x - shape[body, 0], y - shape[body, 1], z - shape[body, 2]
        r = math.sqrt(e * e + n * n + u * u) + 1e-12
        distance, e, n, u = r - shape[body, 3], e / r, n / r, u / r
    else:
        distance, e, n = _aside(kind, shape, edges, body, x, y)
        under, over = shape[body, 3] - z, z - shape[body, 4]
        above, u = max(under, over), 0.0
        if distance > 0.0 and above > 0.0:
            r = math.sqrt(distance * distance + above * above)
            e, n, u = e * distance / r, n * distance / r, (above if over > under else -above) / r
            distance = r
        elif above > distance:
            distance, e, n, u = above, 0.0, 0.0, 1.0 if over > under else -1.0
    return distance, e, n, u


@njit(inline="always")
def _slack_and_threat(grid, rules, place, least=-np.inf):
    """Return slack [m] and threat per meter at a place."""
    x, y, z = place
    cells, first, listed, _, around, kind, shape, edges, raster, heights, lower, upper, reach, zones = grid
    threat = 0.0
    ground = _ground(raster, heights, x, y)[0]
    slack = min(z - ground - _least_height(zones, rules.height, x, y), rules.ceiling - (z - ground))
    slack = min(slack, reach - rules.clearance)
    if not (lower[0] <= x <= upper[0] and lower[1] <= y <= upper[1] and lower[2] <= z <= upper[2]):
        slack = -np.inf
    cell = _cell(cells, x, y)
    for k in range(first[cell], first[cell + 1]):
        body = listed[k]
        if slack < least:  # the caller needs no more
            break
        if not around[body, 3] < z < around[body, 4]:
            continue
        if (x - around[body, 0]) ** 2 + (y - around[body, 1]) ** 2 > around[body, 2]:
            continue
        distance = _distance(kind, shape, edges, body, x, y, z)[0]
        if kind[body] == FENCE:
            slack = min(slack, distance)
            continue
        slack = min(slack, distance - rules.clearance)
        if distance - rules.radius < rules.d_safe:
            threat += rules.threat / max(distance - rules.radius, LEAST)
    return slack, threat
