"""Where a flight would come to a stand if it were broken off: after it has flown on for a moment, and braked."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.vehicles.autopilot import STATIONARY_SPEED
from ipoa_mission.vehicles.contingency import Contingency

LOOK_EVERY_S = 0.2  # between the places at which the vehicle may be when its flight is broken off [s]


@dataclass(frozen=True, eq=False)
class StoppingPoints:
    """Where the vehicle is (n, 3) at `times` (n,) [s], on its way to items `seqs` (n,), and where it stands then."""

    times: Vector
    places: Points
    stands: Points
    seqs: NDArray[np.intp]

    def seqs_at(self, times: Vector) -> NDArray[np.intp]:
        """On its way to which items it is at these times (n,)."""
        return np.asarray(self.seqs[np.clip(np.searchsorted(self.times, times), 0, len(self.seqs) - 1)])

    def at(self, times: Vector) -> tuple[Points, Points]:
        """Where it is at any times (n,) from the first to the last, and where it stands then, each (n, 3) [m]."""
        places, stands = (
            np.column_stack([np.interp(times, self.times, axis) for axis in points.T])
            for points in (self.places, self.stands)
        )
        return places, stands


def stopping_points_of(
    forecast: Forecast, begin: float | None = None, end: float | None = None, contingency: Contingency = Contingency.RTL
) -> StoppingPoints:
    """From one time to another [s], at the end of which it stands; left out, from the take-off to the last waypoint."""
    mission, flight = forecast.mission, forecast.promise.flight
    autopilot = mission.autopilot
    begin, end = flight.way[0] if begin is None else begin, flight.way[1] if end is None else end
    times = np.append(np.arange(begin, end, LOOK_EVERY_S), end)
    then = np.minimum(times + autopilot.flies_on(contingency), end)
    before, places, stands, after = map(flight.pieces.at, (then - LOOK_EVERY_S, times, then, then + LOOK_EVERY_S))
    velocity = (after - before) / (2 * LOOK_EVERY_S)
    speed = np.maximum(np.hypot(*velocity[:, :2].T), STATIONARY_SPEED)
    along = velocity[:, :2] / speed[:, None]
    gains = np.gradient(np.hypot(*velocity[:, :2].T), LOOK_EVERY_S) if len(times) > 1 else np.zeros(1)
    accel = (after[:, :2] + before[:, :2] - 2 * stands[:, :2]) / LOOK_EVERY_S**2
    del before, after  # of many hours they are large
    accel += along * (gains - (accel * along).sum(axis=1))[:, None]
    if not autopilot.guidance.climb_ends_at_once:  # else it stops its climb by itself, within half a meter
        way = autopilot.braking_distance(mission.parameters, np.hypot(*velocity[:, :2].T), gains)
        stands[:, 2] += velocity[:, 2] * way / speed
    stands[:, :2] += autopilot.braking_way(mission.parameters, velocity[:, :2], accel, contingency)
    seqs = np.array([visit.seq for visit in flight.route.visits])
    return StoppingPoints(
        times, places, stands, seqs[np.minimum(np.searchsorted(flight.prediction.done, times), len(seqs) - 1)]
    )
