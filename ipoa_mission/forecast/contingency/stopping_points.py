from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import STATIONARY_SPEED
from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points, Vector

STEP_S = 0.2  # [s]


@dataclass(frozen=True, eq=False)
class StoppingPoints:
    """Places (n, 3) at `times` (n,) [s] on the way to items `seqs`, and the stopping points `stops`."""

    times: Vector
    places: Points
    stops: Points
    seqs: NDArray[np.intp]

    def seqs_at(self, times: Vector) -> NDArray[np.intp]:
        return np.asarray(self.seqs[np.clip(np.searchsorted(self.times, times), 0, len(self.seqs) - 1)])

    def at(self, times: Vector) -> tuple[Points, Points]:
        places, stops = (
            np.column_stack([np.interp(times, self.times, axis) for axis in points.T])
            for points in (self.places, self.stops)
        )
        return places, stops


def stopping_points_of(
    forecast: Forecast, begin: float | None = None, end: float | None = None, contingency: Contingency = Contingency.RTL
) -> StoppingPoints:
    """Return the stopping points between two times [s], by default on the way."""
    mission, flight = forecast.mission, forecast.promise.flight
    autopilot = mission.autopilot
    begin, end = flight.way[0] if begin is None else begin, flight.way[1] if end is None else end
    times = np.append(np.arange(begin, end, STEP_S), end)
    then = np.minimum(times + autopilot.flies_on(contingency), end)
    before, places, stops, after = map(flight.pieces.at, (then - STEP_S, times, then, then + STEP_S))
    velocity = (after - before) / (2 * STEP_S)
    speed = np.maximum(np.hypot(*velocity[:, :2].T), STATIONARY_SPEED)
    along = velocity[:, :2] / speed[:, None]
    gains = np.gradient(np.hypot(*velocity[:, :2].T), STEP_S) if len(times) > 1 else np.zeros(1)
    accel = (after[:, :2] + before[:, :2] - 2 * stops[:, :2]) / STEP_S**2
    del before, after
    accel += along * (gains - (accel * along).sum(axis=1))[:, None]
    if not autopilot.guidance.climb_ends_at_once:  # else it stops within 0.5 m
        way = autopilot.braking_distance(mission.parameters, np.hypot(*velocity[:, :2].T), gains)
        stops[:, 2] += velocity[:, 2] * way / speed
    stops[:, :2] += autopilot.braking_way(mission.parameters, velocity[:, :2], accel, contingency)
    seqs = np.array([visit.seq for visit in flight.route.visits])
    return StoppingPoints(
        times, places, stops, seqs[np.minimum(np.searchsorted(flight.prediction.done, times), len(seqs) - 1)]
    )
