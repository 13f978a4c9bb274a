import sys
from functools import partial
from itertools import compress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.cli.groups import FaultOptions, FileOutput, FlightOptions, FlownByOptions, SearchOptions
from ipoa_mission.cli.interrupting import note_flown, reporting_interrupt, showing_planning
from ipoa_mission.cli.options import NAMES, ForceOption, JsonOption, OutOption, SeedOption, or_packed
from ipoa_mission.cli.output import expect_folder, expect_log, progress_bar, shown
from ipoa_mission.cli.planners import FlyJob, FlyOptions, planner_of, planners
from ipoa_mission.errors import OptionConflict
from ipoa_mission.files import in_folder

if TYPE_CHECKING:
    from ipoa_mission.cli.mission_source import FlownJob, Job
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
    asked: FlyOptions,
    worse: FaultOptions,
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
    from ipoa_mission.cli.mission_source import adapt_scenario, planned, read_job
    from ipoa_mission.flight.flight import plan_flight
    from ipoa_mission.scenario import read_scenario

    search, flown_by, on_link, to = asked.search, asked.flown_by, asked.on_link, asked.files
    is_planned, link, ignore = source.suffix.lower() == ".toml", asked.on_vehicle.link, asked.ignore or ()
    if not is_planned:
        _expect_no_plan(source, {"--report": to.report, "--optimizer": search.optimizer})
    faults = worse.faults()
    _expect_together(asked.on_vehicle, faults)
    expect_folder(to.folder)
    expect_log(on_link.log)
    fly_job: FlyJob = partial(_fly_built_in, seed=search.seed, faults=faults)
    if link is not None:
        from ipoa_mission.cli.real_flight import RealVehicle

        fly_job = RealVehicle(source, asked).fly
    if is_planned:
        scenario = adapt_scenario(read_scenario(source).ignoring(ignore), search, flown_by)
        if (planner := planner_of(scenario, [make() for make in planners()])) is not None:
            planner.fly(scenario, asked, fly_job)
            return
        to.expect_plans([scenario.name])
        with showing_planning() as show:
            job = planned(plan_flight(scenario, wind=flown_by.air, seed=search.seed, progress=show))
    else:
        job = read_job(source, flown_by, ignore=ignore)
    with in_folder(to.folder):
        planned_files = [] if job.flight is None else [*job.flight.write(to.folder)]
        if job.flight is not None and not to.as_json:
            print_planned(job.flight, planned_files)
        flown = fly_job(job, log := asked.log_of(job.name))
    written = [*map(Path, on_link.written(log))]
    if to.report and job.flight is not None:
        job.flight.report(page := to.folder / f"{job.name}.html", flown.record)
        written.insert(0, page)
    hint = next_steps(link, on_link.system, flown.record)
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


def _fly_built_in(job: "Job", log: Path, *, seed: int, faults: "Faults") -> "FlownJob":
    from ipoa_mission.cli.mission_source import FlownJob, landing_remarks
    from ipoa_mission.simulator.fly import board, conditions_for, fly_aboard

    conditions = conditions_for(job.mission, job.forecast.wind, job.forecast.ground, seed)
    with (
        reporting_interrupt(f"{log} has the part flown"),
        progress_bar("flying") as bar,
        board(job.mission, conditions, faults, log) as vehicle,
    ):
        record = fly_aboard(vehicle, job.mission, flying=bar)
    note_flown(job.name, record.armed)
    return FlownJob(job, landing_remarks(job, record), record)


def _expect_no_plan(source: Path, options: dict[str, object]) -> None:
    for option, value in options.items():
        if value:
            raise OptionConflict(f"expected a scenario, not {source}", hint="a mission is flown as it is", place=option)


def _expect_together(on_vehicle: FlightOptions, faults: "Faults") -> None:
    """Refuse a vehicle's options without a link, and the built-in autopilot's with one."""
    if on_vehicle.link is None and on_vehicle != (usual := FlightOptions()):
        changed = (on_vehicle.begin != 1, on_vehicle.set_params, on_vehicle.on_deviation != usual.on_deviation)
        raise OptionConflict(
            "needs --link",
            hint="the built-in autopilot begins at the first item, and flies by the forecast's model",
            place=", ".join(compress(("--from", "--set-params", "--on-deviation"), changed)),
        )
    if on_vehicle.link is not None and not faults.is_none:
        raise OptionConflict(
            "cannot be combined with --loss, --duplicate, --delay or --reorder",
            hint="they are for the built-in autopilot, which flies without --link",
            place="--link",
        )


def demo(
    out: OutOption = Path("demo"), seed: SeedOption = 0, force: ForceOption = False, as_json: JsonOption = False
) -> None:
    """Plan a flight over a campus, write its files, fly it on the built-in autopilot, and report.

    The files go to the folder `demo`: campus.plan for QGroundControl, campus.html for a browser. It equals
    `ipoa-mission fly campus --out demo --report`.

    Example: `ipoa-mission demo`
    """
    files = FileOutput(out, report=True, force=force, as_json=as_json)
    fly(or_packed(Path(NAMES[0])), FlyOptions(SearchOptions(seed), FlownByOptions(), files=files), FaultOptions())
