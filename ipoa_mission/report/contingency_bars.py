"""What a strip of endings under a height profile shows: a bar of each, and where on the way each of its rows lies."""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ipoa_mission.forecast.contingencies import Contingencies, ContingencyBar, ContingencyRow, bars_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade
from ipoa_mission.report.seen import Seen

#: How a row looks, and the words on it.
GradeLook: TypeAlias = Literal["clear", "perhaps", "not clear", "unknown"]
LOOK: dict[Grade, GradeLook] = {
    Grade.CLEAR: "clear",
    Grade.MAY: "perhaps",
    Grade.WOULD: "not clear",
    Grade.UNKNOWN: "unknown",
}


class ContingencyStretch(NamedTuple):
    """A row of an ending, and between which distances over ground [m] the vehicle is then."""

    row: ContingencyRow
    begins: float
    ends: float

    @property
    def look(self) -> GradeLook:
        """How it looks."""
        return LOOK[self.row.grade]


def ending_bars(forecast: Forecast) -> tuple[ContingencyBar, ...]:
    """A bar for each ending that the vehicle has; none where nobody can say how it will be flown."""
    if forecast.promise_if_known is None:
        return ()
    return bars_of(forecast.cached(Contingencies).all_rows(timed=False))


def stretches(bar: ContingencyBar, course: Seen) -> tuple[ContingencyStretch, ...]:
    """Where its rows lie, in the order of their times; on the spot some have no length."""
    edges = np.interp([(row.from_s, row.to_s) for row in bar.rows], course.times, course.along).tolist()
    return tuple(ContingencyStretch(row, *between) for row, between in zip(bar.rows, edges, strict=True))
