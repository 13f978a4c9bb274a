"""Estimate the time of a path: length / speed by direction, and each corner's cost, from simulated test courses."""

import math
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Matrix, Plane, Vector
from ipoa_mission.mission.items import Mission, change_speed, takeoff, waypoint
from ipoa_mission.survey._kernels import path_seconds
from ipoa_mission.wind import CALM, Wind

RIGHT_ANGLE = 4  # index in ANGLES
ANGLES = np.radians(90.0 / RIGHT_ANGLE * np.arange(2 * RIGHT_ANGLE + 1))
SHORT_LEGS_S = np.array([0.3, 1.0, 10 / 3])  # times at speed, of one ratio


class Ways(NamedTuple):
    """Straight ways; those of row n lead to `columns[begins[n] : begins[n + 1]]`."""

    lengths: Matrix  # or NO_WAY, (n, m) [m]
    begins: NDArray[np.int64]  # (n + 1,)
    columns: NDArray[np.int64]  # (k,)


class LegTimeTable(NamedTuple):
    pace: Vector  # by direction counterclockwise from east (d,) [s/m]; size 1: any
    corner: Matrix  # by angle from 0 to 180 degrees and shorter leg (angles, lengths) [s]
    shortest: float  # the first length [m]
    ratio: float  # natural logarithm of the ratio of successive lengths


@dataclass(frozen=True, eq=False)
class LegTimes:
    """Times at one speed [m/s] in one wind; `past_corners`: overshoot past 90 degrees [m]."""

    speed: float
    table: LegTimeTable
    past_corners: float

    @classmethod
    def of(cls, mission: Mission, speed: float, height: float = 30.0, wind: Wind = CALM) -> "LegTimes":
        """Return a vehicle's times at a `speed` of DO_CHANGE_SPEED [m/s] and a `height` above home [m]."""
        limits = mission.autopilot.part(FlightModel).kinematics(mission.parameters, speed)
        to_speed = limits.speed / limits.accel + (limits.accel / limits.jerk if math.isfinite(limits.jerk) else 0.0)
        long = 10.0 * to_speed * speed  # accelerating and braking lengths
        trial = _TrialFlight(mission, speed, height, wind)
        pace = _paces(trial, long)
        costs, past = _corners(trial, _stretches(SHORT_LEGS_S * speed, long), pace)
        alone, pairs = costs[: len(ANGLES) - 1], costs[len(ANGLES) - 1 :].reshape(-1, len(SHORT_LEGS_S)) / 2
        sharp = np.repeat(pairs[-1:], len(ANGLES) - len(pairs), axis=0)
        corner = np.column_stack([np.concatenate([pairs, sharp]), [0.0, *alone]])
        table = LegTimeTable(pace, np.ascontiguousarray(corner), float(SHORT_LEGS_S[0]) * speed, math.log(10 / 3))
        return cls(speed, table, float(past[-len(SHORT_LEGS_S) :].max()))

    def seconds(self, path: Plane) -> float:
        """Return the time of a polyline (n, 2), at speed at both ends [s]."""
        return float(path_seconds(self.table, np.ascontiguousarray(path, float)))


Stretch: TypeAlias = list[tuple[float, float]]  # bearings [rad] and lengths [m]


@dataclass(frozen=True, eq=False)
class _TrialFlight:
    mission: Mission
    speed: float
    height: float
    wind: Wind

    def fly(self, path: Plane) -> tuple[Vector, Track]:
        """Return when the places (n, 2) are done [s], and the track."""
        frame = LocalFrame(self.mission.home)
        latitude, longitude, altitude = frame.to_geodetic(np.column_stack([path, np.full(len(path), self.height)]))
        places = [Geodetic(*map(float, place)) for place in zip(latitude, longitude, altitude, strict=True)]
        waypoints = (waypoint(place, self.height) for place in places)
        items = (takeoff(places[0], self.height), change_speed(self.speed), *waypoints)
        flown = replace(self.mission, items=items, landing_ground=None)
        try:
            prediction = Forecast(flown, wind=self.wind).predicted(noise_free=True)
        except MissionError as error:
            words = f"no time is known of lines at {self.speed:g} m/s: {error}"
            raise MissionError(words, error.hint, code="unreachable", place="survey") from error
        return prediction.done[2:], prediction.track


def _stretches(lengths: Vector, long: float) -> list[Stretch]:
    """Return a corner of each angle, then pairs; sharper than 90 degrees, the time of a pair jumps as its leg grows."""
    stretches, bearing = list[Stretch](), 0.0
    for angle in map(float, ANGLES[1:]):
        stretches.append([(bearing, long / 2), (bearing + angle, long / 2)])
        bearing += angle
    for angle in map(float, ANGLES[: RIGHT_ANGLE + 1]):
        for length in map(float, lengths):
            stretches.append([(bearing, long / 2), (bearing + angle, length), (bearing + 2 * angle, long / 2)])
            bearing += 2 * angle
    return stretches


def _corners(trial: _TrialFlight, stretches: list[Stretch], pace: Vector) -> tuple[Vector, Vector]:
    """Return each stretch's time beyond its straight time (n,) [s], and the first overshoot [m]."""
    first, last = stretches[0][0], stretches[-1][-1]
    lead = [first] * 3  # to reach the speed
    path = _polyline(*np.array([*lead, *chain(*stretches), last]).T)
    ends = len(lead) + np.cumsum([0, *map(len, stretches)])
    corners = np.delete(path, ends, axis=0)
    done, track = trial.fly(corners)
    middles = np.flatnonzero(np.isin(np.arange(len(path)), ends)) - np.arange(len(ends)) - 1
    passed = [_passing(track, path[at], corners[n], done[n : n + 2]) for at, n in zip(ends, middles, strict=True)]
    table = LegTimeTable(pace, np.zeros((2, 2)), 1.0, 1.0)
    alone = [path_seconds(table, np.ascontiguousarray(path[a : b + 1])) for a, b in pairwise(ends)]
    legs = np.array([path[at + 1] - path[at] for at in ends[:-1]])
    ahead = legs / np.linalg.norm(legs, axis=1, keepdims=True)
    flown = [track.between(*times).points[:, :2] for times in pairwise(passed)]
    past = [((part - path[at + 1]) @ along).max() for part, at, along in zip(flown, ends[:-1], ahead, strict=True)]
    return np.maximum(np.diff(passed) - alone, 0.0), np.maximum(past, 0.0)


def _passing(track: Track, place: Vector, start: Vector, between: Vector) -> float:
    """Return when a place on the leg from `start` is passed [s]."""
    first, last = np.searchsorted(track.times, between)
    along = (track.points[first:last, :2] - start) @ (place - start)
    return float(np.interp((place - start) @ (place - start), np.maximum.accumulate(along), track.times[first:last]))


def _polyline(bearings: Vector, legs: Vector) -> Plane:
    steps = legs[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])


def _paces(trial: _TrialFlight, long: float) -> Vector:
    """Return seconds per meter by direction, counterclockwise from east; size 1 in still air."""
    if trial.wind.speed <= 0.0:
        return np.array([1.0 / trial.speed])
    count = 8
    bearings = 2 * math.pi * np.arange(count) / count
    path = _polyline(np.repeat(bearings, 2), np.full(2 * count, long))
    done, _ = trial.fly(np.concatenate([path, path[-1:] + path[1:2]]))
    return np.maximum(np.diff(done)[1::2][:count] / long, 1.0 / trial.speed)
