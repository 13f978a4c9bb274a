"""Read mission files by content, write them by suffix."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot, default_autopilot, registered
from ipoa_mission.autopilot.known_parameters import firmware_of
from ipoa_mission.errors import BadInput, WrongFormat, WrongSuffix
from ipoa_mission.files import MISSIONS, read_text
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.items import Item, Mission, MissionFile
from ipoa_mission.mission.landing_ground import landing_height, landing_on
from ipoa_mission.mission.parameter_file import ParameterFile, parameter_path, read_parameter_file
from ipoa_mission.mission.plan_file import parse_plan, plan_text
from ipoa_mission.mission.waypoints_file import FIRST_LINE, lost_in_waypoints, parse_waypoints, waypoints_text
from ipoa_mission.mission.written_files import mission_record, write_with_parameters


def read_mission(path: str | Path, autopilot: Autopilot | None = None) -> Mission:
    """Read a mission file of any name, and the NAME.params next to it.

    Args:
        path: of a `.plan` or a `.waypoints` file.
        autopilot: overrides the one in a `.plan`. A `.waypoints` file names none: by default NAME.params or
            NAME.json decide; else it is PX4.

    Returns:
        The mission; `check` reports the findings of reading.

    Raises:
        BadInput: the file cannot be read, is of another kind, or contradicts itself; the message names the place.

    Example:
        >>> from ipoa_mission import read_mission
        >>> len(read_mission("missions/sitl.plan").items) > 2
        True
    """
    file = read_mission_file(path, autopilot)
    if wrong := [finding for finding in file.findings if finding.severity is Severity.ERROR]:
        raise BadInput(wrong[0].message, hint=wrong[0].hint, code=wrong[0].code, place=path)
    return file.mission


def read_mission_file(
    path: str | Path, autopilot: Autopilot | None = None, otherwise: Autopilot | None = None
) -> MissionFile:
    """Read a mission file like `read_mission`, with the findings.

    Args:
        path: of a `.plan` or a `.waypoints` file.
        autopilot: as for `read_mission`.
        otherwise: autopilot of a `.waypoints` file if nothing next to it names one.

    Returns:
        The mission, the findings of reading, and the text.

    Raises:
        BadInput: the file cannot be read or is of another kind.

    Example:
        >>> from ipoa_mission import read_mission_file
        >>> read_mission_file("missions/sitl.plan").findings
        ()
    """
    return parse_mission(Path(path), read_text(Path(path)), autopilot, otherwise)


def parse_mission(
    path: Path, text: str, autopilot: Autopilot | None = None, otherwise: Autopilot | None = None
) -> MissionFile:
    parameters_file, record = parameter_path(path), mission_record(path, text)
    listed = read_parameter_file(parameters_file) if parameters_file.is_file() else ParameterFile({})
    parameters = listed.parameters
    firmware = firmware_of(listed.parameters)
    recorded = next((each for each in registered() if each.name == record.autopilot), None)
    file = _parsed(path, text, autopilot, firmware or recorded or otherwise)
    findings = [Finding("file-parameters", Severity.WARNING, None, unread.words) for unread in listed.unread]
    if firmware not in (None, autopilot) and autopilot is not None:
        words = f"{parameters_file}: expected parameters of {autopilot}, not of {firmware}: they are ignored"
        hint = f"give those of {autopilot} by --param-file"
        findings.insert(0, Finding("file-parameters", Severity.WARNING, None, words, hint))
        parameters = {}
    mission = file.mission
    if record.landing_height is not None and landing_height(mission) is None:
        mission = landing_on(mission, record.landing_height)
    try:
        mission = mission.with_parameters(parameters)
    except BadInput as error:
        raise error.at(parameters_file) from error
    return replace(file, mission=mission, findings=(*file.findings, *findings), planned=record.planned)


def read_by_items(path: Path, file: MissionFile) -> MissionFile:
    """Choose the autopilot of a `.waypoints` file that names none by its items."""
    if file.taken_for is None or (taker := only_taker(file.mission.items)) is None:
        return file
    return replace(parse_mission(path, file.source, taker[0]), taken_for=taker[1])


def _parsed(path: Path, text: str, autopilot: Autopilot | None, named: Autopilot | None) -> MissionFile:
    beginning = text.lstrip()[: len(FIRST_LINE)]
    if beginning.startswith("{") or (path.suffix.lower() == ".plan" and not beginning.startswith("QGC WPL")):
        return parse_plan(path, text, autopilot)
    if beginning.startswith("QGC WPL") or path.suffix.lower() == ".waypoints":
        if (chosen := autopilot or named) is not None:
            return parse_waypoints(path, text, chosen)
        return replace(parse_waypoints(path, text, default_autopilot()), taken_for="")
    raise WrongFormat(f"expected a .plan file, or a .waypoints file that begins with {FIRST_LINE}", place=path)


def write_mission(mission: Mission, path: str | Path, read_from: MissionFile | None = None) -> tuple[str, ...]:
    """Write a `.plan` or a `.waypoints` file, and the parameters to NAME.params next to it.

    Args:
        mission: to write.
        path: of the file.
        read_from: a file of this kind; a mission unchanged since is written with the same bytes.

    Returns:
        Losses in words: data that the format cannot hold, or a reader drops.

    Raises:
        BadInput: the suffix is unknown, or the format cannot hold the mission.

    Example:
        >>> from ipoa_mission import read_mission, write_mission
        >>> write_mission(read_mission("missions/sitl.plan"), "again.plan")
        ()
    """
    suffix = Path(path).suffix.lower()
    if suffix not in MISSIONS:
        raise WrongSuffix(f'expected a name that ends in .plan or .waypoints, not in "{suffix}"', place=path)
    write_with_parameters(mission, {Path(path): mission_text(mission, suffix, read_from)})
    return lost_in_waypoints(mission) if suffix == ".waypoints" else ()


def mission_text(mission: Mission, suffix: str, read_from: MissionFile | None = None) -> str:
    if read_from is not None and read_from.suffix == suffix and read_from.still_holds(mission):
        return read_from.source
    return plan_text(mission) if suffix == ".plan" else waypoints_text(mission)


def only_taker(items: Sequence[Item]) -> tuple[Autopilot, str] | None:
    """Return the one autopilot that takes all items, and why."""
    reasons = {autopilot: next(_reasons_against(items, autopilot), None) for autopilot in registered()}
    takers = [autopilot for autopilot, reason in reasons.items() if reason is None]
    return (takers[0], next(filter(None, reasons.values()))) if len(takers) == 1 else None


def _reasons_against(items: Sequence[Item], autopilot: Autopilot) -> Iterator[str]:
    firmware = autopilot.firmware()
    for seq, item in enumerate(items, start=1):
        at, placed = f"item {seq} ({item.name})", item.command in firmware.placed
        if not firmware.takes(item.command):
            yield f"{at}: {firmware.name} does not take it"
        elif placed and item.frame not in firmware.frames:
            yield f"{at}: {firmware.name} does not take frame {item.frame}"
        elif item.is_takeoff and (item.latitude_deg, item.longitude_deg) == (0.0, 0.0):
            if not item.is_here(autopilot):
                yield f"{at}: {firmware.name} would take off to latitude 0, longitude 0"
        elif any(map(math.isnan, item.params)) and not firmware.nan_holds:
            yield f"{at}: files for {firmware.name} hold no NaN"
