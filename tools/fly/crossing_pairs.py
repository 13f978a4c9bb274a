"""Missions of two vehicles that cross, one on PX4 and one on ArduPilot, by a seed."""

import random
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ipoa_mission import Geodetic, Mission
from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.items import change_speed, land, takeoff, waypoint

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)
AUTOPILOTS = ("px4", "ardupilot")


class CrossingPair(NamedTuple):
    """Two missions whose lines cross where both are about at the same time after their departures."""

    missions: tuple[Mission, Mission]


def crossing_pairs(number: int, seed: int, autopilots: tuple[str, str] = AUTOPILOTS) -> Iterator[CrossingPair]:
    """Yield pairs that cross at any angle over 30 deg, at 4 to 10 m/s, up to 6 m above each other."""
    for n in range(number):
        chance = random.Random(f"{seed} {n}")
        angle = chance.uniform(np.radians(30.0), np.radians(150.0)) * chance.choice((-1, 1))
        speeds = [chance.uniform(4.0, 10.0) for _ in range(2)]
        heights = [20.0, 20.0 + chance.uniform(0.0, 6.0)]
        to_crossing = 60.0 + chance.uniform(0.0, 30.0)
        lengths = [to_crossing, to_crossing * speeds[1] / speeds[0]]
        missions = [
            _line(autopilot, heading, length, height, speed)
            for autopilot, heading, length, height, speed in zip(
                autopilots, (0.0, angle), lengths, heights, speeds, strict=True
            )
        ]
        yield CrossingPair((missions[0], missions[1]))


def _line(autopilot: str, heading: float, length: float, height: float, speed: float) -> Mission:
    """Return a flight along a line through the origin, from `length` [m] before it to 50 m beyond."""
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    home, middle, end = (_place(along * ahead) for along in (-length, -0.3 * length, 50.0))
    hold_s = 0.1 if autopilot == "px4" else 0.0  # PX4 may pass a waypoint at another height
    passed = [waypoint(place, height, hold_s) for place in (middle, end)]
    items = [takeoff(home, height), change_speed(speed), *passed, land(end)]
    return Mission(home, tuple(items), autopilot_named(autopilot))


def _place(point: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Geodetic:
    return replace(FRAME.geodetic(point), altitude=HOME.altitude)
