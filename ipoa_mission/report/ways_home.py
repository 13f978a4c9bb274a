"""The RTL paths that the views show at the cursor."""

from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.forecast.contingency.contingencies import (
    Contingencies,
    ContingencyBar,
    ContingencyRow,
    bars_of,
    contingencies_of,
)
from ipoa_mission.forecast.contingency.grades import Grade
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.seen import Seen

MAX_WAYS = 150  # each four seconds of ten minutes
DECIMALS = 2


def ways_home(forecast: Forecast) -> list[dict[str, Any]]:
    """Return `from` [s], `clear` and `points` (n, 3) [m], in time order; the first of several returns."""
    if forecast.promise_if_known is None or Contingency.RTL not in contingencies_of(forecast):
        return []
    contingencies = forecast.cached(Contingencies)
    if contingencies.ways.why_unknown() is not None:
        return []
    assessments = contingencies.assessments(Contingency.RTL)
    shown = np.unique(
        np.linspace(0, len(assessments.times) - 1, min(MAX_WAYS, len(assessments.times))).round().astype(int)
    )
    return [
        {
            "from": round(float(assessments.times[n]), DECIMALS),
            "clear": bool(assessments.clear[n]),
            "points": assessments.ways[n][assessments.taken[n]][0].round(DECIMALS).tolist(),
        }
        for n in shown
        if assessments.taken[n].any()
    ]


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
