"""Compute the strip of contingencies below a height profile: a bar of each, and the place of each row."""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ipoa_mission.forecast.contingencies import Contingencies, ContingencyBar, ContingencyRow, bars_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade
from ipoa_mission.report.seen import Seen

#: Style and label of a row.
GradeLook: TypeAlias = Literal["clear", "perhaps", "not clear", "unknown"]
LOOK: dict[Grade, GradeLook] = {
    Grade.CLEAR: "clear",
    Grade.MAY: "perhaps",
    Grade.WOULD: "not clear",
    Grade.UNKNOWN: "unknown",
}


class ContingencyStretch(NamedTuple):
    """A row of a contingency, and the distances over ground [m] between which the vehicle is then."""

    row: ContingencyRow
    begins: float
    ends: float

    @property
    def look(self) -> GradeLook:
        return LOOK[self.row.grade]


def contingency_bars(forecast: Forecast) -> tuple[ContingencyBar, ...]:
    """Return a bar for each contingency of the vehicle, or none if the flight has no forecast."""
    if forecast.promise_if_known is None:
        return ()
    return bars_of(forecast.cached(Contingencies).all_rows(timed=False))


def stretches(bar: ContingencyBar, course: Seen) -> tuple[ContingencyStretch, ...]:
    """Return the stretches of its rows in time order; rows at a standstill have no length."""
    edges = np.interp([(row.from_s, row.to_s) for row in bar.rows], course.times, course.along).tolist()
    return tuple(ContingencyStretch(row, *between) for row, between in zip(bar.rows, edges, strict=True))
