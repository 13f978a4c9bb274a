import math
from collections.abc import Mapping, Sequence
from html import escape

from ipoa_mission.report.number_format import number, signed
from ipoa_mission.report.stops import FlownItem

HEAD = (
    ("item", ""),
    ("east", "m"),
    ("north", "m"),
    ("up", "m"),
    ("above ground", "m"),
    ("leg", "m"),
    ("heading", "°"),
    ("climb", "m"),
    ("clearance", "m"),
    ("done", "s"),
    ("takes", "s"),
    ("mean", "m/s"),
)


def legs(stops: Sequence[FlownItem], flown_done: Mapping[int, float] | None) -> str:
    flown_head = (("flown", "s"), ("off by", "s")) if flown_done is not None else ()
    head = "".join(f'<th scope="col">{name}<small>{unit}</small></th>' for name, unit in (*HEAD, *flown_head))
    rows = "".join(_row(n, stop, flown_done) for n, stop in enumerate(stops))
    return (
        f'<div class="scroll" tabindex="0"><table id="legs"><thead><tr>{head}<th scope="col" class="words">slow because'
        f"</th></tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _row(n: int, stop: FlownItem, flown_done: Mapping[int, float] | None) -> str:
    time, place = stop.time, stop.place
    heading = number(math.degrees(stop.heading) % 360, 0)
    cells = [
        *((number(float(v), 1) for v in place) if place is not None else ("", "", "")),
        number(stop.above_ground, 1),
        *((number(stop.length, 1), heading, number(stop.climb, 1)) if place is not None else ("", "", "")),
        _clearance(stop),
        f"<b>{number(time.done_s, 1)}</b>",
        number(time.duration_s, 1) if time.duration_s > 0 else "",
        number(time.mean_speed, 1) if time.mean_speed > 0 else "",
    ]
    if flown_done is not None:
        done = flown_done.get(n, math.nan)
        cells += [number(done, 1), signed(time.done_s - done, 1)]
    body = "".join(f"<td>{cell}</td>" for cell in cells)
    return (
        f'<tr data-stop="{n}" tabindex="0"><th scope="row"><i>{time.seq}</i> {escape(stop.name)}</th>{body}'
        f'<td class="words">{escape(time.reason)}</td></tr>'
    )


def _clearance(stop: FlownItem) -> str:
    if stop.proof is None:
        return ""
    least = stop.proof.clearance
    if not stop.proof.holds:
        return f'<span class="bad" title="{escape(stop.proof.words())}">✕ {number(least.distance, 2)}</span>'
    return f'<span title="to {escape(least.what)}">{number(least.distance, 2)}</span>'
