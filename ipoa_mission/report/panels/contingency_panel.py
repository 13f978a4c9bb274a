from collections.abc import Iterable
from html import escape

import numpy as np

from ipoa_mission.forecast.contingency.contingencies import ContingencyBar, ContingencyRow
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.chart import GraphAxis
from ipoa_mission.report.panels.profile import MIN_WIDTH, along_axis
from ipoa_mission.report.seen import Seen
from ipoa_mission.report.ways_home import ContingencyStretch, contingency_bars, stretches

MIN_LABEL_WIDTH = 0.09  # of the strip
NOTE = "The result of ending the flight there, by a failsafe or by the pilot."


def contingency_strip(forecast: Forecast, course: Seen) -> str:
    """Also list those not clear; nothing without a forecast."""
    bars, axis = contingency_bars(forecast), along_axis(course)
    if not bars:
        return ""
    drawn = "".join(_bar(bar, course, axis) for bar in bars)
    rows = [row for bar in bars for row in bar.rows]
    return (
        f'<h3>If it were ended there</h3><p class="note">{NOTE}</p>'
        f'<div class="chart strip" id="endings" data-along="along" data-low="{axis.low:.9g}" '
        f'data-high="{axis.high:.9g}" role="group" aria-label="endings over {escape(axis.label)}">'
        f'<div class="plot">{drawn}<i class="cursor"></i></div></div>{_in_words(rows)}'
    )


def _bar(bar: ContingencyBar, course: Seen, axis: GraphAxis) -> str:
    ways = "".join(_way(stretch, axis) for stretch in stretches(bar, course))
    return f'<div class="ending"><b>{bar.contingency}</b> {escape(bar.leads)}<div class="ways">{ways}</div></div>'


def _way(stretch: ContingencyStretch, axis: GraphAxis) -> str:
    row, look = stretch.row, stretch.look
    begin, end = axis.place(np.array([stretch.begins, stretch.ends])).tolist()
    wide, words = max(end - begin, MIN_WIDTH), escape(str(row))
    return (
        f'<span class="way {look.replace(" ", "-")}" role="img" aria-label="{words}" title="{words}" '
        f'data-ending="{row.contingency}" data-from="{row.from_s:.2f}" data-to="{row.to_s:.2f}" '
        f'data-keeps="{escape(row.keeps)}" style="left:{100 * begin:.2f}%;width:{100 * wide:.2f}%">'
        f"{look if wide >= MIN_LABEL_WIDTH else ''}</span>"
    )


def _in_words(rows: Iterable[ContingencyRow]) -> str:
    lines = "".join(f"<li>{escape(str(row))}</li>" for row in rows if not row.clear)
    return f'<ul class="ways-not-clear">{lines}</ul>' if lines else '<p class="note">Every ending is clear.</p>'
