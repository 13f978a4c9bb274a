"""Tables of the report: legs to the items, estimate against flight, limits, flights of one battery, search."""

import math
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Vector
from ipoa_mission.planning.cost import CostTerms
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import Check, Proof
from ipoa_mission.report.chart import Graph, GraphAxis, axis_over
from ipoa_mission.report.compare import Comparison
from ipoa_mission.report.drawn_flight import ItemLeg
from ipoa_mission.report.number_format import number, seconds, signed
from ipoa_mission.scenario import Scenario


def legs_table(legs: Sequence[ItemLeg], flown_s: Mapping[int, float] | None) -> str:
    """`flown_s`: when an item was done in flight, by index; None without a flight."""
    columns = [
        *(("item", ""), ("east", "m"), ("north", "m"), ("up", "m"), ("above ground", "m"), ("leg", "m")),
        *(("heading", "°"), ("climb", "m"), ("clearance", "m"), ("done", "s"), ("takes", "s"), ("mean", "m/s")),
        *([] if flown_s is None else [("flown", "s"), ("off by", "s")]),
    ]
    head = "".join(f'<th scope="col">{name}<small>{unit}</small></th>' for name, unit in columns)
    rows = "".join(_leg(n, leg, flown_s) for n, leg in enumerate(legs))
    return (
        f'<div class="scroll" tabindex="0"><table id="legs"><thead><tr>{head}<th scope="col" class="words">slow because'
        f"</th></tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _leg(n: int, leg: ItemLeg, flown_s: Mapping[int, float] | None) -> str:
    time, place = leg.time, leg.place
    heading = number(math.degrees(leg.heading) % 360, 0)
    cells = [
        *((number(float(v), 1) for v in place) if place is not None else ("", "", "")),
        number(leg.above_ground, 1),
        *((number(leg.length, 1), heading, number(leg.climb, 1)) if place is not None else ("", "", "")),
        "" if leg.proof is None else _clearance(leg.proof),
        f"<b>{number(time.done_s, 1)}</b>",
        number(time.duration_s, 1) if time.duration_s > 0 else "",
        number(time.mean_speed, 1) if time.mean_speed > 0 else "",
    ]
    if flown_s is not None:
        done = flown_s.get(n, math.nan)
        cells += [number(done, 1), signed(time.done_s - done, 1)]
    body = "".join(f"<td>{cell}</td>" for cell in cells)
    return (
        f'<tr data-stop="{n}" tabindex="0"><th scope="row"><i>{time.seq}</i> {escape(leg.name)}</th>{body}'
        f'<td class="words">{escape(time.reason)}</td></tr>'
    )


def _clearance(proof: Proof) -> str:
    least = proof.clearance
    if not proof.is_proved:
        return f'<span class="bad" title="{escape(proof.words())}">✕ {number(least.distance, 2)}</span>'
    return f'<span title="to {escape(least.what)}">{number(least.distance, 2)}</span>'


def flown_panel(comparison: Comparison) -> str:
    """Show the estimate against the flight; a log may have none of the items."""
    legs = comparison.legs
    if not legs:
        return '<section><h2>Estimate against flight</h2><p class="note">The log reports no item.</p></section>'
    route = ""
    if math.isfinite(comparison.route_error):
        error = signed(100 * comparison.route_error, 1, "%")
        estimated, flown = seconds(comparison.estimated_route_s), seconds(comparison.flown_route_s)
        route = f"From the first place to the last: estimated {estimated}, flown {flown}, an error of {error}."
    worst = max(legs, key=lambda leg: abs(leg.error_s))
    farthest = f"The leg that is farthest off leads to item {worst.seq}: {signed(worst.error_s, 1, 's')}."
    return (
        f'<section><h2>Estimate against flight</h2><p class="note">{route} {farthest}</p>'
        f'{_lateness(comparison)}<p class="legend"><span class="key planned">above zero: the estimate is late, '
        "the flight was quicker</span></p></section>"
    )


def _lateness(comparison: Comparison) -> str:
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


def limits_table(proof: Proof) -> str:
    rows = "".join(_limit(check) for check in proof.checks)
    places = "".join(f"<th>{axis}<small>m</small></th>" for axis in ("east", "north", "up"))
    head = f'<tr><th></th><th>found</th><th>required</th><th class="words">nearest</th>{places}</tr>'
    return (
        '<section><h2>Limits, proved</h2><p class="note">The least that the legs between waypoints have, '
        'exactly, and where.</p><div class="scroll" tabindex="0">'
        f"<table><thead>{head}</thead><tbody>{rows}</tbody></table></div></section>"
    )


def _limit(check: Check) -> str:
    names = {
        "obstacles": "distance to obstacles",
        "ground": "height above ground",
        "bounds": "inside the bounds",
        "ceiling": "height above ground, at most",
        "climb": "climb angle, at most",
        "descent": "descent angle, at most",
    }
    digits = 2 if check.unit == "m" else 1
    sign = '<span class="good">✓</span>' if check.is_kept else '<span class="bad">✕</span>'
    kept, required = (f"{number(value, digits)} {check.unit}" for value in (check.nearest.distance, check.required))
    where = "".join(f"<td>{number(axis, 1)}</td>" for axis in check.nearest.place)
    return (
        f'<tr><th scope="row">{sign} {escape(names.get(check.limit, check.limit))}</th><td><b>{kept}</b></td>'
        f'<td>{required}</td><td class="words">{escape(check.nearest.what)}</td>{where}</tr>'
    )


def parts_panel(parts: Sequence[Forecast], names: Sequence[str]) -> str:
    head = "".join(f'<th scope="col">{name}</th>' for name in ("flight", "items", "takes", "energy", "left"))
    rows = ""
    for name, part in zip(names, parts, strict=True):
        budget = budget_of(part)
        left = None if budget is None else budget.left(budget.used.between)
        cells = (
            str(len(part.mission.items)),
            seconds(part.estimate.total_s),
            "" if budget is None else str(budget.used),
            "" if left is None else f"{left.likely:.0%}",
        )
        rows += f'<tr><th scope="row">{escape(name)}</th>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}</tr>'
    note = (
        f"One battery is not enough for the whole flight: it is flown in {len(parts)} flights, a battery each, "
        "one after the other. Each begins as the whole does, and continues where the one before returned."
    )
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    scroll = f'<div class="scroll" tabindex="0">{table}</div>'
    return f'<section><h2>Flights</h2><p class="note">{note}</p>{scroll}</section>'


def search_panel(plan: Plan, scenario: Scenario) -> str:
    words = f"The curve that {escape(plan.optimizer)} found with seed {plan.seed}, judged by the paper's eq. (10)."
    search = _convergence(plan.evaluations, plan.history)
    return (
        f'<section><h2>Cost and search</h2><p class="note">{words}</p><div class="side-by-side">'
        f'<div class="scroll" tabindex="0">{_cost_table(plan.cost, scenario)}</div>{search}</div></section>'
    )


def _cost_table(terms: CostTerms, scenario: Scenario) -> str:
    """Show the paper's eq. (10) with weights and shares."""
    cost, total = scenario.cost, terms.total or math.inf
    length, turning, threat = cost.omega
    rows = (
        ("length W1", terms.length, "m", length),
        ("turning, W2", terms.turning_deg, "°", turning * cost.a1),
        ("climbing, W2", terms.climbing_deg, "°", turning * cost.a2),
        ("threat W3", terms.threat, "", threat),
    )
    body = "".join(
        f'<tr><th scope="row">{name}</th><td>{number(value, 1)} {unit}</td><td>{weight:g}</td>'
        f'<td>{number(weight * value, 2)}</td><td class="words share">{_bar(100 * weight * value / total)}</td></tr>'
        for name, value, unit, weight in rows
    )
    head = '<tr><th></th><th>value</th><th>weight</th><th>cost</th><th class="words">share</th></tr>'
    foot = f"<tr><th>total</th><td></td><td></td><td><b>{number(terms.total, 2)}</b></td><td></td></tr>"
    return f"<table><thead>{head}</thead><tbody>{body}</tbody><tfoot>{foot}</tfoot></table>"


def _bar(percent: float) -> str:
    return f'<i class="part" style="width:{max(percent, 0.0):.1f}%"></i><span>{number(percent, 0)} %</span>'


def _convergence(evaluations: NDArray[np.int64], history: Vector) -> str:
    """Cut costs above 1.5 times the last."""
    if len(history) < 2:
        return ""
    spent, shown = evaluations.astype(float), np.minimum(history, 1.5 * history[-1])
    chart = Graph(axis_over("evaluations", spent, room=0.0, floor=0.0), axis_over("best cost known", shown))
    return chart.html("convergence", [chart.steps(spent, shown, "found")])
