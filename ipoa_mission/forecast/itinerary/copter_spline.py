"""The curve on which ArduCopter flies to a spline waypoint.

A cubic Hermite segment whose tangents are differences of places; an end where the copter stops has none. Source:
ArduPilot's documentation of spline waypoints, the recorded flights, and 4.8.0-dev (ModeAuto::get_spline_from_cmd).
"""

import math
import struct

import numpy as np

from ipoa_mission.forecast.itinerary.program import Place, over_terrain
from ipoa_mission.geometry import Points
from ipoa_mission.mission.commands import Command
from ipoa_mission.mission.items import Item

NO_TANGENT = (0.0, 0.0, 0.0)
SHORTEST_TANGENT = 0.01  # a leg that is shorter gives a spline no direction [m]
#: Navigation commands that ArduPilot stores with a place. What the others store is read as one all the same.
WITH_PLACE = frozenset({
    Command.NAV_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TIME, Command.NAV_LAND,
    Command.NAV_TAKEOFF, Command.NAV_CONTINUE_AND_CHANGE_ALT, Command.NAV_LOITER_TO_ALT, Command.NAV_ARC_WAYPOINT,
    Command.NAV_SPLINE_WAYPOINT, Command.NAV_VTOL_TAKEOFF, Command.NAV_VTOL_LAND, Command.NAV_GUIDED_ENABLE,
    Command.NAV_PAYLOAD_PLACE,
})  # fmt: skip


def reads_as_here(item: Item) -> bool:
    """Whether what a navigation command without a place stores is read as "here", and a spline before it ends at rest.

    Of NAV_DELAY hour, minute and second are read as an altitude, and the last byte of its seconds as the frame of that.
    """
    if item.command == Command.NAV_DELAY:
        seconds, *clock = item.params
        return struct.pack("<f", seconds)[0] == 0 and not any(map(int, clock))
    return item.command == Command.NAV_RETURN_TO_LAUNCH


def place_after(spline: Item, following: Item, target: Place, named: Place) -> tuple[Place, bool] | None:
    """The place that shapes the end of a spline to `target`, and whether a spline leads to it; None: it ends at rest.

    It is the one that the next navigation command names, whatever the command. Latitude and longitude 0 are those of
    the target, and altitude 0 is its height. Heights over terrain and over home do not go together.
    """
    if following.command not in WITH_PLACE or over_terrain(following) != over_terrain(spline):
        return None
    east, north, up = named
    if (following.latitude_deg, following.longitude_deg) == (0.0, 0.0):
        east, north, _ = target
    if following.altitude == 0.0:
        up = target[2]
    return (east, north, up), following.command == Command.NAV_SPLINE_WAYPOINT


def spline_tangents(
    origin: Place, target: Place, flown_in: Place | None, after: tuple[Place, bool] | None
) -> tuple[Place, Place]:
    """The tangents [m] at both ends of the curve from `origin` to `target`.

    It begins as the leg before ended, along `flown_in` (None: at rest). It ends along the line from its origin to the
    place `after` it if that is reached by another spline (the flag), else along the line to that place.
    """
    begin = end = NO_TANGENT
    if flown_in is not None and math.hypot(*flown_in) > SHORTEST_TANGENT:
        begin = flown_in
    if after is not None:
        place, bends_on = after
        end = minus(place, origin if bends_on else target)
        if math.hypot(*end) <= SHORTEST_TANGENT:  # that is what rounding leaves of a place
            end = NO_TANGENT
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
