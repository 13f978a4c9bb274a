"""Check the landings of failsafes that could return instead, from the middle of a mission."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.checks.failsafe_return import in_words
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.contingencies import lands_by_choice, to_return_instead, who_lands
from ipoa_mission.forecast.contingency_paths import GROUND, ContingencyPaths
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.planning.proof import Check
from ipoa_mission.vehicles.contingency import Contingency


def check_failsafe_landing(forecast: Forecast) -> Iterator[Finding]:
    """Warn where such a landing would come down on something, or too near to it.

    Failsafes that can only land (without a position no return is possible) are reported by `check --endings` only.
    """
    if not forecast.mission.items or not lands_by_choice(forecast):
        return
    ways = forecast.cached(ContingencyPaths)
    if len(ways.stops().times) < 2:
        return
    assessments = ways.assessments(Contingency.LAND)
    unclear = np.flatnonzero(((assessments.near < ways.required) & (assessments.which != GROUND)).any(axis=(1, 2)))
    if len(unclear):
        seqs = np.unique(ways.stops().seqs_at(assessments.times[unclear]))
        worst = unclear[np.argmin(assessments.spare[unclear])]
        kept = Check("obstacles", ways.exactly(Contingency.LAND, assessments, int(worst)), ways.required)
        words = f"{in_words(seqs.tolist())}: LAND on the way there, by {who_lands(forecast)}, descends {kept.words()}"
        yield Finding("land-too-near", Severity.WARNING, int(seqs[0]), words, to_return_instead(forecast))
