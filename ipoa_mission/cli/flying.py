import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.cli.groups import FaultOptions, FlightOptions, FlownByOptions, LinkOptions, SearchOptions
from ipoa_mission.cli.interrupting import reporting_interrupt
from ipoa_mission.cli.options import (
    NAMES,
    ForceOption,
    IgnoreOption,
    JsonOption,
    OutOption,
    ReportOption,
    SeedOption,
    or_packed,
)
from ipoa_mission.cli.output import progress_bar, shown
from ipoa_mission.cli.overwriting import expect_folder
from ipoa_mission.cli.vehicles import connect_to, note_flown, states_firmware
from ipoa_mission.errors import OptionConflict
from ipoa_mission.files import in_folder

if TYPE_CHECKING:
    from ipoa_mission.cli.mission_source import Job
    from ipoa_mission.cli.surveying import Pilot, Piloted
    from ipoa_mission.flight.flight import Flight
    from ipoa_mission.link.logbook import FlightRecord
    from ipoa_mission.simulator.faults import Faults


def fly(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SCENARIO|FILE",
            callback=or_packed,
            help="Scenario (.toml, or `campus`) to plan first, or mission (.plan, .waypoints).",
        ),
    ],
    search: SearchOptions,
    on_vehicle: FlightOptions,
    flown_by: FlownByOptions,
    on_link: LinkOptions,
    worse: FaultOptions,
    ignore: IgnoreOption = None,
    out: OutOption = Path(),
    report: ReportOption = False,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fly a mission from upload to landing, and compare the flown time with the estimate.

    A scenario is planned first and its mission files are written. Without `--link` the built-in autopilot flies it, as
    fast as possible. With `--link` the vehicle must be on the ground; it is armed when ready, started at its first
    item, and watched. Position and progress are compared with the forecast; a vehicle that deviates is ordered to hold
    (`--on-deviation`). Every frame goes to the log. Exit code 0: it landed and was disarmed at the forecast end of its
    mission; after an RTL that may be a rally point.

    Example: `ipoa-mission fly missions/campus.toml --out out --report`
    """
    from ipoa_mission.cli.flown_output import next_steps, print_flown, print_flown_json
    from ipoa_mission.cli.mission_source import adapt_scenario, plan, planned, read_job
    from ipoa_mission.cli.overwriting import expect_log, expect_plans
    from ipoa_mission.cli.surveying import EACH_BY_ITSELF, expect_flyable, fly_survey, plan_here, write_survey
    from ipoa_mission.files import unused
    from ipoa_mission.scenario import read_scenario

    is_planned = source.suffix.lower() == ".toml"
    if not is_planned:
        _expect_no_plan(source, {"--report": report, "--optimizer": search.optimizer})
    faults = worse.faults()
    link = on_vehicle.link
    _expect_together(on_vehicle, faults)
    expect_folder(out)
    expect_log(on_link.log)
    air = flown_by.air
    here = partial(_fly_here, seed=search.seed, faults=faults)
    there = partial(
        _fly_there, source=source, flown_by=flown_by, on_vehicle=on_vehicle, on_link=on_link, as_json=as_json
    )
    pilot: Pilot = here if link is None else there
    if is_planned:
        scenario = adapt_scenario(read_scenario(source).ignoring(ignore or ()), search, flown_by)
        if scenario.survey is not None:
            if on_vehicle.begin != 1:
                raise OptionConflict("expected a mission, not a survey", hint=EACH_BY_ITSELF, place="--from")
            survey = plan_here(scenario, search, flown_by)
            expect_flyable(survey, on_link.log, is_on_link=link is not None)
            files = write_survey(survey, out, report, force, as_json)
            fly_survey(survey, pilot, on_link, out, files, as_json, link)
            return
        expect_plans(out, [scenario.name], report, force, ask=not as_json)
        job = planned(plan(scenario, search.seed, air))
    else:
        job = read_job(source, flown_by, ignore=ignore or ())
    with in_folder(out):
        planned_files = [] if job.flight is None else _write(job.flight, out, as_json)
        usual = out / f"{job.name}.tlog"
        log = on_link.log or (usual if link is None else unused(usual))
        job, remarks, record = pilot(job, log)
    written = [*map(Path, on_link.written(log))]
    if report and job.flight is not None:
        job.flight.report(page := out / f"{job.name}.html", record)
        written.insert(0, page)
    hint = next_steps(link, on_link.system, record)
    if as_json:
        print_flown_json(job, record, remarks, [*planned_files, *written], hint)
        if record.failure:
            print(f"error: {shown(record.failure)}", file=sys.stderr)
    else:
        print_flown(job, record, remarks, written)
    if hint:
        print(f"hint: {hint}", file=sys.stderr)
    if record.failure:
        raise typer.Exit(1)


def _fly_here(job: "Job", log: Path, *, seed: int, faults: "Faults") -> "Piloted":
    from ipoa_mission.simulator.fly import fly_forecast

    with reporting_interrupt(f"{log} has the part flown"), progress_bar("flying") as bar:
        record = fly_forecast(job.forecast, seed, faults, log, flying=bar)
    note_flown(job.name, record.armed)
    return job, _where_it_landed(job, record), record


def _fly_there(
    job: "Job",
    log: Path,
    *,
    source: Path,
    flown_by: FlownByOptions,
    on_vehicle: FlightOptions,
    on_link: LinkOptions,
    as_json: bool,
) -> "Piloted":
    from ipoa_mission.cli.mission_source import read_job
    from ipoa_mission.cli.real_flight import begun_with, fly_there, no_flight_yet, print_deviation

    begin = on_vehicle.begin
    begun_with(job, begin)  # raises for an unknown item before connecting
    with no_flight_yet(), connect_to(on_vehicle.link or "", on_link, log) as there:
        if not states_firmware(source, flown_by.autopilot):
            job = read_job(source, flown_by, there.autopilot, job.ignore)
        there.conformance.on_deviation = on_vehicle.on_deviation
        if as_json:
            there.conformance.tell = print_deviation
        on_link.system = there.system  # the next flight is this vehicle's, whatever else is heard
        job = begun_with(replace(job, forecast=job.forecast.on(there.firmware_version())), begin)
        remarks, record = fly_there(job, there, begin - 1, on_link.anyway, on_vehicle.set_params)
        note_flown(job.name, record.armed)
    left = ("the vehicle is no longer watched", there.absence.meanwhile)
    unwatched = ["; ".join(filter(None, left))] if record.armed else []
    return job, (*remarks, *unwatched, *_where_it_landed(job, record)), record


def _where_it_landed(job: "Job", record: "FlightRecord") -> tuple[str, ...]:
    from ipoa_mission.flight.post_flight import landed_at_rally, landed_elsewhere

    return landed_at_rally(job.mission, record) + landed_elsewhere(job.forecast, record)


def _expect_no_plan(source: Path, options: dict[str, object]) -> None:
    for option, value in options.items():
        if value:
            raise OptionConflict(f"expected a scenario, not {source}", hint="a mission is flown as it is", place=option)


def _expect_together(on_vehicle: FlightOptions, faults: "Faults") -> None:
    """Refuse a vehicle's options without a link, and the built-in autopilot's with one."""
    if on_vehicle.link is None and on_vehicle != FlightOptions():
        words = "--from, --set-params, --on-deviation: expected with --link"
        raise OptionConflict(
            words, hint="the built-in autopilot begins at the first item, and flies by the forecast's model"
        )
    if on_vehicle.link is not None and not faults.is_none:
        raise OptionConflict(
            "expected without --loss, --duplicate, --delay and --reorder",
            hint="they are for the built-in autopilot, which flies without --link",
            place="--link",
        )


def _write(flight: "Flight", folder: Path, as_json: bool) -> list[Path]:
    from ipoa_mission.cli.plan_output import print_planned

    written = [*flight.write(folder)]
    if not as_json:
        print_planned(flight, written)
    return written


def demo(
    out: OutOption = Path("demo"), seed: SeedOption = 0, force: ForceOption = False, as_json: JsonOption = False
) -> None:
    """Plan a flight over a campus, write its files, fly it on the built-in autopilot, and report.

    The files go to the folder `demo`: campus.plan for QGroundControl, campus.html for a browser. It equals
    `ipoa-mission fly campus --out demo --report`.

    Example: `ipoa-mission demo`
    """
    ways = SearchOptions(seed=seed), FlightOptions(), FlownByOptions(), LinkOptions(), FaultOptions()
    fly(or_packed(Path(NAMES[0])), *ways, out=out, report=True, force=force, as_json=as_json)
