"""Compute the times of straight legs and of the corners between them from a vehicle's own time model.

A leg takes its length over the requested speed. The cost of braking, turning and accelerating is counted at its
corners, by the angle and by the shorter of the two legs. The time model flies a few corners in one mission; other
corners are interpolated.
"""

import math
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import TypeAlias

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission, change_speed, takeoff, waypoint
from ipoa_mission.survey._kernels import path_seconds
from ipoa_mission.survey.clock import Clock
from ipoa_mission.wind import CALM, Wind
from ipoa_mission.world.frame import Geodetic, LocalFrame

RIGHT_ANGLE = 4  # index in ANGLES
ANGLES = np.radians(90.0 / RIGHT_ANGLE * np.arange(2 * RIGHT_ANGLE + 1))
SHORT_LEGS_S = np.array([0.3, 1.0, 10 / 3])  # times at speed
RATIO = 10 / 3  # of successive lengths
LONG_LEG = 10.0  # in lengths of accelerating and braking
BEARINGS = 8  # of legs in wind


@dataclass(frozen=True, eq=False)
class LegTimes:
    """Seconds of legs and corners of one vehicle at one speed, in one wind.

    Attributes:
        speed: requested [m/s].
        clock: the times as the kernels take them.
        past_corners: overshoot past a corner of 90 degrees [m].

    Example:
        >>> from ipoa_mission.vehicles.autopilot import default_autopilot
        >>> from ipoa_mission.world.frame import Geodetic
        >>> times = LegTimes.of(Mission(Geodetic(47.4, 8.5, 488.0), (), default_autopilot()), 5.0)
        >>> there, back = np.array([[0.0, 0.0], [90.0, 0.0]]), np.array([[90.0, 0.0], [0.0, 0.0]])
        >>> times.seconds(there), times.seconds(np.concatenate([there, back])) > 36.0
        (18.0, True)
    """

    speed: float
    clock: Clock
    past_corners: float

    @classmethod
    def of(cls, mission: Mission, speed: float, height: float = 30.0, wind: Wind = CALM) -> "LegTimes":
        """Return the times of a mission's vehicle: its home, autopilot, parameters and learned values.

        Args:
            mission: of the vehicle; its items do not matter.
            speed: of DO_CHANGE_SPEED [m/s].
            height: above home [m].
            wind: of the flight.

        Raises:
            MissionError: the vehicle has no time model, or cannot fly against this wind.
        """
        limits = mission.autopilot.part(FlightModel).kinematics(mission.parameters, speed)
        to_speed = limits.speed / limits.accel + (limits.accel / limits.jerk if math.isfinite(limits.jerk) else 0.0)
        long = LONG_LEG * to_speed * speed
        pace = _paces(mission, speed, height, wind, long)
        stretches = _stretches(SHORT_LEGS_S * speed, long)
        costs, past = _corners(mission, speed, height, wind, stretches, pace)
        alone, pairs = costs[: len(ANGLES) - 1], costs[len(ANGLES) - 1 :].reshape(-1, len(SHORT_LEGS_S)) / 2
        sharp = np.repeat(pairs[-1:], len(ANGLES) - len(pairs), axis=0)
        corner = np.column_stack([np.concatenate([pairs, sharp]), [0.0, *alone]])
        clock = Clock(pace, np.ascontiguousarray(corner), float(SHORT_LEGS_S[0]) * speed, math.log(RATIO))
        return cls(speed, clock, float(past[-len(SHORT_LEGS_S) :].max()))

    def seconds(self, path: Points) -> float:
        """Return the time of a polyline (n, 2) with its corners, at speed at both ends [s]."""
        return float(path_seconds(self.clock, np.ascontiguousarray(path, float)))


Stretch: TypeAlias = list[tuple[float, float]]  # bearings [rad] and lengths [m]


def _stretches(lengths: Vector, long: float) -> list[Stretch]:
    """Return stretches from the middle of one long leg to that of the next: one corner of each angle, then pairs.

    A pair of corners has a short leg between. Pairs turn by right angles at most: at sharper ones the flown time jumps
    as the leg grows.
    """
    found, bearing = list[Stretch](), 0.0
    for angle in map(float, ANGLES[1:]):
        found.append([(bearing, long / 2), (bearing + angle, long / 2)])
        bearing += angle
    for angle in map(float, ANGLES[: RIGHT_ANGLE + 1]):
        for length in map(float, lengths):
            found.append([(bearing, long / 2), (bearing + angle, length), (bearing + 2 * angle, long / 2)])
            bearing += 2 * angle
    return found


def _corners(
    mission: Mission, speed: float, height: float, wind: Wind, stretches: list[Stretch], pace: Vector
) -> tuple[Vector, Vector]:
    """Return the time of each stretch beyond its straight time (n,) [s], and its overshoot past its first corner [m].

    All stretches are flown in one mission.
    """
    first, last = stretches[0][0], stretches[-1][-1]
    lead = [first] * 3  # to reach the speed
    path = _polyline(*np.array([*lead, *chain(*stretches), last]).T)
    ends = len(lead) + np.cumsum([0, *map(len, stretches)])  # in the middle of long legs
    corners = np.delete(path, ends, axis=0)
    done, track = _flown(mission, speed, height, wind, corners)
    middles = np.flatnonzero(np.isin(np.arange(len(path)), ends)) - np.arange(len(ends)) - 1
    passed = [_passing(track, path[at], corners[n], done[n : n + 2]) for at, n in zip(ends, middles, strict=True)]
    clock = Clock(pace, np.zeros((2, 2)), 1.0, 1.0)
    alone = [path_seconds(clock, np.ascontiguousarray(path[a : b + 1])) for a, b in pairwise(ends)]
    legs = np.array([path[at + 1] - path[at] for at in ends[:-1]])
    ahead = legs / np.linalg.norm(legs, axis=1, keepdims=True)
    ways = [track.between(*times).points[:, :2] for times in pairwise(passed)]
    past = [((way - path[at + 1]) @ along).max() for way, at, along in zip(ways, ends[:-1], ahead, strict=True)]
    return np.maximum(np.diff(passed) - alone, 0.0), np.maximum(past, 0.0)


def _passing(track: Track, place: Vector, start: Vector, between: Vector) -> float:
    """Return when a place on the leg from `start` is passed, between two times [s]."""
    first, last = np.searchsorted(track.times, between)
    along = (track.points[first:last, :2] - start) @ (place - start)
    return float(np.interp((place - start) @ (place - start), np.maximum.accumulate(along), track.times[first:last]))


def _polyline(bearings: Vector, legs: Vector) -> Points:
    steps = legs[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])


def _flown(mission: Mission, speed: float, height: float, wind: Wind, path: Points) -> tuple[Vector, Track]:
    """Return the time at which each place of a path (n, 2) is done [s], and the flown track."""
    frame = LocalFrame(mission.home)
    latitude, longitude, altitude = frame.to_geodetic(np.column_stack([path, np.full(len(path), height)]))
    places = [Geodetic(*map(float, place)) for place in zip(latitude, longitude, altitude, strict=True)]
    items = (takeoff(places[0], height), change_speed(speed), *(waypoint(place, height) for place in places))
    flown = replace(mission, items=items, landing_ground=None, scanned=())
    try:
        prediction = Forecast(flown, wind=wind).predicted(sure=True)
    except MissionError as error:
        words = f"no time is known of lines at {speed:g} m/s: {error}"
        raise MissionError(words, error.hint, code="unreachable", place="survey") from error
    return prediction.done[2:], prediction.track


def _paces(mission: Mission, speed: float, height: float, wind: Wind, long: float) -> Vector:
    """Return seconds per meter by direction, counterclockwise from east; size 1 in still air."""
    if wind.speed <= 0.0:
        return np.array([1.0 / speed])
    bearings = 2 * math.pi * np.arange(BEARINGS) / BEARINGS
    path = _polyline(np.repeat(bearings, 2), np.full(2 * BEARINGS, long))
    done, _ = _flown(mission, speed, height, wind, np.concatenate([path, path[-1:] + path[1:2]]))
    return np.maximum(np.diff(done)[1::2][:BEARINGS] / long, 1.0 / speed)
