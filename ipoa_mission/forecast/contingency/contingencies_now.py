import math
from functools import lru_cache

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow
from ipoa_mission.forecast.contingency.grades import Grade
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Vector

DELAY_CHANGE_S = 12.0  # change between two calls [s]
DELAY_PENALTY = 0.2  # of a time farther from the expected one [m/s]
STEP_S = 10.0  # [s]; durations are interpolated between them
MAX_SLOPE, MIN_STEP_S = 2.5, 1.0  # of a duration [s/s]; [s]
NEAR_DISTANCE = 8.0  # nothing near beyond the required distance and this [m]
TIMED = (Contingency.RTL, Contingency.LAND)  # the others do not end on the ground


class ContingenciesNow:
    """The contingencies that can be ordered, in flight.

    Raises:
        MissionError: the vehicle has no model of its flight.
    """

    def __init__(self, forecast: Forecast, ordered: tuple[Contingency, ...] = TIMED) -> None:
        self._endings = forecast.cached(Contingencies)
        self._rows = {one: self._endings.rows(one, timed=False) for one in ordered}
        self._lasts = lru_cache(maxsize=256)(self._endings.lasts)
        self._late_s = 0.0

    def at(self, time: float) -> tuple[tuple[ContingencyRow, float | None], ...]:
        """Return row and duration [s] of each contingency, at a time of the forecast [s]."""
        return tuple((row, self._seconds(row, time)) for row in map(self._row, self._rows, (time,) * len(self._rows)))

    def time_at(self, place: Vector, time: float) -> tuple[float, float]:
        """Return the forecast time [s] of a place (3,) reached at `time` [s], and its distance to the forecast [m]."""
        stops = self._endings.stops()
        expected = time - self._late_s
        near = np.flatnonzero(np.abs(stops.times - expected) <= DELAY_CHANGE_S)
        near = near if len(near) else np.array([np.abs(stops.times - expected).argmin()])
        apart = np.linalg.norm(stops.places[near] - place, axis=1)
        best = (apart + DELAY_PENALTY * np.abs(stops.times[near] - expected)).argmin()
        found = float(stops.times[near][best])
        self._late_s = time - found
        return found, float(apart[best])

    def from_here(self, contingency: Contingency, place: Vector, velocity: Vector) -> ContingencyRow:
        forecast, ways = self._endings.forecast, self._endings.ways
        autopilot, parameters = forecast.mission.autopilot, forecast.mission.parameters
        stop = place.copy()
        stop[:2] += autopilot.flies_on(contingency) * velocity
        stop[:2] += autopilot.braking_way(parameters, velocity[None, :], np.zeros((1, 2)), contingency)[0]
        ground = np.array([stop[0], stop[1], float(ways.roomy.airspace.ground(stop[None, :])[0])])
        path = np.array([place, stop] if contingency is Contingency.HOLD else [place, stop, ground])
        near = ways.roomy.airspace.obstacle_clearance(path, within=ways.required + NEAR_DISTANCE)
        grade = Grade.CLEAR if near.distance >= ways.required else Grade.WOULD
        return ContingencyRow(contingency, 0.0, 0.0, grade, near.distance, ways.required, near.what, "here")

    def words(self, time: float) -> str:
        """For example: "rtl clear, 2.13 m from mast, 62 s"."""
        texts = ((f"{row.contingency} {row.keeps}", seconds) for row, seconds in self.at(time))
        return "; ".join(words if seconds is None else f"{words}, {seconds:.0f} s" for words, seconds in texts)

    def _row(self, contingency: Contingency, time: float) -> ContingencyRow:
        return next((row for row in self._rows[contingency] if time < row.to_s), self._rows[contingency][-1])

    def _seconds(self, row: ContingencyRow, time: float) -> float | None:
        if row.contingency not in TIMED:
            return None
        begin = STEP_S * math.floor(time / STEP_S)
        end = begin + STEP_S
        while True:
            times = np.clip([begin, end], *self._endings.ways.in_air)
            lasts = {
                at: sum(both) / 2 for at in times.tolist() if (both := self._lasts(row.contingency, at)) is not None
            }
            middle, took = (begin + end) / 2, list(lasts.values())
            if end - begin <= MIN_STEP_S or len(took) < 2 or abs(took[1] - took[0]) < MAX_SLOPE * (end - begin):
                return float(np.interp(time, [*lasts], took)) if lasts else None
            begin, end = (begin, middle) if time < middle else (middle, end)
