"""The main job in order: scenario -> plan -> mission -> estimate. `plan` and `fly` begin with it."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ipoa_mission.cli.interrupting import left_behind
from ipoa_mission.cli.telling import progress_bar
from ipoa_mission.energy.flight import Consumption
from ipoa_mission.mission.assemble import Option, assemble, weigh_routes
from ipoa_mission.mission.build import build_mission
from ipoa_mission.mission.check import check_mission
from ipoa_mission.mission.files import read_mission
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.unsafe import refuse_errors
from ipoa_mission.mission.way_home import told as told_of_way_home
from ipoa_mission.mission.waypoints_file import left_out
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.scenario.budget import expect_to_come_home, flight_energy
from ipoa_mission.timing.estimate import Estimate, estimate
from ipoa_mission.timing.wind import CALM, Wind
from ipoa_mission.vehicle import Autopilot, Parameters

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Job:
    """A mission ready to fly; `remarks` are what its user should know."""

    name: str
    mission: Mission
    parameters: Parameters
    estimate: Estimate
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class PlannedJob(Job):
    """A job that began with a scenario."""

    scenario: Scenario
    plan: Plan
    energy: Consumption | None
    options: tuple[Option, ...]
    """What each way to choose waypoints would come to."""


def prepare(
    source: Path,
    seed: int = 0,
    autopilot: Autopilot | None = None,
    optimizer: str | None = None,
    parameters: Mapping[str, float] | None = None,
    wind: Wind = CALM,
) -> Job:
    """A job from a scenario (`.toml`) or a mission file.

    Raises:
        BadInput: the file is wrong.
        NoPath, NoRoute: no safe way was found.
        Unsafe: the mission fails a check.
        NotEnoughBattery: it would not come home with its reserve.
    """
    if source.suffix == ".toml":
        return plan_mission(adapt_scenario(source, optimizer, autopilot=autopilot, parameters=parameters), seed, wind)
    mission = read_mission(source, autopilot)
    log.info("%s: %d items for %s", source, len(mission.items), mission.autopilot)
    warnings = refuse_errors(check_mission(mission))
    remarks = tuple(finding.message for finding in warnings)
    return Job(source.stem, mission, parameters or {}, estimate(mission, parameters or {}, wind), remarks)


def plan_mission(scenario: Scenario, seed: int, wind: Wind = CALM) -> PlannedJob:
    """Plan, assemble, check, estimate, and see that the battery lasts; what fails does not come out.

    The wind counts for the estimate and for the energy along it; the route is chosen in calm air.
    """
    world = scenario.airspace
    log.info("%s: %d obstacles, planning by %s", scenario.name, len(world.obstacles), scenario.optimizer.name)
    with left_behind("nothing was written"), progress_bar("planning") as show:
        plan = plan_path(scenario, seed, show)
    log.info("%s: cost %.4f after %d evaluations", scenario.name, plan.history[-1], plan.evaluations[-1])
    options = weigh_routes(plan, scenario)
    chosen = [option.route for option in options if option.mode == scenario.route.mode]
    mission = build_mission(chosen[0], scenario) if chosen else assemble(plan, scenario)
    warnings = refuse_errors(check_mission(mission, scenario))
    known = scenario.vehicle.autopilot_parameters()
    found = estimate(mission, known, wind)
    track = found.track
    energy = flight_energy(scenario, track.times, track.points, track.speeds)
    expect_to_come_home(scenario, energy)
    found_out = (finding.message for finding in warnings)
    remarks = (*found_out, *told_of_way_home(mission), *scenario.remarks, *left_out(mission))
    return PlannedJob(scenario.name, mission, known, found, remarks, scenario, plan, energy, options)


def adapt_scenario(
    path: Path,
    optimizer: str | None = None,
    planner: str | None = None,
    polish: bool = True,
    autopilot: Autopilot | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Scenario:
    """The scenario in a file, with what the command line says in its place."""
    scenario = read_scenario(path)
    changes: dict[str, Any] = {}
    planning = ({"planner": planner} if planner else {}) | ({} if polish else {"polish": False})
    if planning:
        changes["planning"] = scenario.planning.model_copy(update=planning)
    if optimizer is not None and optimizer != scenario.optimizer.name:
        changes["optimizer"] = type(scenario.optimizer)(name=optimizer)
    vehicle: dict[str, Any] = {"autopilot": autopilot} if autopilot is not None else {}
    if parameters:
        vehicle["parameters"] = {**scenario.vehicle.parameters, **parameters}
    if vehicle:
        changes["vehicle"] = scenario.vehicle.model_copy(update=vehicle)
    return scenario.model_copy(update=changes)
