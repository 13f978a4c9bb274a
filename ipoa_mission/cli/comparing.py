import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

import ipoa_mission.options as options
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.centimeters import floor_cm
from ipoa_mission.cli.groups import FlownByOptions
from ipoa_mission.errors import BadInput, LogUseless, OptionConflict
from ipoa_mission.options import expect_mission
from ipoa_mission.terminal import notes, picked, print_json, print_lines, print_table, round_finite

if TYPE_CHECKING:
    from ipoa_mission.flight.post_flight import FlownClearance
    from ipoa_mission.logs.flight_log import LoggedFlight
    from ipoa_mission.mission.flight_record import FlightRecord
    from ipoa_mission.mission.items import Mission
    from ipoa_mission.report.compare import Assumptions, ComparedFlight
    from ipoa_mission.scenario import Scenario


class _Row(NamedTuple):
    number: int
    flight: "LoggedFlight"
    record: "FlightRecord"
    compared: "ComparedFlight | None"
    clearance: "FlownClearance | None"


@dataclass
class LogOptions:
    number: Annotated[int | None, options.flag("--flight", "Only the N-th flight in the log.", "N", min=1)] = None
    system: options.LogSystemOption = None
    scenario: options.ScenarioOption = None


def compare(
    files: Annotated[
        list[Path], options.argument("[FILE] LOG", "A .tlog, .bin or .ulg, after the mission if the log lacks it.")
    ],
    flown_by: FlownByOptions,
    options: LogOptions,
    as_json: options.JsonOption = False,
) -> None:
    """Compare the log of a flown mission with the estimate, leg by leg, for each flight in the log.

    Mission, parameters and firmware come from the log, unless given here. With a scenario, the flown path is checked
    against terrain and obstacles. Exit code 1 if a flight did not keep the required clearance, or nothing in the log
    could be compared.

    Example: `ipoa-mission compare campus.plan campus.tlog`
    """
    from ipoa_mission.autopilot.learned import read_vehicle
    from ipoa_mission.cli.reading import read_world
    from ipoa_mission.flight.post_flight import landed_elsewhere
    from ipoa_mission.logs.flight_log import read_flights
    from ipoa_mission.report.compare import Assumptions
    from ipoa_mission.wind import CALM

    if len(files) > 2:
        raise OptionConflict("expected a mission and a log at most", place=files[2])
    *missions, log = files
    file = expect_mission(missions[0]) if missions else None
    flown = read_flights(log, options.system)
    if flown_by.autopilot not in (None, flown.autopilot):
        message = f"expected a log of {flown_by.autopilot}, not of {flown.autopilot}"
        raise BadInput(message, code="other-autopilot", place=log)
    mission: Mission | None = None
    remarks: list[str] = []
    if file is not None:
        mission, remarks = _read_mission(file, log, flown.autopilot, flown_by.autopilot is None)
    numbers = _numbers(options, log, len(flown.flights))
    version = None if flown_by.version is None else flown.autopilot.tables.expect(flown_by.version)
    world = read_world(options.scenario, flown_by.air)
    learned = None if flown_by.vehicle is None else read_vehicle(flown_by.vehicle, flown.autopilot)
    assumed = Assumptions(flown_by.parameters, learned, flown_by.air or CALM, version)
    rows = [_row(number, flown.flights[number - 1], mission, assumed, world) for number in numbers]
    landed = (words for row in rows if row.compared for words in landed_elsewhere(row.compared.forecast, row.record))
    remarks += [*flown_by.parameter_remarks, *flown.remarks, *_remarks(rows, log, world), *landed]
    beyond = flown.autopilot.beyond_the_model(flown.version)
    is_useless = all(row.compared is None and row.clearance is None for row in rows)
    if not as_json:
        on = f"{flown.autopilot} {flown.version}".strip()
        title = f"{log.name}: {on}" if file is None else f"{file.name} on {flown.autopilot}, as {log.name} has it"
        _report(rows, title, remarks if beyond is None else [*remarks, beyond])
    elif not is_useless:
        flights = [_as_json(row) for row in rows]
        for row in rows:
            flight = f"flight {row.number}: " if len(rows) > 1 else ""
            remarks += [f"{flight}{words}" for words in (row.compared.remarks if row.compared else ())]
        about = {"autopilot": flown.autopilot.name, "version": flown.version, "model": beyond}
        first = next(entry for entry in flights if entry.get("legs") or world)
        print_json({**first, **about, "remarks": remarks, "flights": flights})
    if is_useless:
        words = f"nothing in it was flown in {flown.autopilot.firmware_name}'s mission mode"
        if any(row.flight.in_mission for row in rows):
            words = _no_mission(log)
        raise LogUseless(words, hint="compare FILE LOG with the flown mission", place=log)
    if any(row.clearance is not None and not row.clearance.kept for row in rows):
        raise typer.Exit(1)


def _numbers(options: LogOptions, log: Path, count: int) -> Sequence[int]:
    if options.number is not None and options.number > count:
        raise BadInput(f"expected a number up to {count}, the flights in {log}", place=f"--flight {options.number}")
    return range(1, count + 1) if options.number is None else [options.number]


def _row(
    number: int, flight: "LoggedFlight", mission: "Mission | None", assumed: "Assumptions", world: "Scenario | None"
) -> _Row:
    from ipoa_mission.flight.post_flight import flown_clearance
    from ipoa_mission.report.compare import compare_logged

    compared = compare_logged(flight, mission, assumed) if flight.in_mission else None
    record = flight.record() if compared is None else compared.record
    flown_mission = None if compared is None else compared.forecast.mission
    clearance = None if world is None else flown_clearance(record, world, flown_mission)
    return _Row(number, flight, record, compared, clearance)


def _read_mission(file: Path, log: Path, autopilot: Autopilot, may_differ: bool) -> tuple["Mission", list[str]]:
    from ipoa_mission.cli.reading import read_requested

    states = may_differ and file.suffix.lower() == ".plan"
    requested = read_requested(file, FlownByOptions(), None if states else autopilot)
    mission = requested.mission
    if mission.autopilot is not autopilot:
        words = f"expected a mission for {autopilot}, as {log} is of it, not for {mission.autopilot}"
        hint = f"--autopilot {autopilot}, if that is what was flown"
        raise BadInput(words, hint=hint, code="other-autopilot", place=file)
    return mission, list(requested.remarks)


def _no_mission(log: Path) -> str:
    from ipoa_mission.logs.logged import log_format

    written = log_format(log.suffix)
    return "the log holds no upload or download of the mission" if written is None else written.no_mission


def _remarks(rows: list[_Row], log: Path, world: "Scenario | None") -> list[str]:
    several = len(rows) > 1
    alone = [row for row in rows if row.compared is None and row.flight.in_mission]
    remarks = [f"{f'flight {row.number}: ' if several else ''}{_no_mission(log)}: it has no estimate" for row in alone]
    if world is not None:
        remarks += list(world.remarks)
        remarks += [f"flight {row.number}: no path near {world.name}'s home" for row in rows if row.clearance is None]
    return remarks


def _as_json(row: _Row) -> dict[str, Any]:
    result: dict[str, Any] = {"flight": row.number, **picked(row.flight, "armed_s", "in_mission")}
    if row.compared is None:
        result["flown_s"] = round_finite(row.record.total_s, 4)
    else:
        result |= _compared_as_json(row.compared)
    if row.clearance is not None:
        result["clearance"] = _clearance_as_json(row.clearance)
    return result


def _clearance_as_json(flown: "FlownClearance") -> dict[str, Any]:
    nearest = flown.least.nearest
    place = dict(zip(("east", "north", "up"), (round(axis, 3) for axis in nearest.place), strict=True))
    return {
        "least": round(nearest.distance, 3),
        "to": nearest.what,
        "place": picked(flown.place, "latitude_deg", "longitude_deg", digits=7) | place,
        **picked(flown, "time_s", "kept"),
        "required": round(flown.least.required, 3),
        **picked(flown, "planned", "guaranteed"),
    }


def _compared_as_json(compared: "ComparedFlight") -> dict[str, Any]:
    times = compared.comparison
    return {
        **picked(compared.record, "completed", "why_not"),
        "estimated_s": round(times.estimated_total_s, 3),
        "flown_s": round_finite(times.flown_total_s, 4),
        "route_error": round_finite(times.route_error, 4),
        "total_error": round_finite(times.total_error, 4),
        "legs": [
            picked(leg, "seq", "estimated_s", "flown_s") | {"done_s": round(leg.flown_done_s, 3)} for leg in times.legs
        ],
        "parameters": compared.parameters,
        "remarks": list(compared.remarks),
    }


def _report(rows: list[_Row], title: str, remarks: list[str]) -> None:
    several = len(rows) > 1 or rows[0].compared is None
    if several:
        columns = ["flight", "armed at\ns", "items", "estimated\ns", "flown\ns", "total", "route", "clearance\nm", ""]
        print_table(title, columns, [_cells(row) for row in rows])
    for row in rows:
        if row.compared is not None:
            _print_compared(row.compared, f"flight {row.number}" if several else title)
        if row.clearance is not None:
            print_lines(f"flight {row.number}: {row.clearance.words()}" if several else row.clearance.words())
        if several and row.compared is not None:
            print_lines("")
    print_lines(*notes(remarks))


def _print_compared(compared: "ComparedFlight", title: str) -> None:
    comparison = compared.comparison
    rows = [
        (
            str(leg.seq),
            f"{leg.estimated_s:.1f}",
            f"{leg.flown_s:.1f}",
            f"{leg.error_s:+z.1f}",
            f"{leg.flown_done_s:.1f}",
        )
        for leg in comparison.legs
    ]
    print_table(title, ["item", "estimated\ns", "flown\ns", "difference\ns", "done at\ns"], rows)
    flown = f"{comparison.flown_total_s:.1f} s"
    if not math.isfinite(comparison.flown_total_s):
        flown = f"not completed: {compared.record.why_not}"
    print_lines(f"estimated {comparison.estimated_total_s:.1f} s, flown {flown}")
    if math.isfinite(comparison.route_error):
        print_lines(f"from the first waypoint to the last: {comparison.route_error:+z.1%}")
    if compared.parameters:
        print_lines("parameters: " + ", ".join(f"{name} {value:g}" for name, value in compared.parameters.items()))
    print_lines(*notes(compared.remarks))


def _cells(row: _Row) -> tuple[str, ...]:
    clearance = "" if row.clearance is None else f"{floor_cm(row.clearance.least.nearest.distance):.2f}"
    flight = (str(row.number), f"{row.flight.armed_s:.1f}")
    if row.compared is None:
        remark = "" if row.flight.in_mission else "not in a mission"
        return (*flight, "", "", _seconds(row.record.total_s), "", "", clearance, remark)
    totals = row.compared.comparison
    errors = (f"{error:+z.1%}" if math.isfinite(error) else "" for error in (totals.total_error, totals.route_error))
    items = f"{len(row.record.item_reached_s)} of {len(row.compared.forecast.mission.items)}"
    times = (f"{totals.estimated_total_s:.1f}", _seconds(totals.flown_total_s))
    return (*flight, items, *times, *errors, clearance, "")


def _seconds(value: float) -> str:
    return f"{value:.1f}" if math.isfinite(value) else ""
