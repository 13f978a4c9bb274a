"""Compute the curve on which ArduCopter flies to a spline waypoint.

A cubic Hermite segment whose tangents are differences of places; a stop has no tangent. Source: 4.8.0-dev
(ModeAuto::get_spline_from_cmd) and recorded flights.
"""

import math
import struct

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.forecast.itinerary.program import Place, over_terrain
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Item

NO_TANGENT = (0.0, 0.0, 0.0)
MIN_TANGENT = 0.01  # [m]
# ArduPilot stores these with a place, and reads the data of the others as one.
WITH_PLACE = frozenset({
    Command.NAV_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TIME, Command.NAV_LAND,
    Command.NAV_TAKEOFF, Command.NAV_CONTINUE_AND_CHANGE_ALT, Command.NAV_LOITER_TO_ALT, Command.NAV_ARC_WAYPOINT,
    Command.NAV_SPLINE_WAYPOINT, Command.NAV_VTOL_TAKEOFF, Command.NAV_VTOL_LAND, Command.NAV_GUIDED_ENABLE,
    Command.NAV_PAYLOAD_PLACE,
})  # fmt: skip


def reads_as_here(item: Item) -> bool:
    """Return whether a stored command without a place reads as "here": a spline before it ends at rest.

    Hour, minute and second of NAV_DELAY are read as an altitude, and the last byte of its seconds as its frame.
    """
    if item.command == Command.NAV_DELAY:
        seconds, *clock = item.params
        return struct.pack("<f", seconds)[0] == 0 and not any(map(int, clock))
    return item.command == Command.NAV_RETURN_TO_LAUNCH


def place_after(spline: Item, following: Item, target: Place, named: Place) -> tuple[Place, bool] | None:
    """Return the place that shapes the end of a spline to `target`, and whether a spline leads to it.

    Latitude and longitude 0 are the target's, altitude 0 its height. None: an end at rest, also where heights over
    terrain and over home meet.
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
    """Return the tangents [m] at both ends of the curve.

    It begins along `flown_in`, the end of the leg before (None: at rest). It ends along the line to the place `after`
    it: from its origin if a spline leads there (the flag), else from its target.
    """
    begin = end = NO_TANGENT
    if flown_in is not None and math.hypot(*flown_in) > MIN_TANGENT:
        begin = flown_in
    if after is not None:
        place, bends_on = after
        end = minus(place, origin if bends_on else target)
        if math.hypot(*end) <= MIN_TANGENT:  # rounding
            end = NO_TANGENT
    return begin, end


def cubic(origin: Place, target: Place, tangents: tuple[Place, Place]) -> tuple[Place, Place, Place, Place]:
    """Return a, b, c, d of a + b u + c u^2 + d u^3, with tangents of four chords together at most."""
    begin, end = tangents
    size = math.hypot(*begin) + math.hypot(*end)
    scale = min(1.0, 4 * math.dist(origin, target) / size) if size > 0 else 0.0
    axes = [(a, b, scale * m, scale * k) for a, b, m, k in zip(origin, target, begin, end, strict=True)]
    rows = [(a, m, 3 * (b - a) - 2 * m - k, 2 * (a - b) + m + k) for a, b, m, k in axes]
    places, slopes, squares, cubes = zip(*rows, strict=True)
    return places, slopes, squares, cubes


def spline_chords(origin: Place, target: Place, tangents: tuple[Place, Place], tolerance: float) -> Points:
    """Return points (n, 3) [m], with chords within `tolerance`."""
    a, b, c, d = np.array(cubic(origin, target, tangents))
    bend = max(float(np.linalg.norm(2 * c)), float(np.linalg.norm(2 * c + 6 * d)))  # the second derivative is linear
    u = np.linspace(0.0, 1.0, math.ceil(math.sqrt(bend / (8 * tolerance))) + 2)[:, None]
    return np.asarray(a + u * (b + u * (c + u * d)))


def minus(one: Place, other: Place) -> Place:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]
