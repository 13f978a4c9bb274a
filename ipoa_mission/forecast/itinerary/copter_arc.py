"""Compute the arc on which ArduCopter 4.7 flies to a NAV_ARC_WAYPOINT.

Height changes linearly along it. An arc below one degree, or of a whole circle, is a straight leg.
"""

import math

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.forecast.itinerary.program import Place
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Item

MIN_TURN = math.radians(1.0)
MIN_CHORD = 1e-3  # [m]


def turn_of(item: Item) -> float:
    """Return the turn [rad], in whole degrees, clockwise positive; 0: straight."""
    if item.command != Command.NAV_ARC_WAYPOINT or not math.isfinite(item.params[0]):
        return 0.0
    turn = math.radians(math.trunc(item.params[0]))
    return turn if abs(_wrapped(turn)) >= MIN_TURN else 0.0


def arc_center(origin: Place, target: Place, turn: float) -> tuple[float, float]:
    east, north = target[0] - origin[0], target[1] - origin[1]
    across = math.hypot(east, north)
    radius = arc_radius(origin, target, turn)
    offset = math.sqrt(max(radius**2 - across**2 / 4, 0.0)) / across
    offset *= math.copysign(1.0, turn) * (1.0 if _wrapped(abs(turn)) > 0.0 else -1.0)
    return origin[0] + east / 2 + offset * north, origin[1] + north / 2 - offset * east


def arc_radius(origin: Place, target: Place, turn: float) -> float:
    return math.dist(origin[:2], target[:2]) / (2.0 * abs(math.sin(turn / 2.0)))


def is_arc(origin: Place, target: Place, turn: float) -> bool:
    return turn != 0.0 and math.dist(origin[:2], target[:2]) > MIN_CHORD


def arc_length(origin: Place, target: Place, turn: float) -> float:
    return math.hypot(arc_radius(origin, target, turn) * turn, target[2] - origin[2])


def arc_chords(origin: Place, target: Place, turn: float, stray: float) -> Points:
    """Return points on the arc, with chords within `stray` [m]."""
    radius = arc_radius(origin, target, turn)
    widest = 2.0 * math.acos(max(1.0 - stray / radius, 0.0))
    share = np.linspace(0.0, 1.0, max(2, math.ceil(abs(turn) / widest) + 1))
    x, y = arc_center(origin, target, turn)
    sine, cosine = np.sin(turn * share), np.cos(turn * share)
    east, north = origin[0] - x, origin[1] - y
    points = np.column_stack(
        [
            x + east * cosine + north * sine,
            y - east * sine + north * cosine,
            origin[2] + share * (target[2] - origin[2]),
        ]
    )
    points[-1] = target
    return points


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)
