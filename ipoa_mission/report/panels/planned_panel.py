from html import escape

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector
from ipoa_mission.planning.cost import CostTerms
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import Check, Proof
from ipoa_mission.report.chart import Graph, axis_over
from ipoa_mission.report.number_format import number
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.seeking import CostSection

TOP_SHARE = 1.5  # times the final cost
LIMIT_NAMES = {
    "obstacles": "distance to obstacles",
    "ground": "height above ground",
    "bounds": "inside the bounds",
    "ceiling": "height above ground, at most",
    "climb": "climb angle, at most",
    "descent": "descent angle, at most",
}


def limits_table(proof: Proof) -> str:
    rows = "".join(_limit(check) for check in proof.checks)
    places = "".join(f"<th>{axis}<small>m</small></th>" for axis in ("east", "north", "up"))
    head = f'<tr><th></th><th>found</th><th>required</th><th class="words">nearest</th>{places}</tr>'
    return (
        '<section><h2>Limits, proved</h2><p class="note">The least that the legs between waypoints have, '
        'exactly, and where.</p><div class="scroll" tabindex="0">'
        f"<table><thead>{head}</thead><tbody>{rows}</tbody></table></div></section>"
    )


def search_panel(plan: Plan, scenario: Scenario) -> str:
    words = f"The curve that {escape(plan.optimizer)} found with seed {plan.seed}, judged by the paper's eq. (10)."
    search = convergence(plan.evaluations, plan.history)
    return (
        f'<section><h2>Cost and search</h2><p class="note">{words}</p><div class="side-by-side">'
        f'<div class="scroll" tabindex="0">{cost_table(plan.cost, scenario.cost)}</div>{search}</div></section>'
    )


def cost_table(terms: CostTerms, cost: CostSection) -> str:
    """Show the paper's eq. (10) with weights and shares."""
    length, turning, threat = cost.omega
    rows = (
        ("length W1", terms.length, "m", length),
        ("turning, W2", terms.turning_deg, "°", turning * cost.a1),
        ("climbing, W2", terms.climbing_deg, "°", turning * cost.a2),
        ("threat W3", terms.threat, "", threat),
    )
    body = "".join(_term(name, value, unit, weight, terms.total) for name, value, unit, weight in rows)
    head = '<tr><th></th><th>value</th><th>weight</th><th>cost</th><th class="words">share</th></tr>'
    foot = f"<tr><th>total</th><td></td><td></td><td><b>{number(terms.total, 2)}</b></td><td></td></tr>"
    return f"<table><thead>{head}</thead><tbody>{body}</tbody><tfoot>{foot}</tfoot></table>"


def convergence(evaluations: NDArray[np.int64], history: Vector) -> str:
    """Cut costs far above the last."""
    if len(history) < 2:
        return ""
    spent, shown = evaluations.astype(float), np.minimum(history, TOP_SHARE * history[-1])
    chart = Graph(axis_over("evaluations", spent, room=0.0, floor=0.0), axis_over("best cost known", shown))
    return chart.html("convergence", [chart.steps(spent, shown, "found")])


def _limit(check: Check) -> str:
    digits = 2 if check.unit == "m" else 1
    sign = '<span class="good">✓</span>' if check.holds else '<span class="bad">✕</span>'
    kept, required = (f"{number(value, digits)} {check.unit}" for value in (check.nearest.distance, check.required))
    where = "".join(f"<td>{number(axis, 1)}</td>" for axis in check.nearest.place)
    name = escape(LIMIT_NAMES.get(check.limit, check.limit))
    return (
        f'<tr><th scope="row">{sign} {name}</th><td><b>{kept}</b></td><td>{required}</td>'
        f'<td class="words">{escape(check.nearest.what)}</td>{where}</tr>'
    )


def _term(name: str, value: float, unit: str, weight: float, total: float) -> str:
    part = 100 * weight * value / total if total else 0.0
    bar = f'<i class="part" style="width:{max(part, 0.0):.1f}%"></i>'
    return (
        f'<tr><th scope="row">{name}</th><td>{number(value, 1)} {unit}</td><td>{weight:g}</td>'
        f'<td>{number(weight * value, 2)}</td><td class="words share">{bar}<span>{number(part, 0)} %</span></td></tr>'
    )
