import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from ipoa_mission.autopilot.failsafe import TIMED, Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow, Grade
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class DurationSampling:
    """Steps are halved where a duration changes faster than `max_slope` [s/s]."""

    step_s: float = 10.0
    min_step_s: float = 1.0
    max_slope: float = 2.5


DURATIONS = DurationSampling()


class ContingenciesNow:
    """Contingencies from a vehicle in flight; none is forecast `off_path` [m] away."""

    off_path: ClassVar = 10.0

    def __init__(self, forecast: Forecast, ordered: tuple[Contingency, ...] = TIMED) -> None:
        self._contingencies = forecast.cached(Contingencies)
        self._rows = {contingency: self._contingencies.rows(contingency, timed=False) for contingency in ordered}
        self._predicted = lru_cache(maxsize=256)(self._contingencies.predicted)
        self._late_s = 0.0

    def at(self, time: float) -> tuple[tuple[ContingencyRow, float | None], ...]:
        return tuple((row, self._seconds(row, time)) for row in map(self._row, self._rows, (time,) * len(self._rows)))

    def time_at(self, place: Vector, time: float) -> tuple[float, float]:
        """Return the forecast time [s] of a place (3,) reached at `time` [s], and its distance to the forecast [m]."""
        stops = self._contingencies.stops()
        off = np.abs(stops.times - (time - self._late_s))
        near = np.flatnonzero(off <= 12.0)  # [s]
        near = near if len(near) else np.array([off.argmin()])
        apart = np.linalg.norm(stops.places[near] - place, axis=1)
        best = (apart + 0.2 * off[near]).argmin()  # [m/s]: prefers the last delay
        reached = float(stops.times[near][best])
        self._late_s = time - reached
        return reached, float(apart[best])

    def from_here(self, contingency: Contingency, place: Vector, velocity: Vector) -> ContingencyRow:
        """Return a hold or LAND from a place and a velocity (3,)."""
        paths = self._contingencies.paths
        mission = self._contingencies.forecast.mission
        autopilot = mission.autopilot
        stop = place + autopilot.braking_delay_s(contingency) * velocity
        stop += autopilot.stopping_displacement(mission.parameters, velocity[None, :], np.zeros((1, 3)), contingency)[0]
        farthest = place + autopilot.farthest_landing(mission.parameters, velocity[None, :])
        (ways,) = paths.in_place(contingency, place[None, :], stop[None, :], farthest)
        clearances = (paths.enlarged.obstacle_clearance(way, within=paths.required + 8.0) for way in ways)  # [m]
        near = min(clearances, key=lambda clearance: clearance.distance)
        grade = Grade.CLEAR if near.distance >= paths.required else Grade.UNCLEAR
        return ContingencyRow(contingency, 0.0, 0.0, grade, near.distance, paths.required, near.what, "here")

    def words(self, time: float) -> str:
        """For example: "rtl clear, 2.13 m from mast, 62 s"."""
        texts = ((f"{row.contingency} {row.keeps}", seconds) for row, seconds in self.at(time))
        return "; ".join(words if seconds is None else f"{words}, {seconds:.0f} s" for words, seconds in texts)

    def _row(self, contingency: Contingency, time: float) -> ContingencyRow:
        return next((row for row in self._rows[contingency] if time < row.to_s), self._rows[contingency][-1])

    def _seconds(self, row: ContingencyRow, time: float) -> float | None:
        if row.contingency not in TIMED:
            return None
        begin = DURATIONS.step_s * math.floor(time / DURATIONS.step_s)
        end = begin + DURATIONS.step_s
        while True:
            times = np.clip([begin, end], *self._contingencies.paths.in_air)
            predicted = ((t, self._predicted(row.contingency, t)) for t in times.tolist())
            lasts = {t: each.likely_s for t, each in predicted if each is not None}
            middle = (begin + end) / 2
            took = list(lasts.values())
            step_s = end - begin
            if step_s <= DURATIONS.min_step_s or len(took) < 2 or abs(took[1] - took[0]) < DURATIONS.max_slope * step_s:
                return float(np.interp(time, [*lasts], took)) if lasts else None
            begin, end = (begin, middle) if time < middle else (middle, end)
