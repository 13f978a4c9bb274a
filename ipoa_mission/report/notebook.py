"""Show tables in a notebook: `%load_ext ipoa_mission`."""

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

from ipoa_mission.autopilot.commands import command_name
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.plan import Plan
from ipoa_mission.report.exports.table import mission_table, shown


def mission_html(mission: Mission) -> str:
    home = mission.home
    place = f"home {home.latitude_deg:.6f}, {home.longitude_deg:.6f}, {home.altitude:.1f} m AMSL"
    rows = [
        (row.seq, row.command, shown(row.length), shown(row.heading_deg, "03.0f"), shown(row.height))
        for row in mission_table(mission)
    ]
    caption = f"Mission of {len(mission.items)} items for {mission.autopilot}, {place}"
    return _table(caption, ("item", "command", "leg [m]", "heading [°]", "height [m]"), rows)


def plan_html(plan: Plan) -> str:
    least = plan.proof.clearance
    rows = [
        ("length", f"{plan.cost.length:.1f} m"),
        ("turns", f"{plan.cost.turning_deg:.0f}°"),
        ("changes of climb", f"{plan.cost.climbing_deg:.0f}°"),
        ("threat", f"{plan.cost.threat:.3f}"),
        ("cost", f"{plan.cost.total:.3f}"),
        ("least clearance", f"{least.distance:.2f} m, to {least.what}"),
        ("found by", f"{plan.optimizer}, seed {plan.seed}, {plan.evaluations[-1]} evaluations"),
    ]
    return _table("Plan", ("", ""), rows)


def estimate_html(estimate: Estimate) -> str:
    rows = [
        (item.seq, command_name(item.command), f"{item.duration_s:.1f}", f"{item.done_s:.1f}", item.reason)
        for item in estimate.items
    ]
    caption = f"Estimated {estimate.total_s:.1f} s ({estimate.low_s:.0f} to {estimate.high_s:.0f}){estimate.besides}"
    return _table(caption, ("item", "command", "takes [s]", "done at [s]", "what keeps it slow"), rows)


def flight_html(flight: FlightRecord) -> str:
    rows = [(index + 1, f"{at:.1f}") for index, at in sorted(flight.item_reached_s.items())]
    outcome = "to its end" if flight.completed else "and broken off"
    caption = "; ".join((f"Flown {outcome}: {flight.total_s:.1f} s", *flight.remarks))
    return _table(caption, ("item", "done at [s]"), rows)


TABLES: dict[type, Callable[[Any], str]] = {
    Mission: mission_html,
    Plan: plan_html,
    Estimate: estimate_html,
    FlightRecord: flight_html,
}


def show_in(shell: Any) -> None:
    formatter = shell.display_formatter.formatters["text/html"]
    for kind, show in TABLES.items():
        formatter.for_type(kind, show)


def _table(caption: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    lines = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    above = f"<thead><tr>{head}</tr></thead>" if any(columns) else ""
    return f"<table><caption>{escape(caption)}</caption>{above}<tbody>{lines}</tbody></table>"
