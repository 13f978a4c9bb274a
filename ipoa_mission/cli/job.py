"""What the command line was given to fly: a scenario that was planned here, or a mission file."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ipoa_mission.autopilots.parameters import expect_own
from ipoa_mission.autopilots.renamed import overridden
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.positions import refuse_unsound
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.cli.interrupting import left_behind
from ipoa_mission.cli.reading import read_with_parameters
from ipoa_mission.cli.telling import progress_bar
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.items import Mission
from ipoa_mission.learn.vehicle_file import read_vehicle
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.timing.estimate import Estimate, estimate
from ipoa_mission.wind import CALM, Wind

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Job:
    """A mission ready to fly; `remarks` are what its user should know, `flight` is where it was planned here."""

    name: str
    mission: Mission
    estimate: Estimate
    remarks: tuple[str, ...]
    flight: Flight | None = None
    wind: Wind = CALM


def read_job(
    source: Path,
    autopilot: Autopilot | None = None,
    parameters: Mapping[str, float] | None = None,
    wind: Wind | None = None,
    vehicle: Path | None = None,
) -> Job:
    """A job from a mission file.

    Raises:
        BadInput: the file is wrong.
        Unsafe: the mission fails a check.
    """
    mission, remarks = read_with_parameters(source, autopilot, parameters, vehicle)
    log.info("%s: %d items for %s", source, len(mission.items), mission.autopilot)
    warnings = refuse_errors(check_mission(mission))
    refuse_unsound(mission)
    remarks += tuple(finding.message for finding in warnings)
    air = wind or CALM
    return Job(source.stem, mission, estimate(mission, wind=air), remarks, wind=air)


def planned(flight: Flight) -> Job:
    """The job of a flight that was planned here."""
    return Job(flight.name, flight.mission, flight.estimate, flight.remarks, flight, flight.scenario.wind.air())


def plan(scenario: Scenario, seed: int, wind: Wind | None = None) -> Flight:
    """`plan_flight` with a bar that shows how far it is."""
    with left_behind("nothing was written"), progress_bar("planning") as show:
        return plan_flight(scenario, seed, wind, show)


def adapt_scenario(
    path: Path,
    optimizer: str | None = None,
    planner: str | None = None,
    polish: bool = True,
    autopilot: Autopilot | None = None,
    parameters: Mapping[str, float] | None = None,
    vehicle: Path | None = None,
) -> Scenario:
    """The scenario in a file, with what the command line says in its place."""
    scenario = read_scenario(path)
    changes: dict[str, Any] = {}
    planning = ({"planner": planner} if planner else {}) | ({} if polish else {"polish": False})
    if planning:
        changes["planning"] = scenario.planning.model_copy(update=planning)
    if optimizer is not None and optimizer != scenario.optimizer.name:
        changes["optimizer"] = type(scenario.optimizer)(name=optimizer)
    changed: dict[str, Any] = {"autopilot": autopilot} if autopilot is not None else {}
    if parameters:
        changed["parameters"] = overridden(scenario.vehicle.parameters, parameters)
    if changed or vehicle:
        expect_own(changed.get("parameters", scenario.vehicle.parameters), autopilot or scenario.vehicle.autopilot)
        changes["vehicle"] = scenario.vehicle.model_copy(update=changed)
    if vehicle is not None:
        changes["vehicle"] = changes["vehicle"].learned_as(read_vehicle(vehicle, changes["vehicle"].autopilot))
    return scenario.model_copy(update=changes)
