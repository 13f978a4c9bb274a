"""The top of the report: verdict, figures, and what to read before the flight."""

import math
from collections.abc import Collection, Sequence
from html import escape

from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.contingency.energy_budget import Budget, budget_of
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, KeptLimit
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.estimate import COUNTED_TERMS
from ipoa_mission.planning.proof import Proof
from ipoa_mission.report.compare import Comparison
from ipoa_mission.report.drawn_flight import Danger
from ipoa_mission.report.panels.tables import number, seconds, signed


def verdict(
    proof: Proof | None,
    guarantee: ClearanceGuarantee | None,
    dangers: Sequence[Danger],
    findings: Sequence[Finding] = (),
) -> str:
    errors = [finding.message for finding in findings if finding.severity is Severity.ERROR]
    if proof is None:
        if errors:
            return _line("bad", "✕", f"Not to be flown: {errors[0]}.")
        return '<p class="verdict">No leg between waypoints to judge.</p>'
    against = [proof.words()] if not proof.is_proved else [danger.words for danger in dangers if danger.touching]
    broken = [] if guarantee is None else [limit for limit in guarantee.limits if limit.forbids]
    if guarantee is not None and broken:
        worst = min(broken, key=lambda limit: limit.slack)
        against.append(f"too near to {worst.to}: {worst.words(guarantee.confidence)}")
    if against or errors:
        return _line("bad", "✕", f"Not to be flown: {[*against, *errors][0]}.")

    if guarantee is not None and guarantee.clearance is not None:
        least_kept = guarantee.clearance
        words = f"Clear of {least_kept.to}: {least_kept.words(guarantee.confidence)}"
    else:
        least = proof.clearance
        required = next(check.required for check in proof.checks if check.nearest is least)
        clear_by = f"Clear by {floor_cm(least.distance):.2f} m"
        words = f"{clear_by}: the nearest is {least.what}; {ceil_cm(required):.2f} m required"
    if dangers:
        return _line("bad", "!", f"{words}; but {dangers[0].words}.")
    if findings:
        return _line("amber", "!", f"{words}. But read what is below before you fly: {findings[0].message}.")
    return _line("good", "✓", f"{words}.")


def _line(look: str, sign: str, words: str) -> str:
    return f'<p class="verdict {look}"><b aria-hidden="true">{sign}</b> {escape(words)}</p>'


def figures(forecast: Forecast, length: float, waypoints: int, comparison: Comparison | None) -> str:
    """`length`: of the predicted path over ground [m]."""
    estimate = forecast.estimate
    guarantee = forecast.guarantee_if_known
    budget = budget_of(forecast)
    interval = f"{seconds(estimate.low_s)} to {seconds(estimate.high_s)}{estimate.besides}"
    cards = [_card("estimated flight", seconds(estimate.total_s), interval, "lead")]
    if comparison is not None:
        cards.append(_flown_card(comparison))
    cards.append(_card("QGroundControl would say", seconds(estimate.qgroundcontrol_s), COUNTED_TERMS))
    if guarantee is not None and guarantee.clearance is not None:
        cards.append(_clearance_card(guarantee.clearance, guarantee.confidence))
    cards.append(_card("path", f"{number(length, 0)}\N{NO-BREAK SPACE}m", f"{waypoints} waypoints"))
    if estimate.route_s > 0:
        cards.append(_card("first place to last waypoint", seconds(estimate.route_s), "without take-off and landing"))
    if budget is not None:
        cards.append(_energy_card(budget))
    return f'<dl class="figures">{"".join(cards)}</dl>'


def warnings(
    dangers: Sequence[Danger], findings: Sequence[Finding], remarks: Sequence[str], of_map: Collection[str] = ()
) -> str:
    if not dangers and not findings and not remarks:
        return ""
    rows = [f'<li class="bad">{escape(danger.words)}</li>' for danger in dangers]
    for finding in sorted(findings, key=lambda finding: finding.severity is not Severity.ERROR):
        hint = f"; {finding.hint}" if finding.hint else ""
        look = "bad" if finding.severity is Severity.ERROR else "amber"
        rows.append(f'<li class="{look}">{escape(f"{finding.message}{hint}")}</li>')
    shown = {words for finding in findings for words in (finding.message, finding.hint)}
    plain = [remark for remark in dict.fromkeys(remarks) if remark not in shown]
    folded = [f"<li>{escape(remark)}</li>" for remark in plain if remark in of_map]
    if len(folded) > 1:
        plain = [remark for remark in plain if remark not in of_map]
        summary = f"{len(folded)} remarks on the map"
        rows.append(f"<li><details><summary>{summary}</summary><ul>{''.join(folded)}</ul></details></li>")
    rows += [f"<li>{escape(remark)}</li>" for remark in plain]
    look = "warnings bad" if dangers else "warnings"
    return f'<section class="{look}"><h2>Before you fly</h2><ul>{"".join(rows)}</ul></section>'


def _clearance_card(limit: KeptLimit, confidence: float | None) -> str:
    look = "bad" if limit.falls_short else ""
    value = f"{abs(floor_cm(limit.guaranteed)):.2f}\N{NO-BREAK SPACE}m{' inside' if limit.guaranteed < 0 else ''}"
    if confidence is None:
        return _card("predicted clearance", value, f"to {limit.to}", look)
    note = f"to {limit.to}; predicted {floor_cm(limit.nominal):.2f} m"
    return _card(f"{100 * confidence:g}\N{NO-BREAK SPACE}% of flights keep", value, note, look)


def _energy_card(budget: Budget) -> str:
    used = budget.used
    battery = budget.battery
    value = f"{number(used.energy_wh, 1)}\N{NO-BREAK SPACE}Wh"
    interval = f"{number(used.between.low, 1)} to {number(used.between.high, 1)} Wh"
    if battery is None:
        return _card("energy", value, f"{interval}; {number(used.mean_w, 0)} W on average")
    left = max(1 - used.energy_wh / battery.capacity_wh, 0.0)
    note = f"{interval}; {left:.0%} of {battery.capacity_wh:.4g} Wh left, {battery.reserve:.0%} required"
    if budget.no_return is not None:
        note += f"; no RTL from item {budget.no_return.seq} on"
    bar = (
        f'<i class="battery" role="img" aria-label="{escape(note)}"><i style="width:{left:.1%}"></i>'
        f'<b style="left:{battery.reserve:.1%}"></b></i>'
    )
    return _card("energy", value, note, "bad" if left < battery.reserve else "", bar)


def _flown_card(comparison: Comparison) -> str:
    if math.isfinite(comparison.flown_total_s):
        off = signed(100 * comparison.total_error, 1, "%")
        return _card("flown", seconds(comparison.flown_total_s), f"the estimate is off by {off}", "flown")
    if math.isfinite(comparison.flown_route_s):
        off = signed(100 * comparison.route_error, 1, "%")
        return _card("flown, route only", seconds(comparison.flown_route_s), f"estimate off by {off}", "flown")
    return _card("flown", "not known", "the log reports no item", "flown")


def _card(label: str, value: str, note: str, look: str = "", below: str = "") -> str:
    words = f"{escape(value)}{below}<small>{escape(note)}</small>"
    return f'<div class="{look}"><dt>{escape(label)}</dt><dd>{words}</dd></div>'
