"""The RTL paths that the views show at the cursor."""

from typing import Any

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.forecast.contingencies import Contingencies, contingencies_of
from ipoa_mission.forecast.forecast import Forecast

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
