"""What each ending would do at this very second of a flight, from the forecast of all its seconds."""

import math
from functools import lru_cache

import numpy as np

from ipoa_mission.forecast.endings import EndingRow, Endings, endings_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Vector
from ipoa_mission.vehicles.ending import Ending

NEAR_S = 12.0  # so early or late the vehicle may be where the forecast has it
EVERY_S = 10.0  # how long an ending takes is worked out as often, and lies between the two beside a moment
ORDERED = (Ending.RTL, Ending.LAND)


class EndingsNow:
    """The endings of one forecast's flight that can be ordered, to be asked in flight.

    Raises:
        MissionError: the vehicle has no model of its flight.
    """

    def __init__(self, forecast: Forecast) -> None:
        self._endings = forecast.once(Endings)
        self._rows = {one: self._endings.rows(one, timed=False) for one in endings_of(forecast) if one in ORDERED}
        self._lasts = lru_cache(maxsize=256)(self._endings.lasts)

    def at(self, place: Vector, time: float) -> tuple[tuple[EndingRow, float | None], ...]:
        """Of each ending its row and how many seconds it takes, for who is at a place (3,) [m] so late [s]."""
        time = self.time_at(place, time)
        return tuple((row, self._seconds(row, time)) for row in map(self._row, self._rows, (time,) * len(self._rows)))

    def time_at(self, place: Vector, time: float) -> float:
        """When it was to be where it is, at a place (3,) [m] so late [s]."""
        stops = self._endings.stops()
        near = np.flatnonzero(np.abs(stops.times - time) <= NEAR_S)
        if len(near):
            time = float(stops.times[near][np.linalg.norm(stops.places[near] - place, axis=1).argmin()])
        return time

    def words(self, place: Vector, time: float) -> str:
        """The same in a line: "rtl clear, 2.13 m from mast, 62 s"."""
        told = ((f"{row.ending} {row.keeps}", seconds) for row, seconds in self.at(place, time))
        return "; ".join(words if seconds is None else f"{words}, {seconds:.0f} s" for words, seconds in told)

    def _row(self, ending: Ending, time: float) -> EndingRow:
        return next((row for row in self._rows[ending] if time < row.to_s), self._rows[ending][-1])

    def _seconds(self, row: EndingRow, time: float) -> float | None:
        before = EVERY_S * math.floor(time / EVERY_S)
        times = np.clip([before, before + EVERY_S], *self._endings.ways.in_air)
        lasts = {at: sum(both) / 2 for at in times.tolist() if (both := self._lasts(row.ending, at)) is not None}
        return float(np.interp(time, [*lasts], [*lasts.values()])) if lasts else None
