"""The ways home that the views show with the cursor: where RTL would fly if it were ordered at that moment."""

from typing import Any

import numpy as np

from ipoa_mission.forecast.contingencies import Contingencies, contingencies_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.vehicles.contingency import Contingency

MOST = 150  # ways that a page holds: a flight of ten minutes has one for each four seconds
CENTIMETERS = 2


def ways_home(forecast: Forecast) -> list[dict[str, Any]]:
    """For moments of the flight, in their order: `from` when [s], whether it is `clear`, and its `points` (n, 3) [m].

    None where the vehicle has no such ending, or nobody knows where it leads. Of several ways that a return may take
    the first is shown.
    """
    if forecast.promise_if_known is None or Contingency.RTL not in contingencies_of(forecast):
        return []
    contingencies = forecast.cached(Contingencies)
    if contingencies.ways.why_unknown() is not None:
        return []
    assessments = contingencies.assessments(Contingency.RTL)
    shown = np.unique(np.linspace(0, len(assessments.times) - 1, min(MOST, len(assessments.times))).round().astype(int))
    return [
        {
            "from": round(float(assessments.times[n]), CENTIMETERS),
            "clear": bool(assessments.clear[n]),
            "points": assessments.ways[n][assessments.taken[n]][0].round(CENTIMETERS).tolist(),
        }
        for n in shown
        if assessments.taken[n].any()
    ]
