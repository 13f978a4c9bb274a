"""A mission in time: the expected place of its vehicle at each moment, and the uncertainty of time and place."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ipoa_mission import Forecast, MissionError
from ipoa_mission.forecast.deviation.law import DeviationLaw, law_of
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Points, Vector

Indices: TypeAlias = NDArray[np.intp]
STEP_S = 0.25  # between samples; the motion between them counts as straight
INTERVAL_DEVIATIONS = 1.645  # half of the 90 % interval of a forecast
DEPARTURE_DEVIATION_S = 1.0  # of the time between the command to start and the order of it


@dataclass(frozen=True, eq=False)
class TimedFlight:
    """The expected flight of one vehicle in the frame of all.

    `places` (n, 3): east, north, up [m], `STEP_S` apart, from the departure (arming) until it disarms. It is in the air
    from sample `lifts` to sample `lands`. `time_deviations` (n,): standard deviation of the time at each place [s].
    """

    name: str
    places: Points
    lifts: int
    lands: int
    time_deviations: Vector
    law: DeviationLaw | None  # None: parked
    departure_deviation_s: float = DEPARTURE_DEVIATION_S

    @cached_property
    def tree(self) -> cKDTree:
        return cKDTree(self.places)

    @cached_property
    def longest_step(self) -> float:
        return float(np.linalg.norm(np.diff(self.places, axis=0), axis=1).max(initial=0.0))

    def on_ground(self, samples: Indices) -> NDArray[np.bool_]:
        return np.asarray((samples <= self.lifts) | (samples >= self.lands))

    @property
    def duration_s(self) -> float:
        return STEP_S * (len(self.places) - 1)


def timed_flight(name: str, forecast: Forecast, frame: LocalFrame) -> TimedFlight:
    """Sample the expected flight of a forecast in another local frame.

    Raises:
        MissionError: the mission has no end, or its path or time is unknown.
    """
    forecast.expect_known_path()
    prediction = forecast.expected
    track = prediction.track.local()
    seconds = np.arange(0.0, track.times[-1] + STEP_S, STEP_S)
    sampled = track.without_repeated_times().at(seconds)
    moving = np.flatnonzero(np.linalg.norm(np.diff(sampled, axis=0), axis=1) > 1e-3)
    if len(moving) == 0:
        raise MissionError("the vehicle stays where it is", code="nothing-flown", place=name)
    half = (prediction.high - prediction.low) / 2
    latitude, longitude, altitude = forecast.frame.to_geodetic(sampled)
    return TimedFlight(
        name=name,
        places=frame.to_local(latitude, longitude, altitude),
        lifts=int(moving[0]),
        lands=int(moving[-1]) + 1,
        time_deviations=np.interp(seconds, prediction.done, half / INTERVAL_DEVIATIONS, left=0.0),
        law=law_of(forecast.mission.autopilot, forecast.wind.speed),
    )


def within_pad(away: Points) -> NDArray[np.bool_]:
    """Return whether two places on the ground, `away` (..., 3) [m], are one pad."""
    width = 2.0  # [m]
    return np.asarray(np.linalg.norm(away, axis=-1) < width)
