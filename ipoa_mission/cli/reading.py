"""Mission files that a user named, and what is said of the parameters that lie beside them."""

from collections.abc import Mapping
from pathlib import Path

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.items import Mission
from ipoa_mission.mission.files import read_mission
from ipoa_mission.mission.parameter_file import beside

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
