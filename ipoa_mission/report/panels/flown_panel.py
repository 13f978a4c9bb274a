import math
from collections.abc import Mapping

import numpy as np

from ipoa_mission.report.chart import Graph, GraphAxis
from ipoa_mission.report.compare import Comparison, LegTime
from ipoa_mission.report.number_format import seconds, signed
from ipoa_mission.report.stops import FlownItem


def flown_panel(comparison: Comparison) -> str:
    """A log may have none of the items."""
    if not comparison.legs:
        return '<section><h2>Estimate against flight</h2><p class="note">The log reports no item.</p></section>'
    chart = _drift(comparison)
    return (
        f'<section><h2>Estimate against flight</h2><p class="note">{_route(comparison)} {_worst(comparison.legs)}</p>'
        f'{chart}<p class="legend"><span class="key planned">above zero: the estimate is late, the flight was quicker'
        "</span></p></section>"
    )


def done_in_flight(stops: tuple[FlownItem, ...], reached: Mapping[int, float]) -> dict[int, float]:
    """Return times by index in `stops`, without repeats."""
    done: dict[int, float] = {}
    met: set[int] = set()
    for n, stop in enumerate(stops):
        index = stop.time.seq - 1
        if index in reached and index not in met:
            done[n] = reached[index]
            met.add(index)
    return done


def _drift(comparison: Comparison) -> str:
    legs = comparison.legs
    times = np.array([leg.flown_done_s for leg in legs])
    late = np.array([leg.estimated_done_s - leg.flown_done_s for leg in legs])
    most = max(float(np.abs(late).max()) * 1.15, 1.0)
    chart = Graph(
        GraphAxis(0.0, max(float(times[-1]) * 1.015, 1.0), "flown time from arming [s]"),
        GraphAxis(min(-most * (late < 0).any(), -0.15 * most), most, "estimate − flight [s]"),
    )
    spots = "".join(
        f'<i class="dot" style="{chart.spot(t, d)}" title="item {leg.seq}: {signed(d, 1, "s")}"></i>'
        for leg, t, d in zip(legs, times.tolist(), late.tolist(), strict=True)
    )
    return chart.html("drift", [chart.level(0.0, "limit"), chart.curve(times, late, "planned")], spots)


def _route(comparison: Comparison) -> str:
    if not math.isfinite(comparison.route_error):
        return ""
    error = signed(100 * comparison.route_error, 1, "%")
    estimated, flown = seconds(comparison.estimated_route_s), seconds(comparison.flown_route_s)
    return f"From the first place to the last: estimated {estimated}, flown {flown}, an error of {error}."


def _worst(legs: tuple[LegTime, ...]) -> str:
    worst = max(legs, key=lambda leg: abs(leg.error_s))
    return f"The leg that is farthest off leads to item {worst.seq}: {signed(worst.error_s, 1, 's')}."
