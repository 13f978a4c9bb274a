"""What an engineer wants to know first: is it clear, how long will it fly, and what must be known before it does."""

import math
from collections.abc import Sequence
from html import escape

from ipoa_mission.energy.flight import Consumption
from ipoa_mission.planning.proof import Proof
from ipoa_mission.report.compare import Comparison
from ipoa_mission.report.course import Danger
from ipoa_mission.report.words import meters, number, seconds, share
from ipoa_mission.scenario.vehicle import BatterySection
from ipoa_mission.timing.estimate import Estimate
from ipoa_mission.timing.qgroundcontrol import COUNTS
from ipoa_mission.tube.promise import Promise


def verdict(proof: Proof | None, promise: Promise | None, dangers: Sequence[Danger]) -> str:
    """One line in words and with a sign: clear of everything, or not, on the legs and as predicted to be flown."""
    if proof is None:
        return '<p class="verdict">No leg between waypoints to judge.</p>'
    against = [proof.words()] if not proof.holds else [danger.words for danger in dangers if danger.touching]
    if against:
        return f'<p class="verdict bad"><b aria-hidden="true">✕</b> Not to be flown: {escape(against[0])}.</p>'
    least = proof.clearance
    required = next(check.required for check in proof.checks if check.nearest is least)
    words = f"Clear by {meters(least.distance)}: the nearest thing is {escape(least.what)}; {meters(required)} required"
    if promise is not None and promise.confidence is not None and (kept := promise.clearance) is not None:
        flights = f"{share_of_flights(promise.confidence)} keep it; nominal {meters(kept.nominal)}"
        words = f"Clear by {meters(kept.kept)} from {escape(kept.to)}: {flights}, {meters(kept.required)} required"
        if any(broken.on_the_way for broken in promise.broken):
            return f'<p class="verdict bad"><b aria-hidden="true">✕</b> Not to be flown: {words}.</p>'
    if dangers:
        return f'<p class="verdict bad"><b aria-hidden="true">!</b> {words}; but {escape(dangers[0].words)}.</p>'
    return f'<p class="verdict good"><b aria-hidden="true">✓</b> {words}.</p>'


def share_of_flights(confidence: float) -> str:
    """As in "99 % of flights"."""
    return f"{100 * confidence:g}\N{NO-BREAK SPACE}% of flights"


def figures(
    estimate: Estimate,
    proof: Proof | None,
    length: float,
    waypoints: int,
    comparison: Comparison | None,
    energy: Consumption | None,
    battery: BatterySection | None,
) -> str:
    """The headline numbers."""
    interval = f"{seconds(estimate.low_s)} to {seconds(estimate.high_s)}"
    cards = [_card("estimated flight", seconds(estimate.total_s), interval, "lead")]
    if comparison is not None:
        cards.append(_flown(comparison))
    cards.append(_card("QGroundControl would say", seconds(estimate.qgroundcontrol_s), COUNTS))
    if proof is not None:
        look = "" if proof.holds else "bad"
        cards.append(_card("least clearance", meters(proof.clearance.distance), f"to {proof.clearance.what}", look))
    cards.append(_card("path", meters(length, 0), f"{waypoints} waypoints"))
    if estimate.route.seconds > 0:
        against = f"{number(estimate.route.ratio, 2)} times the lower bound, {seconds(estimate.route.least)}"
        cards.append(_card("first place to last waypoint", seconds(estimate.route.seconds), against))
    if energy is not None:
        cards.append(_energy(energy, battery))
    return f'<dl class="figures">{"".join(cards)}</dl>'


def warnings(dangers: Sequence[Danger], remarks: Sequence[str]) -> str:
    """What must be known before flying, dangers first; nothing when there is nothing."""
    if not dangers and not remarks:
        return ""
    rows = [f'<li class="bad">{escape(danger.words)}</li>' for danger in dangers]
    rows += [f"<li>{escape(remark)}</li>" for remark in remarks]
    look = "warnings bad" if dangers else "warnings"
    return f'<section class="{look}"><h2>Before you fly</h2><ul>{"".join(rows)}</ul></section>'


def _energy(used: Consumption, battery: BatterySection | None) -> str:
    """What the flight takes, and how full the battery comes home beside the reserve that it must keep."""
    value = f"{number(used.energy_wh, 1)}\N{NO-BREAK SPACE}Wh"
    if battery is None:
        return _card("energy", value, f"{number(used.mean_w, 0)} W on average, {number(used.peak_w, 0)} W at most")
    left = max(used.left(battery.build()), 0.0)
    note = f"{left:.0%} of {battery.capacity_wh:g} Wh left, {battery.reserve:.0%} required"
    bar = (
        f'<i class="battery" role="img" aria-label="{escape(note)}"><i style="width:{left:.1%}"></i>'
        f'<b style="left:{battery.reserve:.1%}"></b></i>'
    )
    return _card("energy", value, note, "bad" if left < battery.reserve else "", bar)


def _flown(comparison: Comparison) -> str:
    """The flight's own time; where its log breaks off, that of its route."""
    if math.isfinite(comparison.flown_total_s):
        off = share(comparison.estimated_total_s, comparison.flown_total_s)
        return _card("flown", seconds(comparison.flown_total_s), f"the estimate is off by {off}", "flown")
    if math.isfinite(comparison.flown_route_s):
        off = share(comparison.estimated_route_s, comparison.flown_route_s)
        return _card("flown, route only", seconds(comparison.flown_route_s), f"estimate off by {off}", "flown")
    return _card("flown", "not known", "the log tells of no item", "flown")


def _card(label: str, value: str, note: str, look: str = "", below: str = "") -> str:
    words = f"{escape(value)}{below}<small>{escape(note)}</small>"
    return f'<div class="{look}"><dt>{escape(label)}</dt><dd>{words}</dd></div>'
