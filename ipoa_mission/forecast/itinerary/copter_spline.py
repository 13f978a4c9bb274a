"""The curve on which ArduCopter flies to a spline waypoint.

A cubic Hermite segment whose tangents are differences of places; an end where the copter stops has none. Source:
ArduPilot's documentation of spline waypoints, and the recorded flights.
"""

import math

import numpy as np

from ipoa_mission.forecast.itinerary.program import Place
from ipoa_mission.geometry import Points

NO_TANGENT = (0.0, 0.0, 0.0)
SHORTEST_TANGENT = 0.01  # a leg before that is shorter gives a spline no direction [m]


def spline_tangents(
    origin: Place, target: Place, flown_in: Place | None, after: tuple[Place, bool] | None
) -> tuple[Place, Place]:
    """The tangents [m] at both ends of the curve from `origin` to `target`.

    It begins as the leg before ended, along `flown_in` (None: at rest). It ends along the line from its origin to the
    place `after` it if that is reached by another spline (the flag), along the next leg if that is straight.
    """
    begin = end = NO_TANGENT
    if flown_in is not None and math.hypot(*flown_in) > SHORTEST_TANGENT:
        begin = flown_in
    if after is not None:
        place, bends_on = after
        end = minus(place, origin if bends_on else target)
    return begin, end


def cubic(origin: Place, target: Place, tangents: tuple[Place, Place]) -> tuple[Place, Place, Place, Place]:
    """The vectors a, b, c, d of a + b u + c u^2 + d u^3 for u from 0 to 1.

    Tangents that are together longer than four chords are scaled down to that.
    """
    begin, end = tangents
    size = math.hypot(*begin) + math.hypot(*end)
    scale = min(1.0, 4 * math.dist(origin, target) / size) if size > 0 else 0.0
    axes = [(a, b, scale * m, scale * k) for a, b, m, k in zip(origin, target, begin, end, strict=True)]
    rows = [(a, m, 3 * (b - a) - 2 * m - k, 2 * (a - b) + m + k) for a, b, m, k in axes]
    places, slopes, squares, cubes = zip(*rows, strict=True)
    return places, slopes, squares, cubes


def spline_chords(origin: Place, target: Place, tangents: tuple[Place, Place], tolerance: float) -> Points:
    """Points on the curve, ends included, (n, 3) [m]: it leaves the lines between them by no more than `tolerance`."""
    a, b, c, d = np.array(cubic(origin, target, tangents))
    bend = max(float(np.linalg.norm(2 * c)), float(np.linalg.norm(2 * c + 6 * d)))  # the second derivative is linear
    u = np.linspace(0.0, 1.0, math.ceil(math.sqrt(bend / (8 * tolerance))) + 2)[:, None]
    return np.asarray(a + u * (b + u * (c + u * d)))


def minus(one: Place, other: Place) -> Place:
    """The difference of two places."""
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]
