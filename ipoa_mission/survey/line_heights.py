"""Compute flight heights that keep the requested overlap on slopes too."""

import math
from itertools import pairwise

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.survey.sight import Sight
from ipoa_mission.world.ground import Ground


def lifted(path: Points, sight: Sight, ground: Ground) -> tuple[Points, list[int]]:
    """Return a path (n, 2) with heights and added places, (m, 3), and the indices of its corners."""
    if sight.band == 0.0:
        return np.column_stack([path, ground(path) + sight.least]), [*range(len(path))]
    sampled = [_sampled(a, b, sight, ground) for a, b in pairwise(path)]
    floor = np.array([lower[0] for _, lower in sampled] + [sampled[-1][1][-1]])
    floor[1:] = np.maximum(floor[1:], [lower[-1] for _, lower in sampled])
    heights = floor + sight.band / 2
    points, corners = [np.append(path[0], heights[0])], [0]
    for n, (a, b) in enumerate(pairwise(path)):
        shares, lower = sampled[n]
        lower[[0, -1]] = floor[n : n + 2]
        vertices = _fewest(shares, lower, sight.band, (heights[n], heights[n + 1]))
        points += [np.append(a + share * (b - a), height) for share, height in vertices]
        corners.append(len(points) - 1)
    return np.array(points), corners


def _sampled(a: Points, b: Points, sight: Sight, ground: Ground) -> tuple[Vector, Vector]:
    """Return shares of a straight leg, and the minimum flight height at each."""
    ahead, samples = b - a, 9  # across the path, and along the photo
    length = float(np.linalg.norm(ahead))
    ahead = ahead / max(length, 1e-9)
    step = min(5.0, max(sight.across / samples, 0.5))  # [m]
    shares = np.linspace(0.0, 1.0, math.ceil(length / step) + 1)
    right = np.array([ahead[1], -ahead[0]])
    sides = np.linspace(-sight.across / 2, sight.across / 2, samples)
    along = np.linspace(-sight.along / 2, sight.along / 2, 1 if sight.along == 0.0 else samples)
    seen = (sides[:, None, None] * right + along[None, :, None] * ahead).reshape(-1, 2)
    spots = (a + shares[:, None] * (b - a))[:, None, :] + seen
    return shares, ground(spots.reshape(-1, 2)).reshape(len(shares), -1).max(axis=1) + sight.least


def _fewest(shares: Vector, lower: Vector, band: float, ends: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the fewest places between which straight flight stays in the band above `lower`."""
    places, tolerance = list[tuple[float, float]](), 0.01  # [m]
    ahead = [(0, len(shares) - 1, *ends)]
    while ahead:
        first, last, begin, end = ahead.pop()
        part = slice(first, last + 1)
        line = np.interp(shares[part], shares[[first, last]], [begin, end])
        short = np.maximum(lower[part] - line, line - lower[part] - band)
        worst = first + int(np.argmax(short[1:-1])) + 1 if last - first > 1 else first
        if last - first <= 1 or short[worst - first] <= tolerance:
            places.append((float(shares[last]), end))
            continue
        middle = float(lower[worst]) + band / 2
        ahead += [(worst, last, middle, end), (first, worst, begin, middle)]
    return places
