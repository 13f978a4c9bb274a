"""The strip under the height profile: what each ending would do from every second, drawn where the vehicle is then."""

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

from ipoa_mission.forecast.endings import EndingRow, Endings
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade
from ipoa_mission.report.chart import GraphAxis
from ipoa_mission.report.panels.profile import NARROWEST, along_axis
from ipoa_mission.report.seen import Seen
from ipoa_mission.vehicles.ending import Ending

LOOK = {Grade.CLEAR: "clear", Grade.MAY: "perhaps"}  # its class; of all others "not-clear"
WORDED = 0.09  # of the strip's width: on what is narrower no words fit
NOTE = "What would follow if the flight were ended there; a vehicle ends one by a failsafe, or as its pilot orders."


def endings_strip(forecast: Forecast, course: Seen) -> str:
    """A bar for each ending that the vehicle has, and in words what is not clear.

    Nothing where nobody can say how it will be flown.
    """
    if forecast.promise_if_known is None:
        return ""
    rows, axis = forecast.once(Endings).all_rows(timed=False), along_axis(course)
    bars = "".join(
        _bar(ending, [row for row in rows if row.ending is ending], course, axis)
        for ending in dict.fromkeys(row.ending for row in rows)
    )
    return (
        f'<h3>If it were ended there</h3><p class="note">{NOTE}</p>'
        f'<div class="chart strip" id="endings" data-along="along" data-low="{axis.low:.9g}" '
        f'data-high="{axis.high:.9g}" role="group" aria-label="endings over {escape(axis.label)}">'
        f'<div class="plot">{bars}<i class="cursor"></i></div></div>{_in_words(rows)}'
    )


def _bar(ending: Ending, rows: Sequence[EndingRow], course: Seen, axis: GraphAxis) -> str:
    """One ending: the worse a row is the higher it lies, since on the spot all times have one place."""
    worse = list(Grade)
    ways = "".join(_way(row, course, axis) for row in sorted(rows, key=lambda row: worse.index(row.grade)))
    leads = ", ".join(dict.fromkeys(row.leads for row in rows))
    return f'<div class="ending"><b>{ending}</b> {escape(leads)}<div class="ways">{ways}</div></div>'


def _way(row: EndingRow, course: Seen, axis: GraphAxis) -> str:
    begin, end = axis.place(np.interp([row.from_s, row.to_s], course.times, course.along)).tolist()
    wide, words = max(end - begin, NARROWEST), escape(str(row))
    look = LOOK.get(row.grade, "not-clear")
    return (
        f'<span class="way {look}" role="img" aria-label="{words}" title="{words}" '
        f'data-ending="{row.ending}" data-from="{row.from_s:.2f}" data-to="{row.to_s:.2f}" '
        f'data-keeps="{escape(row.keeps)}" style="left:{100 * begin:.2f}%;width:{100 * wide:.2f}%">'
        f"{look.replace('-', ' ') if wide >= WORDED else ''}</span>"
    )


def _in_words(rows: Iterable[EndingRow]) -> str:
    lines = "".join(f"<li>{escape(str(row))}</li>" for row in rows if not row.clear)
    return f'<ul class="ways-not-clear">{lines}</ul>' if lines else '<p class="note">Every ending is clear.</p>'
