"""Tables of the report: legs to the items, estimate against flight, limits, flights of one battery.

Numbers have significant digits only, and a real minus sign.
"""

import math
from collections.abc import Mapping, Sequence
from html import escape

from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.planning.proof import Proof
from ipoa_mission.report.drawn_flight import ItemLeg


def seconds(value: float) -> str:
    """`43.1 s`, `103 s`, `3 min 13 s`."""
    if value < 119.5:
        digits = 1 if value < 99.95 else 0
        return f"{value:.{digits}f}\N{NO-BREAK SPACE}s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes}\N{NO-BREAK SPACE}min {rest:02d}\N{NO-BREAK SPACE}s"


def number(value: float | None, digits: int) -> str:
    """Empty if unknown or not finite."""
    if value is None or not math.isfinite(value):
        return ""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def signed(value: float, digits: int, unit: str = "") -> str:
    """As `+1.2 m`; empty if not finite."""
    if not math.isfinite(value):
        return ""
    words = f"{round(value, digits) + 0.0:+.{digits}f}".replace("-", "−")
    return f"{words}\N{NO-BREAK SPACE}{unit}" if unit else words


def legs_table(legs: Sequence[ItemLeg], flown_s: Mapping[int, float] | None) -> str:
    """`flown_s`: when each item was first done, by index; None without a flight."""
    columns = [
        *(("item", ""), ("east", "m"), ("north", "m"), ("up", "m"), ("above ground", "m"), ("leg", "m")),
        *(("heading", "°"), ("climb", "m"), ("clearance", "m"), ("done", "s"), ("takes", "s"), ("mean", "m/s")),
        *([] if flown_s is None else [("flown", "s"), ("off by", "s")]),
    ]
    head = "".join(f'<th scope="col">{name}<small>{unit}</small></th>' for name, unit in columns)
    rows = ""
    open_s = None if flown_s is None else dict(flown_s)
    for n, leg in enumerate(legs):
        done = None if open_s is None else open_s.pop(leg.time.seq - 1, math.nan)  # counts once
        rows += _leg(n, leg, done)
    return scrolled_table(f'<tr>{head}<th scope="col" class="words">slow because</th></tr>', rows, ' id="legs"')


def _leg(n: int, leg: ItemLeg, flown_s: float | None) -> str:
    time = leg.time
    place = leg.place
    row = leg.row
    clearance = ""
    if leg.proof is not None:
        least = leg.proof.clearance
        mark = f'<span title="to {escape(least.what)}">'
        if not leg.proof.is_proved:
            mark = f'<span class="bad" title="{escape(leg.proof.words())}">✕ '
        clearance = f"{mark}{number(least.distance, 2)}</span>"
    cells = [
        *((number(float(v), 1) for v in place) if place is not None else ("", "", "")),
        *(number(row.height_above_ground, 1), number(row.length, 1), number(row.heading(0), 0), number(row.climb, 1)),
        clearance,
        f"<b>{number(time.done_s, 1)}</b>",
        number(time.duration_s, 1) if time.duration_s > 0 else "",
        number(time.mean_speed, 1) if time.mean_speed > 0 else "",
    ]
    if flown_s is not None:
        cells += [number(flown_s, 1), signed(time.done_s - flown_s, 1)]
    body = "".join(f"<td>{cell}</td>" for cell in cells)
    return (
        f'<tr data-stop="{n}" tabindex="0"><th scope="row"><i>{time.seq}</i> {escape(leg.name)}</th>{body}'
        f'<td class="words">{escape(time.reason)}</td></tr>'
    )


def limits_table(proof: Proof) -> str:
    names = {
        "obstacles": "distance to obstacles",
        "ground": "height above ground",
        "bounds": "inside the bounds",
        "ceiling": "height above ground, at most",
        "climb": "climb angle, at most",
        "descent": "descent angle, at most",
    }
    rows = ""
    for check in proof.checks:
        sign = '<span class="good">✓</span>' if check.is_kept else '<span class="bad">✕</span>'
        digits = 2 if check.unit == "m" else 1
        found, required = (
            f"{number(value, digits)} {check.unit}" for value in (check.nearest.distance, check.required)
        )
        where = "".join(f"<td>{number(axis, 1)}</td>" for axis in check.nearest.place)
        rows += f'<tr><th scope="row">{sign} {escape(names.get(check.limit, check.limit))}</th><td><b>{found}</b></td>'
        rows += f'<td>{required}</td><td class="words">{escape(check.nearest.what)}</td>{where}</tr>'
    places = "".join(f"<th>{axis}<small>m</small></th>" for axis in ("east", "north", "up"))
    head = f'<tr><th></th><th>found</th><th>required</th><th class="words">nearest</th>{places}</tr>'
    note = "The least that the legs between waypoints have, exactly, and where."
    return f'<section><h2>Limits, proved</h2><p class="note">{note}</p>{scrolled_table(head, rows)}</section>'


def parts_table(parts: Sequence[Forecast], names: Sequence[str]) -> tuple[list[str], list[tuple[str, ...]]]:
    """Return columns and rows for a terminal and a page; a line break in a column's name puts its unit below."""
    rows = list[tuple[str, ...]]()
    for name, part in zip(names, parts, strict=True):
        budget = budget_of(part)
        left = None if budget is None else budget.left(budget.used.between)
        takes = f"{part.estimate.total_s:.1f}"
        energy = "" if budget is None else str(budget.used.between)
        share = "" if left is None else f"{left.likely:.0%}"
        rows.append((f"{name}.plan", str(len(part.mission.items)), takes, energy, share))
    return ["file", "items", "takes\ns", "energy\nWh", "left"], rows


def parts_panel(parts: Sequence[Forecast], names: Sequence[str]) -> str:
    note = (
        f"One battery is not enough for the whole flight: it is flown in {len(parts)} flights, a battery each, "
        "one after the other. Each begins as the whole does, and continues where the one before returned."
    )
    return f'<section><h2>Flights</h2><p class="note">{note}</p>{plain_table(*parts_table(parts, names))}</section>'


def plain_table(columns: Sequence[str], rows: Sequence[tuple[str, ...]], marks: Sequence[str] = ()) -> str:
    """Return a table as a terminal's, with a mark in HTML before the head of each row."""
    heads = "".join(f'<th scope="col">{escape(name).replace(chr(10), ", ")}</th>' for name in columns)
    body = ""
    for mark, (head, *cells) in zip(marks or [""] * len(rows), rows, strict=True):
        body += (
            f'<tr><th scope="row">{mark}{escape(head)}</th>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}</tr>'
        )
    return scrolled_table(f"<tr>{heads}</tr>", body)


def scrolled_table(head: str, rows: str, attributes: str = "") -> str:
    table = f"<table{attributes}><thead>{head}</thead><tbody>{rows}</tbody></table>"
    return f'<div class="scroll" tabindex="0">{table}</div>'
