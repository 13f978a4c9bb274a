"""Contingencies along the flight: a bar for each, and the RTL path from the cursor."""

from html import escape
from typing import Any, Literal, TypeAlias

import numpy as np

from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow, Grade, contingencies_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Vector
from ipoa_mission.report.drawn_flight import SampledTrack
from ipoa_mission.report.panels.profile import MIN_WIDTH, along_axis

GradeLook: TypeAlias = Literal["clear", "perhaps", "not clear", "unknown"]
GRADE_LOOKS: dict[Grade, GradeLook] = {
    Grade.CLEAR: "clear",
    Grade.POSSIBLY_UNCLEAR: "perhaps",
    Grade.UNCLEAR: "not clear",
    Grade.UNKNOWN: "unknown",
}


def return_paths(forecast: Forecast) -> list[dict[str, Any]]:
    """Return `from` [s], `clear` and `points` (n, 3) [m] of RTL, in time order; the first of several returns."""
    if forecast.guarantee_if_known is None or Contingency.RTL not in contingencies_of(forecast):
        return []
    contingencies = forecast.cached(Contingencies)
    if contingencies.paths.why_unknown() is not None:
        return []
    samples = contingencies.samples(Contingency.RTL)
    count = len(samples.times)
    return [
        {
            "from": round(float(samples.times[n]), 2),
            "clear": bool(samples.clear[n]),
            "points": samples.paths[n][samples.possible[n]][0].round(2).tolist(),
        }
        for n in np.unique(np.linspace(0, count - 1, min(150, count)).round().astype(int))
        if samples.possible[n].any()
    ]


def contingency_bars(forecast: Forecast) -> dict[Contingency, tuple[ContingencyRow, ...]]:
    if forecast.guarantee_if_known is None:
        return {}
    return forecast.cached(Contingencies).by_contingency(timed=False)


def stretches(rows: tuple[ContingencyRow, ...], predicted: SampledTrack) -> list[tuple[ContingencyRow, float, float]]:
    """Return each row with distances over ground [m]; at a standstill it has no length."""
    edges = np.interp([(row.from_s, row.to_s) for row in rows], predicted.times, predicted.along).tolist()
    return [(row, begins, ends) for row, (begins, ends) in zip(rows, edges, strict=True)]


def contingency_strip(forecast: Forecast, predicted: SampledTrack) -> str:
    """Return bars, and a list of those not clear; empty without a forecast."""
    bars = contingency_bars(forecast)
    if not bars:
        return ""
    axis = along_axis(predicted)
    drawn = ""
    for contingency, rows in bars.items():
        ways = "".join(_stretch(row, axis.place(np.array(ends))) for row, *ends in stretches(rows, predicted))
        goals = ", ".join(dict.fromkeys(row.leads for row in rows))
        leads = f"<b>{contingency}</b> {escape(goals)}"
        drawn += f'<div class="contingency">{leads}<div class="ways">{ways}</div></div>'
    unclear = "".join(f"<li>{escape(str(row))}</li>" for rows in bars.values() for row in rows if not row.clear)
    below = (
        f'<ul class="ways-not-clear">{unclear}</ul>' if unclear else '<p class="note">Every contingency is clear.</p>'
    )
    return (
        '<h3>If it were ended there</h3><p class="note">The result of ending the flight there, by a failsafe or by '
        'the pilot.</p><div class="chart strip" id="contingencies" data-along="along" '
        f'data-low="{axis.low:.9g}" data-high="{axis.high:.9g}" role="group" '
        f'aria-label="contingencies over {escape(axis.label)}">'
        f'<div class="plot">{drawn}<i class="cursor"></i></div></div>{below}'
    )


def _stretch(row: ContingencyRow, ends: Vector) -> str:
    begin, end = ends.tolist()
    look = GRADE_LOOKS[row.grade]
    words = escape(str(row))
    width = max(end - begin, MIN_WIDTH)
    has_room = width >= 0.09  # for the label
    return (
        f'<span class="way {look.replace(" ", "-")}" role="img" aria-label="{words}" title="{words}" '
        f'data-contingency="{row.contingency}" data-from="{row.from_s:.2f}" data-to="{row.to_s:.2f}" '
        f'data-keeps="{escape(row.keeps)}" style="left:{100 * begin:.2f}%;width:{100 * width:.2f}%">'
        f"{look if has_room else ''}</span>"
    )
