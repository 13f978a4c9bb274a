"""Read mission files by content, write them by suffix, and all files of a mission."""

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from ipoa_mission.autopilot.autopilot import Autopilot, default_autopilot, registered
from ipoa_mission.autopilot.known_parameters import firmware_of
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.errors import BadInput, WrongFormat, WrongSuffix
from ipoa_mission.files import MISSIONS, read_text, write_together
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.items import Item, Mission, MissionFile
from ipoa_mission.mission.landing_ground import landing_ground_entry, landing_height, landing_on
from ipoa_mission.mission.parameter_file import ParameterFile, parameter_contents, parameter_path, read_parameter_file
from ipoa_mission.mission.plan_file import parse_plan, plan_text
from ipoa_mission.mission.waypoints_file import FIRST_LINE, lost_in_waypoints, parse_waypoints, waypoints_text

LANDING_GROUND_KEY = "landing_ground_m"
Contents: TypeAlias = dict[Path, str | None]  # None: to remove
About: TypeAlias = Mapping[str, Any]  # contents of a NAME.json


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
    _refuse_errors(file, path)
    return file.mission


def _refuse_errors(file: MissionFile, path: str | Path) -> None:
    for finding in file.findings:
        if finding.severity is Severity.ERROR:
            raise BadInput(finding.message, hint=finding.hint, code=finding.code, place=path)


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
    parameters_file = parameter_path(path)
    record = mission_record(path, text)
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
    """Let the items choose the autopilot of a `.waypoints` file that names none."""
    taker = None if file.taken_for is None else only_taker(file.mission.items)
    if taker is None:
        return file
    autopilot, reason = taker
    return replace(parse_mission(path, file.source, autopilot), taken_for=reason)


def _parsed(path: Path, text: str, autopilot: Autopilot | None, named: Autopilot | None) -> MissionFile:
    beginning = text.lstrip()[: len(FIRST_LINE)]
    if beginning.startswith("{") or (path.suffix.lower() == ".plan" and not beginning.startswith("QGC WPL")):
        return parse_plan(path, text, autopilot)
    if beginning.startswith("QGC WPL") or path.suffix.lower() == ".waypoints":
        chosen = autopilot or named
        file = parse_waypoints(path, text, chosen or default_autopilot())
        return replace(file, taken_for="") if chosen is None else file
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
        BadInput: the suffix is unknown, the format cannot hold the mission, or `read_mission` would refuse the file.

    Example:
        >>> from ipoa_mission import read_mission, write_mission
        >>> write_mission(read_mission("missions/sitl.plan"), "again.plan")
        ()
    """
    suffix = Path(path).suffix.lower()
    if suffix not in MISSIONS:
        raise WrongSuffix(f'expected a name that ends in .plan or .waypoints, not in "{suffix}"', place=path)
    path = Path(path)
    text = mission_text(mission, suffix, read_from)
    if read_from is None or text != read_from.source:
        text = _readable(text, path, mission.autopilot)
    write_together({path: text, **parameter_contents(mission, path)})
    return lost_in_waypoints(mission) if suffix == ".waypoints" else ()


def _readable(text: str, path: Path, autopilot: Autopilot) -> str:
    """Return the text; raise BadInput as `read_mission` would for it at `path`."""
    _refuse_errors(_parsed(path, text, autopilot, None), path)
    return text


def mission_text(mission: Mission, suffix: str, read_from: MissionFile | None = None) -> str:
    if read_from is not None and read_from.suffix == suffix and still_holds(read_from, mission):
        return read_from.source
    return plan_text(mission) if suffix == ".plan" else waypoints_text(mission)


def still_holds(file: MissionFile, mission: Mission) -> bool:
    """Return whether a file has all of a mission but its parameters."""
    ours, theirs = (replace(each, parameters={}) for each in (file.mission, mission))
    if file.suffix == ".plan":
        grounds = [landing_ground_entry(each) for each in (file.mission, mission)]
        if grounds[0] != grounds[1] or repr(ours.complex_items) != repr(theirs.complex_items):
            return False
    return repr(ours) == repr(theirs)  # repr: NaN equals NaN


def only_taker(items: Sequence[Item]) -> tuple[Autopilot, str] | None:
    """Return the one autopilot that takes all items, and the reason against another."""
    reasons = {autopilot: next(_reasons_against(items, autopilot), None) for autopilot in registered()}
    takers = [autopilot for autopilot, reason in reasons.items() if reason is None]
    return (takers[0], next(filter(None, reasons.values()))) if len(takers) == 1 else None


def _reasons_against(items: Sequence[Item], autopilot: Autopilot) -> Iterator[str]:
    firmware = autopilot.firmware()
    for seq, item in enumerate(items, start=1):
        at = f"item {seq} ({item.name})"
        if not firmware.takes(item.command):
            yield f"{at}: {firmware.name} does not take it"
        elif item.command in firmware.placed and item.frame not in firmware.frames:
            yield f"{at}: {firmware.name} does not take frame {item.frame}"
        elif item.is_takeoff and (item.latitude_deg, item.longitude_deg) == (0.0, 0.0):
            if not item.is_here(autopilot):
                yield f"{at}: {firmware.name} would take off to latitude 0, longitude 0"
        elif any(map(math.isnan, item.params)) and not firmware.nan_holds:
            yield f"{at}: files for {firmware.name} hold no NaN"


def digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()


def write_files(
    missions: Iterable[tuple[str, Mission, About | None]],
    folder: Path,
    pages: Mapping[Path, str] | None = None,
    whole: tuple[str, About] | None = None,
) -> tuple[Path, ...]:
    """Write missions by name, the pages, and a NAME.json of each and of the `whole` together; return the paths.

    Missions that an earlier NAME.json records, and this one does not, are removed with their pages unless edited.
    """
    contents = Contents()
    digests = dict[str, str]()
    for name, mission, about in missions:
        plan = folder / f"{name}.plan"
        texts = {plan: plan_text(mission), plan.with_name(f"{name}.waypoints"): waypoints_text(mission)}
        texts = {path: _readable(text, path, mission.autopilot) for path, text in texts.items()}
        of_mission = {path.name: digest(text) for path, text in texts.items()}
        contents |= texts
        if about is not None:
            contents[folder / f"{name}.json"] = _about_text(about, of_mission)
        contents |= parameter_contents(mission, plan)
        digests |= of_mission
    contents |= pages or {}
    if whole is not None:
        name, about = whole
        contents[folder / f"{name}.json"] = _about_text(about, digests)
    for path in [path for path in contents if path.suffix == ".json"]:
        contents |= dict.fromkeys(_left_over(path, contents))
    write_together(contents)
    return tuple(path for path, text in contents.items() if text is not None)


def _left_over(about: Path, contents: Contents) -> Iterator[Path]:
    """Yield missions as an earlier `about` records them, with parameters, records and pages, without the `contents`."""
    record = _read(about)
    for path, recorded in recorded_missions(about).items():
        if path in contents or not path.is_file() or digest(_text(path)) != recorded:
            continue
        yield path
        page = path.with_suffix(".html")
        if page not in contents and _is_own_page(page):
            yield page
        own = path.with_suffix(".json")
        vehicle = parameter_path(path)
        parameters = (_read(own) or record).get("parameters")
        if parameters and vehicle not in contents and vehicle.is_file() and _parameters(vehicle) == parameters:
            yield vehicle
        if own not in contents and recorded_missions(own):
            yield own


def recorded_missions(about: Path) -> dict[Path, str]:
    """Return the digests of NAME.plan, NAME-1.plan and so on, and of .waypoints, in NAME.json."""
    own = re.compile(rf"{re.escape(about.stem)}(-\d+)?({'|'.join(map(re.escape, MISSIONS))})")
    digests = _table(_read(about).get("sha256"))
    return {about.with_name(file): recorded for file, recorded in digests.items() if own.fullmatch(file)}


def _about_text(about: About, digests: Mapping[str, str]) -> str:
    return json.dumps({**about, "sha256": digests}, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def not_as_written(folder: Path, name: str, report: bool = False) -> list[Path]:
    """Return files of the name, and of its parts, that differ from those that NAME.json records."""
    about = folder / f"{name}.json"
    record = _read(about)
    digests = recorded_missions(about)
    missions = dict.fromkeys((*(folder / f"{name}{suffix}" for suffix in MISSIONS), *digests))
    differing = [path for path in missions if path.exists() and digest(_text(path)) != digests.get(path)]
    vehicle = parameter_path(about)
    if about.exists() and vehicle.exists() and _parameters(vehicle) != record.get("parameters", {}):
        differing.append(vehicle)
    if about.exists() and not digests:
        differing.append(about)
    page = folder / f"{name}.html"
    if report and page.exists() and not _is_own_page(page):
        differing.append(page)
    return differing


def _is_own_page(path: Path) -> bool:
    return path.is_file() and '<meta name="generator" content="ipoa-mission">' in _text(path)


def _parameters(path: Path) -> Parameters | None:
    try:
        return read_parameter_file(path).parameters
    except BadInput:
        return None


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except BadInput:
        return ""


class MissionRecord(NamedTuple):
    """`landing_height`: above home [m]; `planned`: the NAME.json's name and flight time [s]."""

    landing_height: float | None = None
    planned: tuple[str, float] | None = None
    autopilot: str | None = None


def mission_record(path: Path, text: str) -> MissionRecord:
    """Return the data of the NAME.json next to `path` if its digest matches `text`."""
    same_name = path.with_suffix(".json")
    whole, _, _ = path.stem.rpartition("-")
    for about in (same_name, *([path.with_name(f"{whole}.json")] if whole else [])):
        record = _read(about)
        if _table(record.get("sha256")).get(path.name) != digest(text):
            continue
        flights = record.get("flights")
        parts = [part for part in flights if isinstance(part, dict)] if isinstance(flights, list) else []
        times = [part.get("time_s") for part in parts if part.get("file") == path.with_suffix(".plan").name]
        times += [] if parts else [_table(record.get("estimate")).get("total_s")]
        time_s = next(map(_finite, times), None)
        return MissionRecord(
            _finite(record.get(LANDING_GROUND_KEY)) if about == same_name else None,
            None if time_s is None else (about.name, time_s),
            _table(record.get("firmware")).get("autopilot"),
        )
    return MissionRecord()


def _read(about: Path) -> dict[str, Any]:
    try:
        return _table(json.loads(read_text(about)) if about.is_file() and about.stat().st_size < 10_000_000 else {})
    except (BadInput, OSError, ValueError, RecursionError):
        return {}


def _table(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _finite(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)
