import logging
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.cli.groups import FileOutput, FlownByOptions, SearchOptions
from ipoa_mission.cli.interrupting import ChangesMade, interruptible
from ipoa_mission.cli.linking import connect_to, states_firmware
from ipoa_mission.cli.planners import FlyJob, FlyOptions, planner_of, planners
from ipoa_mission.errors import MissionError, OptionConflict
from ipoa_mission.files import in_folder
from ipoa_mission.options import NAMES, ForceOption, JsonOption, OutOption, SeedOption, argument, or_packed
from ipoa_mission.terminal import expect_folder, expect_log, notes, print_json, print_lines, progress_bar, shown

if TYPE_CHECKING:
    from ipoa_mission.cli.mission_source import FlownJob, Job
    from ipoa_mission.flight.procedure import Stage
    from ipoa_mission.forecast.forecast import Forecast
    from ipoa_mission.link.vehicle import Vehicle
    from ipoa_mission.mission.flight_record import FlightRecord
    from ipoa_mission.progress import Progress

log = logging.getLogger(__name__)


@interruptible
def fly(
    changes: ChangesMade,
    source: Annotated[
        Path,
        argument(
            "SCENARIO|FILE",
            "Scenario (.toml, or `campus`) to plan first, or mission (.plan, .waypoints).",
            callback=or_packed,
        ),
    ],
    asked: FlyOptions,
) -> None:
    """Fly a mission from upload to landing, and compare the flown time with the estimate.

    A scenario is planned first and its mission files are written. Without `--link` the built-in autopilot flies it, as
    fast as possible. With `--link` the vehicle must be on the ground; it is armed when ready, started at its first
    item, and watched. Position and progress are compared with the forecast; a vehicle that deviates is ordered to hold
    (`--on-deviation`). Every frame goes to the log. Exit code 0: it landed and was disarmed at the forecast end of its
    mission; after an RTL that may be a rally point.

    Example: `ipoa-mission fly missions/campus.toml --out out --report`
    """
    from ipoa_mission.cli.flight_output import next_steps, print_flown, print_flown_json, print_planned
    from ipoa_mission.cli.mission_source import Job, adapt_scenario, read_job
    from ipoa_mission.flight.flight import plan_flight
    from ipoa_mission.scenario import read_scenario

    search = asked.search
    flown_by = asked.flown_by
    to = asked.files
    is_planned = source.suffix.lower() == ".toml"
    link = asked.on_vehicle.link
    ignore = asked.ignore or ()
    _expect_fitting(asked, source)
    expect_folder(to.folder)
    expect_log(asked.on_link.log)
    fly_job: FlyJob = partial(_fly_built_in, changes, search.seed)
    if link is not None:
        fly_job = partial(_fly_on_link, changes, source, asked)
    if is_planned:
        scenario = adapt_scenario(read_scenario(source).ignoring(ignore), search, flown_by)
        planner = planner_of(scenario, [make() for make in planners()])
        if planner is not None:
            given = {"--depart-at": asked.on_vehicle.departure is not None}
            _refuse(given, "expected a single flight", "plan, then fly each mission")
            planner.fly(scenario, asked, fly_job, changes)
            return
        to.expect_plans([scenario.name])
        with changes.planning() as show:
            flight = plan_flight(scenario, wind=flown_by.air, seed=search.seed, progress=show)
        job = Job(flight.name, flight.forecast, flight.remarks, flight)
    else:
        job = read_job(source, flown_by, ignore, on_link=link is not None)
        _print_notes(asked, job.remarks)
    with in_folder(to.folder):
        planned_files = [] if job.flight is None else [*job.flight.write(to.folder)]
        if job.flight is not None and not to.as_json:
            print_planned(job.flight, planned_files)
        frames_log = asked.log_of(job.name)
        flown = fly_job(job, frames_log)
    written = [*map(Path, asked.on_link.written(frames_log))]
    if to.report and job.flight is not None:
        page = to.folder / f"{job.name}.html"
        job.flight.report(page, flown.record)
        written.insert(0, page)
    hint = next_steps(link, flown.system, flown.record)
    if to.as_json:
        print_flown_json(flown, [*planned_files, *written], hint)
        if flown.record.failure:
            print(f"error: {shown(flown.record.failure)}", file=sys.stderr)
    else:
        print_flown(flown, written)
    if hint:
        print(f"hint: {hint}", file=sys.stderr)
    if flown.record.failure:
        raise typer.Exit(1)


def _fly_built_in(changes: ChangesMade, seed: int, job: "Job", frames_log: Path) -> "FlownJob":
    from ipoa_mission.cli.mission_source import FlownJob
    from ipoa_mission.flight.post_flight import landed_elsewhere
    from ipoa_mission.simulator.fly import board, conditions_for, fly_aboard

    conditions = conditions_for(job.mission, job.forecast.wind, job.forecast.ground, seed)
    with (
        changes.reporting(f"{frames_log} has the part flown"),
        progress_bar("flying") as bar,
        board(job.mission, conditions, log=frames_log) as vehicle,
    ):
        record = fly_aboard(vehicle, job.mission, flying=bar)
    changes.note_flown(job.name, record.armed)
    return FlownJob(job, landed_elsewhere(job.forecast, record), record)


def _fly_on_link(changes: ChangesMade, source: Path, asked: FlyOptions, job: "Job", frames_log: Path) -> "FlownJob":
    from ipoa_mission.checks.unsafe import begun_forecast
    from ipoa_mission.cli.mission_source import FlownJob, read_job
    from ipoa_mission.flight.post_flight import landed_elsewhere

    on_vehicle = asked.on_vehicle
    first = on_vehicle.begin - 1
    begun_forecast(job.forecast, first)  # an unknown item is an error before connecting
    try:
        options = replace(asked.on_link, system=asked.on_link.system if job.system is None else job.system)
        with connect_to(on_vehicle.link or "", options, frames_log) as vehicle:
            if not states_firmware(source, asked.flown_by.autopilot):
                before = job.remarks
                flown_by = replace(asked.flown_by, autopilot=vehicle.autopilot)
                job = read_job(source, flown_by, job.ignore, on_link=True)
                _print_notes(asked, [words for words in job.remarks if words not in before])
            vehicle.conformance.on_deviation = on_vehicle.on_deviation
            if asked.files.as_json:
                vehicle.conformance.report = lambda deviation: print_json(
                    {"event": "deviation"} | deviation.as_json(), indent=None
                )
            planned = job.forecast
            aboard = planned.on(vehicle.firmware_version())
            job = replace(job, forecast=aboard, begun=begun_forecast(aboard, first))
            job, remarks, record = _fly_stages(changes, asked, vehicle, job, planned)
            changes.note_flown(job.name, record.armed)
    except MissionError as error:
        error.known = {"completed": False, "armed": None, "in_air": None} | error.known
        raise
    left = ("the vehicle is no longer watched", vehicle.link_loss.meanwhile)
    unwatched = ["; ".join(filter(None, left))] if record.armed else []
    noted = remarks if asked.files.as_json else ()  # else printed as they arose
    return FlownJob(job, (*noted, *unwatched, *landed_elsewhere(job.forecast, record)), record, vehicle.system)


def _print_notes(asked: FlyOptions, remarks: "Sequence[str]") -> None:
    if not asked.files.as_json:
        print_lines(*notes(remarks))


def _fly_stages(
    changes: ChangesMade, asked: FlyOptions, vehicle: "Vehicle", job: "Job", planned: "Forecast"
) -> "tuple[Job, list[str], FlightRecord]":
    from ipoa_mission.cli.flight_output import flight_as_json
    from ipoa_mission.flight import procedure
    from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow

    remarks = list[str]()
    contingencies = list[ContingenciesNow]()
    flown = job.forecast

    def remark(words: str) -> None:
        if words not in remarks:  # a new attempt to arm repeats them
            remarks.append(words)
            _print_notes(asked, [words])

    @contextmanager
    def stages(stage: "Stage") -> "Iterator[Progress]":
        with changes.stage(stage, f"{asked.on_vehicle.link} --system {vehicle.system}") as show:
            if stage is procedure.Stage.READY and flown.scenario is not None:
                try:
                    contingencies.append(ContingenciesNow(flown))
                except MissionError as why:
                    remark(f"contingencies are not shown in flight: {why}")
            if stage is procedure.Stage.FLIGHT and contingencies:
                display = procedure.ContingencyDisplay(flown, vehicle, show, job.reserves, contingencies[0])
                vehicle.overhearing = display.hear
                show = display.show
            yield show

    on_vehicle = asked.on_vehicle
    first = on_vehicle.begin - 1
    options = procedure.ProcedureOptions(
        first=first,
        anyway=asked.on_link.anyway,
        ignore=job.ignore,
        set_params=on_vehicle.set_params,
        stages=stages,
        remark=remark,
        checked=True,
        depart_at=on_vehicle.departure,
    )
    try:
        with changes.reporting(""):  # between two stages
            loaded = procedure.load_mission(vehicle, planned, options)
            flown = procedure.begun_here(vehicle, loaded, first)
            job = replace(job, forecast=loaded, begun=flown)
            log.info("estimated %.1f s%s", job.estimate.total_s, job.estimate.besides)
            record = procedure.begin_mission(vehicle, loaded, options)
    except MissionError as error:
        state = vehicle.state
        ended = {"completed": False, "armed": state.armed, "in_air": state.in_air, "remarks": remarks}
        error.known = ended | error.known
        with suppress(MissionError):
            error.known = flight_as_json(job.estimate, vehicle.record(), job.reserves) | error.known
        raise
    return job, remarks, record


def _expect_fitting(asked: FlyOptions, source: Path) -> None:
    if source.suffix.lower() != ".toml":
        of_planning = {"--report": asked.files.report, "--optimizer": asked.search.optimizer is not None}
        _refuse(of_planning, f"expected a scenario, not {source}", "a mission is flown as it is")
    if asked.on_vehicle.link is None:
        hint = "the built-in autopilot begins at the first item, and flies by the forecast's model"
        _refuse(asked.on_vehicle.given_for_link(), "needs --link", hint)


def _refuse(options: dict[str, bool], words: str, hint: str) -> None:
    given = [option for option, is_given in options.items() if is_given]
    if given:
        raise OptionConflict(words, hint=hint, place=", ".join(given))


def demo(
    out: OutOption = Path("demo"), seed: SeedOption = 0, force: ForceOption = False, as_json: JsonOption = False
) -> None:
    """Plan a flight over a campus, write its files, fly it on the built-in autopilot, and report.

    The files go to the folder `demo`: campus.plan for QGroundControl, campus.html for a browser. It equals
    `ipoa-mission fly campus --out demo --report`.

    Example: `ipoa-mission demo`
    """
    files = FileOutput(out, report=True, force=force, as_json=as_json)
    fly(or_packed(Path(NAMES[0])), FlyOptions(SearchOptions(seed), FlownByOptions(), files=files))
