"""Read or plan the mission that a verb flies."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ipoa_mission.autopilot.known_parameters import expect_own
from ipoa_mission.autopilot.learned import read_vehicle
from ipoa_mission.checks.check import check
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.cli.groups import FlownByOptions, SearchOptions
from ipoa_mission.cli.reading import read_requested
from ipoa_mission.flight.flight import Flight
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.positions import refuse_unsound
from ipoa_mission.scenario import Scenario

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Job:
    """A mission ready to fly; `begun`: the forecast from another item; `reserves`: the battery in flight."""

    name: str
    forecast: Forecast
    remarks: tuple[str, ...]
    flight: Flight | None = None
    begun: Forecast | None = None
    ignore: Sequence[str] = ()
    reserves: list[ReserveNow] = field(default_factory=list)
    system: int | None = None  # of the vehicle on the link; None: that of the options

    @property
    def mission(self) -> Mission:
        return self.forecast.mission

    @property
    def estimate(self) -> Estimate:
        return (self.begun or self.forecast).estimate


class FlownJob(NamedTuple):
    job: Job
    remarks: tuple[str, ...]
    record: FlightRecord
    system: int | None = None


def read_job(source: Path, flown_by: FlownByOptions, ignore: Sequence[str], on_link: bool) -> Job:
    """`on_link`: without findings of some versions only."""
    requested = read_requested(source, flown_by)
    mission = requested.mission
    forecast = Forecast(mission, wind=flown_by.air)
    versions = mission.autopilot.measured if on_link and flown_by.version is None else (mission.firmware_version,)
    checked = [check(forecast.on(version), ignore, requested.findings) for version in versions]
    warnings = refuse_errors([finding for finding in checked[-1] if all(finding in each for each in checked)])
    refuse_unsound(mission)
    log.info("%s: %s for %s", source, count_words(len(mission.items)), mission.autopilot)
    if not on_link:  # else aboard
        log.info("estimated %.1f s%s", forecast.estimate.total_s, forecast.estimate.besides)
    return Job(source.stem, forecast, (*requested.remarks, *(finding.message for finding in warnings)), ignore=ignore)


def adapt_scenario(scenario: Scenario, search: SearchOptions, flown_by: FlownByOptions) -> Scenario:
    optimizer = scenario.optimizer
    if search.optimizer is not None and search.optimizer != optimizer.name:
        optimizer = type(optimizer)(name=search.optimizer)
    scenario = scenario.flown_by(flown_by.autopilot or scenario.vehicle.autopilot)
    vehicle = scenario.vehicle
    autopilot = vehicle.autopilot
    changes: dict[str, Any] = {}
    if flown_by.unmeasured_version:
        changes["unmeasured_version"] = True
    if flown_by.version is not None:
        autopilot.tables.expect(flown_by.version)
        changes["firmware_version"] = flown_by.firmware_version
    if flown_by.parameters:
        expect_own(flown_by.parameters, autopilot)
        changes["parameters"] = autopilot.parameter_table.overridden(vehicle.parameters, flown_by.parameters)
    if changes:
        vehicle = vehicle.model_copy(update=changes).remarked(flown_by.parameter_remarks)
    if flown_by.vehicle is not None:
        vehicle = vehicle.learned_as(read_vehicle(flown_by.vehicle, autopilot))
    return scenario.model_copy(update={"vehicle": vehicle, "optimizer": optimizer})
