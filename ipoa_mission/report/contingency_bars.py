from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ipoa_mission.forecast.contingencies import Contingencies, ContingencyBar, ContingencyRow, bars_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade
from ipoa_mission.report.seen import Seen

GradeLook: TypeAlias = Literal["clear", "perhaps", "not clear", "unknown"]
LOOK: dict[Grade, GradeLook] = {
    Grade.CLEAR: "clear",
    Grade.MAY: "perhaps",
    Grade.WOULD: "not clear",
    Grade.UNKNOWN: "unknown",
}


class ContingencyStretch(NamedTuple):
    """Distances over ground [m]."""

    row: ContingencyRow
    begins: float
    ends: float

    @property
    def look(self) -> GradeLook:
        return LOOK[self.row.grade]


def contingency_bars(forecast: Forecast) -> tuple[ContingencyBar, ...]:
    """Return no bars without a forecast."""
    if forecast.promise_if_known is None:
        return ()
    return bars_of(forecast.cached(Contingencies).all_rows(timed=False))


def stretches(bar: ContingencyBar, course: Seen) -> tuple[ContingencyStretch, ...]:
    """Rows at a standstill have no length."""
    edges = np.interp([(row.from_s, row.to_s) for row in bar.rows], course.times, course.along).tolist()
    return tuple(ContingencyStretch(row, *between) for row, between in zip(bar.rows, edges, strict=True))
