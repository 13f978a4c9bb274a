"""Compute the circle that ArduCopter flies for NAV_LOITER_TURNS.

It flies straight to the nearest point of the circle. Within `NEAR_CIRCLE` of that point it begins in place. Source:
4.8.0-dev (AC_Circle, ModeAuto::circle_movetoedge_start), docs/lab/flight-time.md.
"""

import math

import numpy as np

from ipoa_mission.autopilot.guidance_profile import FlownCircle
from ipoa_mission.forecast.itinerary.program import Place
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Item

NEAR_CIRCLE = 3.0  # [m]
CENTER_RADIUS = 0.5  # [m] within which a vehicle leaves the center backwards
SURE_SHARE = 0.15  # of the radius; farther out the entry is within 2 m
MAX_TURNS, MAX_RADIUS = 255, 255


def radius_of(item: Item) -> float:
    """Return the radius [m]: whole meters, or tens of meters above 255."""
    radius = abs(item.params[2])
    if not math.isfinite(radius):
        return 0.0
    return float(int(radius)) if radius <= MAX_RADIUS else 10.0 * min(MAX_RADIUS, int(radius / 10.0))


def circle_turn(item: Item, sense: float = 0.0) -> float:
    """Return the turn [rad] as stored, clockwise positive: whole turns, or 256ths of one.

    `sense` replaces the sign of the radius where it is not 0.
    """
    turns = item.params[0]
    if not turns > 0.0:
        return 0.0
    kept = int(256.0 * turns) / 256.0 if turns < 1.0 else float(int(min(turns, MAX_TURNS)))
    return math.copysign(math.tau * kept, sense or item.params[2])


def circle_entry(here: Place, center: Place, radius: float, heading: float) -> tuple[Place, float]:
    """Return the nearest point of the circle and its distance [m]; from the center the point behind the vehicle."""
    if radius <= 0.0:
        return center, 0.0
    bearing = bearing_from(center, here)
    if math.dist(here, center) < CENTER_RADIUS:
        bearing = heading + math.pi
    edge = on_circle(center, radius, bearing)
    return edge, math.dist(here, edge)


def entry_is_unsure(here: Place, center: Place, radius: float) -> bool:
    return (
        radius > 0.0
        and math.dist(here[:2], center[:2]) < max(2 * CENTER_RADIUS, SURE_SHARE * radius)
        and math.dist(here, center) > CENTER_RADIUS / 2
    )


def bearing_from(center: Place, place: Place) -> float:
    return math.atan2(place[0] - center[0], place[1] - center[1])


def on_circle(center: Place, radius: float, bearing: float) -> Place:
    return center[0] + radius * math.sin(bearing), center[1] + radius * math.cos(bearing), center[2]


def circle_chords(begin: Place, center: Place, flown: FlownCircle, turn: float, stray: float) -> Points:
    """Return level points from `begin`: one turn, the rest of the last, and straight to the stop.

    Chords are within `stray` [m].
    """
    whole, sense = math.fmod(turn, math.tau), math.copysign(1.0, turn)
    swept = turn if abs(turn) <= math.tau else sense * math.tau + whole
    swept = sense * max(abs(swept) - flown.behind, 0.0)
    widest = 2.0 * math.acos(max(1.0 - stray / flown.radius, 0.0))
    bearings = bearing_from(center, begin) + np.linspace(0.0, swept, max(2, math.ceil(abs(swept) / widest) + 1))
    around = np.column_stack([np.sin(bearings), np.cos(bearings)])
    onward = sense * flown.runs_on * np.array([around[-1, 1], -around[-1, 0]])
    level = np.array(center[:2]) + np.vstack([flown.radius * around, flown.radius * around[-1] + onward])
    points = np.column_stack([level, np.full(len(level), begin[2])])
    return np.vstack([[begin], points]) if math.dist(begin, points[0]) > stray else points
