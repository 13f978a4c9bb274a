"""`fly`: a mission in the air, on a real vehicle or on the built-in autopilot."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ipoa_mission.cli.folders import expect_folder, make_folder
from ipoa_mission.cli.interrupting import left_behind
from ipoa_mission.cli.options import (
    AnywayOption,
    AutopilotOption,
    BackendOption,
    DelayOption,
    DuplicateOption,
    FileOrScenario,
    ForceOption,
    FromOption,
    JsonOption,
    KeyOption,
    LearnedOption,
    LogOption,
    LossOption,
    NakOption,
    OptimizerOption,
    OutOption,
    ParameterFileOption,
    ParameterOption,
    PlannerOption,
    PolishOption,
    ReorderOption,
    ReportOption,
    SeedOption,
    SetParametersOption,
    SystemOption,
    TimeoutOption,
    VehicleOption,
    WindOption,
    WindProfileOption,
    read_parameter_options,
    read_wind_option,
)
from ipoa_mission.cli.telling import notes, progress_bar, tell, tell_json, tell_table
from ipoa_mission.cli.vehicles import Backend, connect_to, states_firmware

if TYPE_CHECKING:
    from ipoa_mission.flight.flight import Flight
    from ipoa_mission.link.logbook import FlightRecord
    from ipoa_mission.timing.estimate import Estimate


def fly(
    source: FileOrScenario,
    out: OutOption = Path(),
    seed: SeedOption = 0,
    optimizer: OptimizerOption = None,
    planner: PlannerOption = None,
    polish: PolishOption = True,
    autopilot: AutopilotOption = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    wind: WindOption = None,
    wind_profile: WindProfileOption = None,
    vehicle: LearnedOption = None,
    report: ReportOption = False,
    force: ForceOption = False,
    as_json: JsonOption = False,
    link: VehicleOption = None,
    system: SystemOption = None,
    log: LogOption = None,
    key: KeyOption = None,
    timeout: TimeoutOption = None,
    backend: BackendOption = Backend.BUILTIN,
    anyway: AnywayOption = False,
    begin: FromOption = 1,
    set_params: SetParametersOption = False,
    loss: LossOption = 0.0,
    duplicate: DuplicateOption = 0.0,
    delay: DelayOption = 0.0,
    reorder: ReorderOption = 0.0,
    nak_at: NakOption = None,
) -> None:
    """Fly a mission from upload to landing, and hold the flown time against the estimate.

    A scenario is planned first and its mission files are written. Without `--link` the built-in autopilot flies it, as
    fast as it goes. With `--link` a vehicle on the ground is waited for until it is ready, armed, started at its first
    item, and watched. Every frame goes to the log. Exit code 0: it landed and was disarmed where its mission ends.

    Example: `ipoa-mission fly missions/campus.toml --out out --report`
    """
    from ipoa_mission.checks.start import begun_at
    from ipoa_mission.cli.checking import route_in_words
    from ipoa_mission.cli.job import adapt_scenario, plan, planned, read_job
    from ipoa_mission.cli.overwriting import expect_free, expect_log
    from ipoa_mission.cli.real_flight import RealFlight, no_flight_yet
    from ipoa_mission.cli.summary import describe, tell_routes
    from ipoa_mission.errors import BadInput
    from ipoa_mission.files import unused
    from ipoa_mission.flight.landed import landed_elsewhere
    from ipoa_mission.flight.summary import passed_over_as_json
    from ipoa_mission.flight.written import not_as_written
    from ipoa_mission.mission.firmware import to_wire
    from ipoa_mission.simulator.faults import Faults
    from ipoa_mission.timing.estimate import estimate

    faults = Faults(loss, duplicate, delay, reorder, nak_at=nak_at)
    is_planned = source.suffix.lower() == ".toml"
    if not is_planned:
        for option, is_given in {"--report": report, "--optimizer": optimizer, "--planner": planner}.items():
            if is_given:
                raise BadInput(f"{option}: expected a scenario, not {source}", hint="a mission is flown as it is")
    if link is None and (begin != 1 or set_params):
        raise BadInput(
            "--from, --set-params: expected with --link", hint="the built-in autopilot begins at the first item"
        )
    if link is not None and not (faults.is_none and nak_at is None):
        raise BadInput("--link: expected without --loss, --duplicate, --delay, --reorder and --nak-at")
    expect_folder(out)
    expect_log(log)
    air = read_wind_option(wind, wind_profile)
    parameters = read_parameter_options(param, param_file)
    if is_planned:
        scenario = adapt_scenario(source, optimizer, planner, polish, autopilot, parameters, vehicle)
        expect_free(not_as_written(out, scenario.name, report), force, ask=not as_json)
        job = planned(plan(scenario, seed, air))
    else:
        job = read_job(source, autopilot, parameters, air, vehicle)
    if nak_at is not None and nak_at >= (sent := len(to_wire(job.mission))):
        raise BadInput(f"--nak-at: expected a number from 0 to {sent - 1}, not {nak_at}: {sent} items are sent")
    make_folder(out)
    written: list[Path] = []
    if job.flight is not None:
        written += job.flight.write(out)
        if not as_json:
            tell(*describe(job.flight))
            tell_routes(job.flight)
            tell(f"written: {', '.join(map(str, written))}")
    missions = len(written)
    usual = out / f"{job.name}.tlog"
    given_log, log = log, log or (usual if link is None else unused(usual))
    told: tuple[str, ...] = ()
    if link is None:
        from ipoa_mission.simulator.fly import fly as fly_here

        with left_behind(f"the flight was broken off; {log} has it so far"), progress_bar("flying") as bar:
            record = fly_here(job.mission, {}, seed, faults, log, flying=bar, wind=job.wind)
    else:
        begun_at(job.mission, begin - 1)
        with no_flight_yet(), connect_to(link, system, key, backend, given_log, log, timeout, anyway) as flown:
            if not states_firmware(source, autopilot):
                job = read_job(source, flown.autopilot, parameters, air, vehicle)
            if begin != 1:
                job = replace(job, estimate=estimate(begun_at(job.mission, begin - 1), wind=job.wind))
            flight = RealFlight(job, flown, begin - 1, anyway, set_params)
            told, record = flight.fly()
    told += landed_elsewhere(job.mission, record, job.wind)
    remarks = told if job.flight else tuple(dict.fromkeys((*job.remarks, *told)))
    if report and job.flight is not None:
        written.append(out / f"{job.name}.html")
        job.flight.report(written[-1], record)
    if backend is Backend.BUILTIN:
        written.append(log)
    if as_json:
        said = list(dict.fromkeys((*job.remarks, *remarks)))
        known = flight_as_json(job.estimate, record) | {"remarks": said, "written": [str(path) for path in written]}
        if job.flight is not None:
            known["passed_over"] = passed_over_as_json(job.flight.scenario)
        tell_json(known | ({"error": record.why_not} if record.why_not else {}))
    else:
        tell(*notes(remarks), *(() if record.completed else record.messages))
        columns = ["item", "command", "estimated\ns", "flown\ns", "difference\ns"]
        tell_table(
            f"{job.name} on {job.mission.autopilot}: when each item was done", columns, _legs(job.estimate, record)
        )
        tell(
            *([] if job.flight else route_in_words(job.estimate)),
            f"estimated {job.estimate.total_s:.1f} s, flown {record.total_s:.1f} s; "
            f"{_kept(job.flight)}QGroundControl would have said {job.estimate.qgroundcontrol_s:.0f} s",
        )
        tell(f"written: {', '.join(map(str, written[missions:]))}")
    if record.why_not:
        if not as_json:
            tell(f"not complete: {record.why_not}")
        raise typer.Exit(1)


def flight_as_json(found: "Estimate", record: "FlightRecord") -> dict[str, Any]:
    """Estimate and flight for machines; items are numbered as in the file, where home is 0."""
    from ipoa_mission.cli.checking import estimate_as_json

    return {
        "completed": record.completed,
        "armed": record.armed,
        "in_air": record.in_air,
        "flown_s": round(record.total_s, 3),
        "time_zero": "armed",
        "items": [{"seq": index + 1, "done_s": round(at, 3)} for index, at in sorted(record.item_reached_s.items())],
        "estimate": estimate_as_json(found),
        "messages": list(record.messages),
    }


def _kept(flight: "Flight | None") -> str:
    """The clearance that flights keep, for the last line; nothing where none is known."""
    kept = None if flight is None else flight.promise.clearance
    if flight is None or kept is None or flight.promise.confidence is None:
        return ""
    return f"{100 * flight.promise.confidence:g} of 100 flights keep {kept.kept:.1f} m; "


def _legs(found: "Estimate", record: "FlightRecord") -> list[tuple[str, ...]]:
    from ipoa_mission.commands import command_name

    rows: list[tuple[str, ...]] = []
    for item in found.items:
        flown = record.item_reached_s.get(item.seq - 1)
        told = ("", "") if flown is None else (f"{flown:.1f}", f"{item.done_s - flown:+.1f}")
        rows.append((str(item.seq), command_name(item.command), f"{item.done_s:.1f}", *told))
    return rows
