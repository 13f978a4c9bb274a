"""The circle that ArduCopter flies for NAV_LOITER_TURNS: its radius and turns as the board keeps them, its entry.

It flies straight to the nearest point of the circle, and from within `NEAR_CIRCLE` of that begins where it is. Read in
4.8.0-dev (AC_Circle, ModeAuto::circle_movetoedge_start) and flown: docs/lab/flight-time.md.
"""

import math

import numpy as np

from ipoa_mission.forecast.itinerary.program import Place
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.circle import FlownCircle

NEAR_CIRCLE = 3.0  # [m]
AT_CENTER = 0.5  # [m] a vehicle so near to the center leaves it backwards
SURE_SHARE = 0.15  # who is farther from the center than this share of the radius enters within 2 m of where he is to
MOST_TURNS, MOST_METRES = 255, 255


def radius_of(item: Item) -> float:
    """The radius of the circle [m]: whole metres, or tens of metres above 255."""
    radius = abs(item.params[2])
    if not math.isfinite(radius):
        return 0.0
    return float(int(radius)) if radius <= MOST_METRES else 10.0 * min(MOST_METRES, int(radius / 10.0))


def circle_turn(item: Item, sense: float = 0.0) -> float:
    """By how much it circles in all [rad], clockwise positive: whole turns, or 256ths of one.

    `sense`: what counts in place of the sign of the radius, where it is not 0.
    """
    turns = item.params[0]
    if not turns > 0.0:
        return 0.0
    kept = int(256.0 * turns) / 256.0 if turns < 1.0 else float(int(min(turns, MOST_TURNS)))
    return math.copysign(math.tau * kept, sense or item.params[2])


def circle_entry(here: Place, center: Place, radius: float, heading: float) -> tuple[Place, float]:
    """The nearest point of the circle from `here`, and how far it is [m]; from its center the point behind the nose.

    `heading`: clockwise from north [rad].
    """
    if radius <= 0.0:
        return center, 0.0
    bearing = bearing_from(center, here)
    if math.dist(here, center) < AT_CENTER:
        bearing = heading + math.pi
    edge = on_circle(center, radius, bearing)
    return edge, math.dist(here, edge)


def entry_is_unsure(here: Place, center: Place, radius: float) -> bool:
    """Whether noise of a few decimeters decides on which side of the circle it begins: it is near the center's axis."""
    far = math.dist(here[:2], center[:2])
    return radius > 0.0 and far < max(2 * AT_CENTER, SURE_SHARE * radius) and math.dist(here, center) > AT_CENTER / 2


def bearing_from(center: Place, place: Place) -> float:
    """Clockwise from north [rad]."""
    return math.atan2(place[0] - center[0], place[1] - center[1])


def on_circle(center: Place, radius: float, bearing: float) -> Place:
    """The place on the circle in this direction from its center."""
    return center[0] + radius * math.sin(bearing), center[1] + radius * math.cos(bearing), center[2]


def circle_chords(begin: Place, center: Place, flown: FlownCircle, turn: float, stray: float) -> Points:
    """Points (n, 3) from `begin` along the circle that is flown, level: one turn and what is left of the last.

    The circle leaves their chords by no more than `stray` [m]; the last leads straight on to where the vehicle stops.
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
