"""A leg takes length / speed; braking, turning and accelerating count at corners."""

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
RATIO = 10 / 3
LONG_LEG = 10.0  # accelerating and braking lengths
BEARINGS = 8


@dataclass(frozen=True, eq=False)
class LegTimes:
    """Times at one speed [m/s] in one wind; `past_corners`: overshoot past 90 degrees [m].

    Example:
        >>> from ipoa_mission.autopilot.autopilot import default_autopilot
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
        """Return a vehicle's times at a `speed` of DO_CHANGE_SPEED [m/s] and a `height` above home [m]. Raises
        MissionError.
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
        """Return the time of a polyline (n, 2), at speed at both ends [s]."""
        return float(path_seconds(self.clock, np.ascontiguousarray(path, float)))


Stretch: TypeAlias = list[tuple[float, float]]  # bearings [rad] and lengths [m]


def _stretches(lengths: Vector, long: float) -> list[Stretch]:
    """Return a corner of each angle, then pairs; sharper than 90 degrees, the time of a pair jumps as its leg grows."""
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
    """Return each stretch's time beyond its straight time (n,) [s], and the first overshoot [m]."""
    first, last = stretches[0][0], stretches[-1][-1]
    lead = [first] * 3  # to reach the speed
    path = _polyline(*np.array([*lead, *chain(*stretches), last]).T)
    ends = len(lead) + np.cumsum([0, *map(len, stretches)])
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
    """Return when a place on the leg from `start` is passed [s]."""
    first, last = np.searchsorted(track.times, between)
    along = (track.points[first:last, :2] - start) @ (place - start)
    return float(np.interp((place - start) @ (place - start), np.maximum.accumulate(along), track.times[first:last]))


def _polyline(bearings: Vector, legs: Vector) -> Points:
    steps = legs[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])


def _flown(mission: Mission, speed: float, height: float, wind: Wind, path: Points) -> tuple[Vector, Track]:
    """Return when the places (n, 2) are done [s], and the track."""
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
