"""What each ending would do at this very second of a flight, from the forecast of all its seconds."""

import math
from functools import lru_cache

import numpy as np

from ipoa_mission.forecast.contingencies import Contingencies, ContingencyRow
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade
from ipoa_mission.geometry import Vector
from ipoa_mission.vehicles.contingency import Contingency

NEAR_S = 12.0  # so much earlier or later than before the vehicle may be where the forecast has it
LIKELY = 0.2  # of two times at which it comes by a place, one that is likelier by a second may be so far off [m]
EVERY_S = 10.0  # how long an ending takes is worked out as often, and lies between the two beside a moment
STEEP, NEAREST_S = 2.5, 1.0  # more often where it changes by so many seconds a second, but no more often than this [s]
NEAR = 8.0  # what is so much farther than required is nothing near [m]
TIMED = (Contingency.RTL, Contingency.LAND)  # the others do not end on the ground


class ContingenciesNow:
    """The endings of one forecast's flight that can be ordered, to be asked in flight.

    Raises:
        MissionError: the vehicle has no model of its flight.
    """

    def __init__(self, forecast: Forecast, ordered: tuple[Contingency, ...] = TIMED) -> None:
        self._endings = forecast.cached(Contingencies)
        self._rows = {one: self._endings.rows(one, timed=False) for one in ordered}
        self._lasts = lru_cache(maxsize=256)(self._endings.lasts)
        self._late_s = 0.0

    def at(self, time: float) -> tuple[tuple[ContingencyRow, float | None], ...]:
        """Of each ending its row and how many seconds it takes, at a time of the forecast [s]."""
        return tuple((row, self._seconds(row, time)) for row in map(self._row, self._rows, (time,) * len(self._rows)))

    def time_at(self, place: Vector, time: float) -> tuple[float, float]:
        """When it was to be where it is, at a place (3,) [m] so late [s], and how far from there that was to be [m].

        It is asked again and again while the vehicle flies: one that has come late is looked for as late as it was.
        """
        stops = self._endings.stops()
        expected = time - self._late_s
        near = np.flatnonzero(np.abs(stops.times - expected) <= NEAR_S)
        near = near if len(near) else np.array([np.abs(stops.times - expected).argmin()])
        apart = np.linalg.norm(stops.places[near] - place, axis=1)
        best = (apart + LIKELY * np.abs(stops.times[near] - expected)).argmin()
        found = float(stops.times[near][best])
        self._late_s = time - found
        return found, float(apart[best])

    def from_here(self, contingency: Contingency, place: Vector, velocity: Vector) -> ContingencyRow:
        """To hold or to land from where the vehicle is (3,) [m], at its velocity east and north (2,) [m/s]."""
        forecast, ways = self._endings.forecast, self._endings.ways
        autopilot, parameters = forecast.mission.autopilot, forecast.mission.parameters
        stand = place.copy()
        stand[:2] += autopilot.flies_on(contingency) * velocity
        stand[:2] += autopilot.braking_way(parameters, velocity[None, :], np.zeros((1, 2)), contingency)[0]
        ground = np.array([stand[0], stand[1], float(ways.roomy.airspace.ground(stand[None, :])[0])])
        path = np.array([place, stand] if contingency is Contingency.HOLD else [place, stand, ground])
        near = ways.roomy.airspace.obstacle_clearance(path, within=ways.required + NEAR)
        grade = Grade.CLEAR if near.distance >= ways.required else Grade.WOULD
        return ContingencyRow(contingency, 0.0, 0.0, grade, near.distance, ways.required, near.what, "here")

    def words(self, time: float) -> str:
        """The same in a line: "rtl clear, 2.13 m from mast, 62 s"."""
        told = ((f"{row.contingency} {row.keeps}", seconds) for row, seconds in self.at(time))
        return "; ".join(words if seconds is None else f"{words}, {seconds:.0f} s" for words, seconds in told)

    def _row(self, contingency: Contingency, time: float) -> ContingencyRow:
        return next((row for row in self._rows[contingency] if time < row.to_s), self._rows[contingency][-1])

    def _seconds(self, row: ContingencyRow, time: float) -> float | None:
        if row.contingency not in TIMED:
            return None
        begin = EVERY_S * math.floor(time / EVERY_S)
        end = begin + EVERY_S
        while True:
            times = np.clip([begin, end], *self._endings.ways.in_air)
            lasts = {
                at: sum(both) / 2 for at in times.tolist() if (both := self._lasts(row.contingency, at)) is not None
            }
            middle, took = (begin + end) / 2, list(lasts.values())
            if end - begin <= NEAREST_S or len(took) < 2 or abs(took[1] - took[0]) < STEEP * (end - begin):
                return float(np.interp(time, [*lasts], took)) if lasts else None
            begin, end = (begin, middle) if time < middle else (middle, end)
