"""Mission files that a user named, and what is said of the parameters that lie beside them."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.items import Mission
from ipoa_mission.mission.files import read_mission
from ipoa_mission.mission.parameter_file import beside

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.wind import Wind

SHOWN = 6  # parameters in a note


def read_with_parameters(
    file: Path, autopilot: Autopilot | None = None, parameters: Mapping[str, float] | None = None
) -> tuple[Mission, tuple[str, ...]]:
    """The mission in a file, on a vehicle that has `parameters` too, and remarks for the user.

    Raises:
        BadInput: the file, or the parameters beside it, cannot be read.
    """
    mission = read_mission(file, autopilot)
    remarks = tuple(finding.message for finding in mission.findings)
    if mission.parameters:
        some = ", ".join(f"{name} {value:g}" for name, value in [*mission.parameters.items()][:SHOWN])
        more = len(mission.parameters) - SHOWN
        remarks += (f"parameters from {beside(file)}: {some}{f' and {more} more' if more > 0 else ''}",)
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
    """The mission on the scenario's vehicle, and the wind: what was given goes before the scenario's own."""
    from ipoa_mission.wind import CALM

    if world is None:
        return mission, wind or CALM
    return mission.assuming(world.vehicle.autopilot_parameters()), wind or world.wind.air()
