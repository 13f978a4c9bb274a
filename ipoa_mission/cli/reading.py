from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.learned import read_vehicle
from ipoa_mission.cli.groups import FlownByOptions, WorldOptions
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Finding
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_by_items, read_mission_file
from ipoa_mission.mission.parameter_file import parameter_path

if TYPE_CHECKING:
    from ipoa_mission.forecast.forecast import Forecast
    from ipoa_mission.mission.items import MissionFile
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.wind import Wind


class RequestedMission(NamedTuple):
    """The mission on the requested vehicle; `planned`: the NAME.json written with it, and its time [s]."""

    mission: Mission
    findings: tuple[Finding, ...]
    remarks: tuple[str, ...]
    planned: tuple[str, float] | None = None


def read_requested(
    file: Path, flown_by: FlownByOptions, autopilot: Autopilot | None = None, world: "Scenario | None" = None
) -> RequestedMission:
    """Read a mission file; `autopilot` is the default, for `.waypoints` also the `world`'s."""
    series = None if flown_by.version is None else flown_by.version.series
    with_this_version = [candidate for candidate in registered() if series in candidate.tables.series]
    fallback = None if world is None else world.vehicle.autopilot
    if len(with_this_version) == 1:
        (fallback,) = with_this_version
    read = read_by_items(file, read_mission_file(file, flown_by.autopilot or autopilot, fallback))
    mission = read.mission
    remarks = (*(finding.message for finding in read.findings), *taken_for(read))
    if flown_by.version is not None:
        possible = [candidate for candidate in with_this_version if candidate is not mission.autopilot]
        try:
            mission = replace(mission, firmware_version=mission.autopilot.tables.expect(flown_by.version))
        except BadInput as error:
            raise error.at(hint=f"--autopilot {possible[0]}" if possible else None) from None
    mission = replace(mission, unmeasured_version=flown_by.unmeasured_version)
    if mission.parameters:
        most = 6
        shown = ", ".join(f"{name} {value:g}" for name, value in [*mission.parameters.items()][:most])
        more = len(mission.parameters) - most
        remarks += (f"parameters from {parameter_path(file)}: {shown}{f' and {more} more' if more > 0 else ''}",)
    if flown_by.vehicle is not None:
        mission = replace(mission, vehicle=read_vehicle(flown_by.vehicle, mission.autopilot))
    remarks += flown_by.parameter_remarks
    return RequestedMission(mission.with_parameters(flown_by.parameters), read.findings, remarks, read.planned)


def taken_for(read: "MissionFile") -> tuple[str, ...]:
    if read.taken_for is None:
        return ()
    why = read.taken_for or "the file does not name its autopilot"
    return (f"read for {read.mission.autopilot}: {why}; --autopilot {'|'.join(map(str, registered()))} decides",)


def read_forecast(file: Path, options: WorldOptions) -> "tuple[RequestedMission, Forecast]":
    from ipoa_mission.checks.unsafe import refuse_unread
    from ipoa_mission.forecast.forecast import Forecast

    world = read_world(options.scenario, options.flown_by.air, options.ignore)
    refuse_unread(world)
    requested = read_requested(file, options.flown_by, world=world)
    return requested, Forecast(requested.mission, world, options.flown_by.air)


def read_world(file: Path | None, wind: "Wind | None" = None, ignore: Iterable[str] | None = None) -> "Scenario | None":
    if file is None:
        return None
    from ipoa_mission.scenario import read_scenario

    return read_scenario(file).ignoring(ignore or ()).in_wind(wind)
