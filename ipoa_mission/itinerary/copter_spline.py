"""The curve on which ArduCopter flies to a spline waypoint, and where it flies on without a stop.

A cubic Hermite segment whose tangents are differences of places; an end where the copter stops has none. Source:
ArduPilot's documentation of spline waypoints, and the recorded flights.
"""

import math
from collections.abc import Sequence

import numpy as np

from ipoa_mission.commands import Command
from ipoa_mission.geometry import Points
from ipoa_mission.items import Item
from ipoa_mission.itinerary.itinerary import LAST_NAV

Place = tuple[float, float, float]

NO_TANGENT = (0.0, 0.0, 0.0)
SHORTEST_TANGENT = 0.01  # a leg before that is shorter gives a spline no direction [m]

#: After a waypoint the copter flies on into these; before everything else it stops.
FLOWN_ON_INTO = frozenset(
    {Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TIME}
)


def is_passed(item: Item) -> bool:
    """Whether the copter does not wait at this item."""
    return item.command in (Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT) and item.params[0] < 1


def flies_on_to(items: Sequence[Item], n: int) -> int | None:
    """The item that the copter flies on to without stopping at item n; those that do not move it are no hindrance."""
    if not is_passed(items[n]):
        return None
    for later in range(n + 1, len(items)):
        command = items[later].command
        if command <= LAST_NAV:
            return later if command in FLOWN_ON_INTO else None
    return None


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
