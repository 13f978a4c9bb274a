"""Compute the arcs, circles and splines that ArduCopter flies.

The height changes linearly on an arc. A circle is entered at its nearest point, within `NEAR_CIRCLE` in place. A
spline is a cubic Hermite segment whose tangents are differences of places; a stop has no tangent.
"""

import math
import struct

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.guidance_profile import FlownCircle
from ipoa_mission.geometry import Place, Points
from ipoa_mission.mission.items import Item

NEAR_CIRCLE = 3.0  # [m]
CENTER_RADIUS = 0.5  # [m] within which a vehicle leaves the center backwards
# ArduPilot stores these with a place, and reads the data of the others as one.
WITH_PLACE = frozenset({
    Command.NAV_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TIME, Command.NAV_LAND,
    Command.NAV_TAKEOFF, Command.NAV_CONTINUE_AND_CHANGE_ALT, Command.NAV_LOITER_TO_ALT, Command.NAV_ARC_WAYPOINT,
    Command.NAV_SPLINE_WAYPOINT, Command.NAV_VTOL_TAKEOFF, Command.NAV_VTOL_LAND, Command.NAV_GUIDED_ENABLE,
    Command.NAV_PAYLOAD_PLACE,
})  # fmt: skip


def turn_of(item: Item) -> float:
    """Return the turn [rad], in whole degrees, clockwise positive; 0 (below one degree, or a circle): straight."""
    if item.command != Command.NAV_ARC_WAYPOINT or not math.isfinite(item.params[0]):
        return 0.0
    turn = math.radians(math.trunc(item.params[0]))
    return turn if abs(_wrapped(turn)) >= math.radians(1.0) else 0.0


def arc_center(origin: Place, target: Place, turn: float) -> tuple[float, float]:
    east, north = target[0] - origin[0], target[1] - origin[1]
    across = math.hypot(east, north)
    offset = math.sqrt(max(arc_radius(origin, target, turn) ** 2 - across**2 / 4, 0.0)) / across
    offset *= math.copysign(1.0, turn) * (1.0 if _wrapped(abs(turn)) > 0.0 else -1.0)
    return origin[0] + east / 2 + offset * north, origin[1] + north / 2 - offset * east


def arc_radius(origin: Place, target: Place, turn: float) -> float:
    return math.dist(origin[:2], target[:2]) / (2.0 * abs(math.sin(turn / 2.0)))


def is_arc(origin: Place, target: Place, turn: float) -> bool:
    return turn != 0.0 and math.dist(origin[:2], target[:2]) > 1e-3  # [m]


def arc_length(origin: Place, target: Place, turn: float) -> float:
    return math.hypot(arc_radius(origin, target, turn) * turn, target[2] - origin[2])


def arc_chords(origin: Place, target: Place, turn: float, tolerance: float) -> Points:
    widest = 2.0 * math.acos(max(1.0 - tolerance / arc_radius(origin, target, turn), 0.0))
    share = np.linspace(0.0, 1.0, max(2, math.ceil(abs(turn) / widest) + 1))
    x, y = arc_center(origin, target, turn)
    sine, cosine = np.sin(turn * share), np.cos(turn * share)
    east, north = origin[0] - x, origin[1] - y
    chord_east = x + east * cosine + north * sine
    chord_north = y - east * sine + north * cosine
    points = np.column_stack([chord_east, chord_north, origin[2] + share * (target[2] - origin[2])])
    points[-1] = target
    return points


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


def circle_radius(item: Item) -> float:
    """Return the radius [m] as stored in a byte: whole meters, or tens of meters above 255."""
    radius = abs(item.params[2])
    if not math.isfinite(radius):
        return 0.0
    return float(int(radius)) if radius <= 255 else 10.0 * min(255, int(radius / 10.0))


def circle_turn(item: Item, sense: float = 0.0) -> float:
    """Return the stored turn [rad], clockwise positive, or by a nonzero `sense`; whole turns, or 256ths of one."""
    turns = item.params[0]
    if not turns > 0.0:
        return 0.0
    kept = int(256.0 * turns) / 256.0 if turns < 1.0 else float(int(min(turns, 255)))
    return math.copysign(math.tau * kept, sense or item.params[2])


def circle_entry(here: Place, center: Place, radius: float, heading: float) -> tuple[Place, float]:
    """Return the nearest point of the circle and its distance [m]; from the center the point behind the vehicle."""
    if radius <= 0.0:
        return center, 0.0
    bearing = bearing_from(center, here)
    if math.dist(here, center) < CENTER_RADIUS:
        bearing = heading + math.pi
    edge = center[0] + radius * math.sin(bearing), center[1] + radius * math.cos(bearing), center[2]
    return edge, math.dist(here, edge)


def entry_is_unsure(here: Place, center: Place, radius: float) -> bool:
    return (  # farther out the entry is within 2 m
        radius > 0.0
        and math.dist(here[:2], center[:2]) < max(2 * CENTER_RADIUS, 0.15 * radius)
        and math.dist(here, center) > CENTER_RADIUS / 2
    )


def bearing_from(center: Place, place: Place) -> float:
    return math.atan2(place[0] - center[0], place[1] - center[1])


def circle_chords(begin: Place, center: Place, flown: FlownCircle, turn: float, tolerance: float) -> Points:
    """Return level points from `begin`: one turn, the rest of the last, straight to the stop."""
    whole, sense = math.fmod(turn, math.tau), math.copysign(1.0, turn)
    swept = turn if abs(turn) <= math.tau else sense * math.tau + whole
    swept = sense * max(abs(swept) - flown.behind, 0.0)
    widest = 2.0 * math.acos(max(1.0 - tolerance / flown.radius, 0.0))
    bearings = bearing_from(center, begin) + np.linspace(0.0, swept, max(2, math.ceil(abs(swept) / widest) + 1))
    around = np.column_stack([np.sin(bearings), np.cos(bearings)])
    onward = sense * flown.runs_on * np.array([around[-1, 1], -around[-1, 0]])
    top_view = np.array(center[:2]) + np.vstack([flown.radius * around, flown.radius * around[-1] + onward])
    points = np.column_stack([top_view, np.full(len(top_view), begin[2])])
    return np.vstack([[begin], points]) if math.dist(begin, points[0]) > tolerance else points


def reads_as_here(item: Item) -> bool:
    """Return whether a stored command without a place reads as "here": a spline before it ends at rest.

    Hour, minute and second of NAV_DELAY are read as an altitude, and the last byte of its seconds as its frame.
    """
    if item.command == Command.NAV_DELAY:
        seconds, *clock = item.params
        return struct.pack("<f", seconds)[0] == 0 and not any(map(int, clock))
    return item.command == Command.NAV_RETURN_TO_LAUNCH


def place_after(spline: Item, next_item: Item, target: Place, named: Place) -> tuple[Place, bool] | None:
    """Return the place that shapes the end of a spline to `target`, and whether a spline leads to it.

    Latitude and longitude 0 are the target's, altitude 0 its height. None: an end at rest, also where heights over
    terrain and over home meet.
    """
    if next_item.command not in WITH_PLACE or next_item.is_over_terrain != spline.is_over_terrain:
        return None
    east, north, up = named
    if (next_item.latitude_deg, next_item.longitude_deg) == (0.0, 0.0):
        east, north, _ = target
    if next_item.altitude == 0.0:
        up = target[2]
    return (east, north, up), next_item.command == Command.NAV_SPLINE_WAYPOINT


def spline_tangents(
    origin: Place, target: Place, flown_in: Place | None, after: tuple[Place, bool] | None
) -> tuple[Place, Place]:
    """Return the tangents [m] at both ends of the curve.

    It begins along `flown_in`, the end of the leg before (None: at rest). It ends along the line to the place `after`
    it: from its origin if a spline leads there (the flag), else from its target.
    """
    begin = end = none = (0.0, 0.0, 0.0)
    if flown_in is not None and math.hypot(*flown_in) > 0.01:  # [m], rounding
        begin = flown_in
    if after is not None:
        place, bends_on = after
        end = minus(place, origin if bends_on else target)
    return begin, end if math.hypot(*end) > 0.01 else none


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
    a, b, c, d = np.array(cubic(origin, target, tangents))
    bend = max(float(np.linalg.norm(2 * c)), float(np.linalg.norm(2 * c + 6 * d)))  # the second derivative is linear
    u = np.linspace(0.0, 1.0, math.ceil(math.sqrt(bend / (8 * tolerance))) + 2)[:, None]
    return np.asarray(a + u * (b + u * (c + u * d)))


def minus(end: Place, begin: Place) -> Place:
    return end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
