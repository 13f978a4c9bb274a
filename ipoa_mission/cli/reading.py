"""Mission files that a user named, and what is said of the parameters that lie beside them."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipoa_mission.items import Mission
from ipoa_mission.learn.vehicle_file import read_vehicle
from ipoa_mission.mission.files import read_mission
from ipoa_mission.mission.parameter_file import beside
from ipoa_mission.vehicles.autopilot import Autopilot

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.vehicles.version import Version
    from ipoa_mission.wind import Wind

SHOWN = 6  # parameters in a note


def read_with_parameters(
    file: Path,
    autopilot: Autopilot | None = None,
    parameters: Mapping[str, float] | None = None,
    vehicle: Path | None = None,
    version: "Version | None" = None,
) -> tuple[Mission, tuple[str, ...]]:
    """The mission in a file, on a vehicle that has `parameters` too, and remarks for the user.

    `vehicle`: the file of what was learned of it; `version` of its firmware.

    Raises:
        BadInput: the file, or the parameters beside it, cannot be read, or there is no such version.
    """
    mission = read_mission(file, autopilot)
    if version is not None:
        mission = replace(mission, firmware_version=mission.autopilot.tables.expect(version))
    remarks = tuple(finding.message for finding in mission.findings)
    if mission.parameters:
        some = ", ".join(f"{name} {value:g}" for name, value in [*mission.parameters.items()][:SHOWN])
        more = len(mission.parameters) - SHOWN
        remarks += (f"parameters from {beside(file)}: {some}{f' and {more} more' if more > 0 else ''}",)
    if vehicle is not None:
        mission = replace(mission, vehicle=read_vehicle(vehicle, mission.autopilot))
    return mission.with_parameters(parameters or {}), remarks


def read_world(file: Path | None, wind: "Wind | None" = None) -> "Scenario | None":
    """The scenario that a user named, if there is one, in the wind that was given, if there is one.

    Raises:
        BadInput: the file cannot be read.
    """
    if file is None:
        return None
    from ipoa_mission.scenario import read_scenario

    world = read_scenario(file)
    return world if wind is None else world.in_wind(wind)


def in_world(mission: Mission, world: "Scenario | None", wind: "Wind | None" = None) -> tuple[Mission, "Wind"]:
    """The mission over the ground of the scenario on its vehicle, and the wind: the given one goes before its own."""
    from ipoa_mission.tube.flown_in import flown_in
    from ipoa_mission.wind import CALM

    if world is None:
        return mission, wind or CALM
    return flown_in(mission, world), wind or world.wind.air()
