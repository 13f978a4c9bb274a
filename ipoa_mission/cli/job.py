"""What the command line was given to fly: a scenario that was planned here, or a mission file."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.positions import refuse_unsound
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.cli.groups import FlownByOptions, SearchOptions
from ipoa_mission.cli.interrupting import left_behind
from ipoa_mission.cli.reading import read_with_parameters
from ipoa_mission.cli.telling import progress_bar
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.items import Mission
from ipoa_mission.learn.vehicle_file import read_vehicle
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.timing.estimate import Estimate, estimate
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.known_parameters import expect_own
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


def read_job(source: Path, flown_by: FlownByOptions, autopilot: Autopilot | None = None) -> Job:
    """A job from a mission file; `autopilot` flies it where nobody says another.

    Raises:
        BadInput: the file is wrong.
        Unsafe: the mission fails a check.
    """
    mission, remarks = read_with_parameters(
        source, flown_by.autopilot or autopilot, flown_by.parameters, flown_by.vehicle, flown_by.version
    )
    log.info("%s: %d items for %s", source, len(mission.items), mission.autopilot)
    warnings = refuse_errors(check_mission(mission))
    refuse_unsound(mission)
    remarks += tuple(finding.message for finding in warnings)
    air = flown_by.air or CALM
    return Job(source.stem, mission, estimate(mission, wind=air), remarks, wind=air)


def planned(flight: Flight) -> Job:
    """The job of a flight that was planned here."""
    return Job(flight.name, flight.mission, flight.estimate, flight.remarks, flight, flight.scenario.wind.air())


def plan(scenario: Scenario, seed: int, wind: Wind | None = None) -> Flight:
    """`plan_flight` with a bar that shows how far it is."""
    with left_behind("nothing was written"), progress_bar("planning") as show:
        return plan_flight(scenario, seed, wind, show)


def adapt_scenario(path: Path, search: SearchOptions, flown_by: FlownByOptions) -> Scenario:
    """The scenario in a file, with what the command line says in its place."""
    optimizer, planner, autopilot, vehicle = search.optimizer, search.planner, flown_by.autopilot, flown_by.vehicle
    scenario = read_scenario(path)
    changes: dict[str, Any] = {}
    planning = ({"planner": planner} if planner else {}) | ({} if search.polish else {"polish": False})
    if planning:
        changes["planning"] = scenario.planning.model_copy(update=planning)
    if optimizer is not None and optimizer != scenario.optimizer.name:
        changes["optimizer"] = type(scenario.optimizer)(name=optimizer)
    changed: dict[str, Any] = {"autopilot": autopilot} if autopilot is not None else {}
    if flown_by.version is not None or autopilot not in (None, scenario.vehicle.autopilot):
        changed["firmware_version"] = flown_by.firmware_version
    if flown_by.version is not None:
        (autopilot or scenario.vehicle.autopilot).tables.expect(flown_by.version)
    if flown_by.parameters:
        flies = autopilot or scenario.vehicle.autopilot
        changed["parameters"] = flies.book.overridden(scenario.vehicle.parameters, flown_by.parameters)
    if changed or vehicle:
        expect_own(changed.get("parameters", scenario.vehicle.parameters), autopilot or scenario.vehicle.autopilot)
        changes["vehicle"] = scenario.vehicle.model_copy(update=changed)
    if vehicle is not None:
        changes["vehicle"] = changes["vehicle"].learned_as(read_vehicle(vehicle, changes["vehicle"].autopilot))
    return scenario.model_copy(update=changes)
