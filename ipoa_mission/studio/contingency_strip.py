import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyBar
from ipoa_mission.forecast.contingency.contingencies_now import MAX_SLOPE, MIN_STEP_S, STEP_S, TIMED
from ipoa_mission.forecast.contingency.energy_budget import Budget, Taken, budget_of
from ipoa_mission.forecast.contingency.grades import Grade
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.drawn_flight import SampledTrack
from ipoa_mission.report.panels.contingency_panel import contingency_bars, stretches
from ipoa_mission.scenario import Scenario
from ipoa_mission.studio.answers import StripBar, StripCost, StripOfEndings, StripStretch
from ipoa_mission.studio.plan_answers import course_of
from ipoa_mission.studio.view import without_folders

INITIAL_SAMPLES, SAMPLE_LIMIT = 16, 24  # computed costs


def strips_of(forecast: Forecast, revision: int, flight: int) -> Iterator[StripOfEndings]:
    """Yield the strip at once, and again with costs, which take simulated flights."""
    bars = () if forecast.scenario is None else contingency_bars(forecast)
    budget, course = budget_of(forecast) if bars else None, course_of(forecast)
    strip = StripOfEndings(
        revision=revision,
        flight=flight,
        reserve=None if budget is None or budget.battery is None else budget.battery.reserve,
        bars=tuple(_bar(bar, course, forecast.world) for bar in bars),
    )
    yield strip
    if bars:
        costs = [tuple(_costs(bar, forecast, budget)) for bar in bars]
        full = [bar.model_copy(update={"costs": cost}) for bar, cost in zip(strip.bars, costs, strict=True)]
        yield strip.model_copy(update={"bars": tuple(full)})


def _bar(bar: ContingencyBar, course: SampledTrack, scenario: Scenario) -> StripBar:
    return StripBar(
        ending=bar.contingency,
        stretches=tuple(
            StripStretch(
                look=one.look,
                from_s=round(one.row.from_s, 2),
                to_s=round(one.row.to_s, 2),
                begins=round(one.begins, 1),
                ends=round(one.ends, 1),
                words=without_folders(one.row.in_full, scenario),
            )
            for one in stretches(bar, course)
        ),
        costs=(),
    )


def _costs(bar: ContingencyBar, forecast: Forecast, budget: Budget | None) -> Iterator[StripCost]:
    if bar.contingency not in TIMED or bar.rows[0].grade is Grade.UNKNOWN:
        return
    for time, ((low, high), used, _) in sorted(_taken(bar.contingency, forecast.cached(Contingencies)).items()):
        left = None if budget is None or used is None else budget.left(budget.taken(time, used))
        yield StripCost(
            at_s=round(time, 2),
            seconds=(round(low, 1), round(high, 1)),
            energy_wh=None if used is None else (round(used.between.low, 2), round(used.between.high, 2)),
            lands=None if left is None else round(left.likely, 3),
            least=None if left is None else round(left.low, 3),
            most=None if left is None else round(left.high, 3),
        )


def _taken(contingency: Contingency, endings: Contingencies) -> dict[float, Taken]:
    """Return costs at some times, with more samples at jumps, such as where a return begins to climb first."""
    begin, end = endings.in_air
    evenly = np.linspace(begin, end, min(INITIAL_SAMPLES, 2 + math.floor((end - begin) / STEP_S))).tolist()
    found = {time: taken for time in evenly if (taken := endings.takes(contingency, time)) is not None}
    while len(found) < SAMPLE_LIMIT:
        wide = [(a, b) for a, b in pairwise(sorted(found)) if b - a > MIN_STEP_S]
        steep = [(abs(sum(found[b][0]) - sum(found[a][0])) / 2 / (b - a), (a + b) / 2) for a, b in wide]
        steepest, middle = max(steep, default=(0.0, 0.0))
        if steepest < MAX_SLOPE:
            break
        taken = endings.takes(contingency, middle)
        if taken is None:
            break
        found[middle] = taken
    return found
