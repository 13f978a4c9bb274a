from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.commands import command_name
from ipoa_mission.centimeters import floor_cm
from ipoa_mission.cli.check_files import clearance_words, wind_words
from ipoa_mission.cli.checking import estimate_as_json, route_in_words
from ipoa_mission.cli.mission_source import FlownJob, Job
from ipoa_mission.flight.flight import Flight
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.waypoints_file import TAKEOFF_LOST
from ipoa_mission.report.panels.tables import parts_table
from ipoa_mission.report.summary import passed_over_as_json
from ipoa_mission.terminal import notes, print_json, print_lines, print_table
from ipoa_mission.unread import unread_as_json


def flight_as_json(estimate: Estimate, record: FlightRecord, reserves: Sequence[ReserveNow] = ()) -> dict[str, Any]:
    return {
        "completed": record.completed,
        "armed": record.armed,
        "in_air": record.in_air,
        "flown_s": round(record.total_s, 3),
        "time_zero": "armed",
        "items": [
            {"seq": index + 1, "done_s": round(time_s, 3), **({"late": True} if index in record.late_items else {})}
            for index, time_s in sorted(record.item_reached_s.items())
        ],
        "estimate": estimate_as_json(estimate),
        "messages": list(record.messages),
        **({"deviations": [deviation.as_json() for deviation in record.deviations]} if record.deviations else {}),
        **({"battery": [_reserve_as_json(reserve) for reserve in reserves]} if reserves else {}),
    }


def next_steps(link: str | None, system: int | None, record: FlightRecord) -> str:
    """Name the possible orders to a vehicle that was left in the air."""
    if link is None or not (record.deviations and record.in_air):
        return ""
    vehicle = f"--link {link}" + (f" --system {system}" if system else "")
    resume = f"`ipoa-mission resume {vehicle}` continues its mission"
    return f"{resume}, `ipoa-mission rtl {vehicle}` returns it home; a pilot can take it over"


def print_flown_json(flown: FlownJob, written: Sequence[Path], hint: str = "") -> None:
    job, noted, record, _ = flown
    remarks = list(dict.fromkeys((*job.remarks, *noted)))
    outcome: dict[str, Any] = {"remarks": remarks, "written": [str(path) for path in written]}
    if job.flight is not None:
        outcome["passed_over"] = passed_over_as_json(job.flight.scenario)
        outcome["unread"] = unread_as_json(job.flight.scenario.unread)
    failure = {"error": record.failure} | ({"hint": hint} if hint else {}) if record.failure else {}
    result = flight_as_json(job.estimate, record, job.reserves) | outcome | failure
    print_json(result, indent=None if record.deviations else 2)


def _reserve_as_json(now: ReserveNow) -> dict[str, Any]:
    return {
        "time_s": round(now.time, 2),
        "left": now.left,
        "planned": round(now.planned, 4),
        "lands_with": [round(share, 4) for share in now.lands],
        "reserve": now.reserve,
    }


def print_flown(flown: FlownJob, written: Sequence[Path]) -> None:
    job, noted, record, _ = flown
    print_lines(*notes(dict.fromkeys(noted)), *(() if record.completed else record.messages))
    columns = ["item", "command", "estimated\ns", "flown\ns", "difference\ns"]
    print_table(f"{job.name} on {job.mission.autopilot}: when each item was done", columns, _legs(job.estimate, record))
    print_lines(
        *([] if job.flight else route_in_words(job.estimate)),
        f"estimated {job.estimate.total_s:.1f} s{job.estimate.besides}, flown {record.total_s:.1f} s{_of_plan(job)}",
        f"written: {', '.join(map(str, written))}",
        *([f"{'not complete' if record.why_not else 'not as forecast'}: {record.failure}"] if record.failure else []),
    )


def _of_plan(job: Job) -> str:
    if job.flight is None:
        return ""
    guarantee = (job.begun or job.forecast).guarantee_if_known
    clearance = ""
    if guarantee and guarantee.confidence and guarantee.clearance:
        least = floor_cm(guarantee.clearance.guaranteed)
        clearance = f"; {100 * guarantee.confidence:g} % of flights keep {least:.2f} m"
    return f"{clearance}; QGroundControl would have said {job.estimate.qgroundcontrol_s:.0f} s"


def _legs(estimate: Estimate, record: FlightRecord) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for item in estimate.items:
        flown_s = record.item_reached_s.get(item.seq - 1)
        cells = ("", "") if flown_s is None else (f"{flown_s:.1f}", f"{item.done_s - flown_s:+z.1f}")
        cells = (f"<= {cells[0]}", "") if item.seq - 1 in record.late_items else cells
        rows.append((str(item.seq), command_name(item.command), f"{item.done_s:.1f}", *cells))
    return rows


def print_planned(flight: Flight, written: Iterable[Path]) -> None:
    print_lines(*describe(flight))
    print_lines(f"written: {', '.join(map(str, written))}", TAKEOFF_LOST)


def describe(flight: Flight) -> list[str]:
    mission = flight.mission
    firmware = mission.autopilot.checked_for(mission.firmware_version)
    lines = [
        f"{flight.name}: {flight.plan.cost.length:.1f} m, {count_words(len(mission.items))}, for {firmware}",
        *clearance_words(flight.guarantee),
        f"estimated {flight.estimate.total_s:.1f} s",
        *wind_words(flight.forecast.wind),
    ]
    lines += [] if flight.budget is None else flight.budget.words
    for finding in flight.findings:
        lines += [str(finding), *([f"hint: {finding.hint}"] if finding.hint else [])]
    return lines + notes(flight.notes)


def print_parts(whole: Flight, written: Iterable[Path]) -> None:
    print_lines(*describe(whole))
    print_table(f"{len(whole.parts)} flights, a battery each", *parts_table(whole.parts, whole.names))
    print_lines(f"written: {', '.join(map(str, written))}")
