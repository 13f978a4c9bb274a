"""Write the files of missions, all or none; find changed ones, and the NAME.json written with a mission."""

import json
import math
from collections.abc import Iterable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from ipoa_mission.autopilot.parameters import REAL32, Parameters
from ipoa_mission.errors import BadInput
from ipoa_mission.files import MISSIONS, read_text, write_together
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.parameter_file import parameter_path, read_parameter_file
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.mission.waypoints_file import waypoints_text

PARAMETERS_HEADER = "# Parameters of the vehicle that {} was made for"
LANDING_GROUND_KEY = "landing_ground_m"
Contents: TypeAlias = dict[Path, str | None]  # None: to remove


def digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()


def write_files(mission: Mission, folder: Path, name: str, about: Mapping[str, Any]) -> tuple[Path, ...]:
    """Write all files or none, NAME.json of `about`; return them."""
    return _write(_mission_contents(mission, folder, name, about)[0])


def write_with_parameters(mission: Mission, contents: Mapping[Path, str]) -> None:
    """Write all or none, parameters named as the first; remove an old file of ours, replace no other."""
    _write({**contents, **_parameter_contents(mission, next(iter(contents)))})


def write_several(
    missions: Iterable[tuple[str, Mission, Mapping[str, Any] | None]],
    folder: Path,
    name: str,
    about: Mapping[str, Any],
    pages: Mapping[Path, str] | None = None,
) -> tuple[Path, ...]:
    """Write the files of all missions, the pages and NAME.json of `about`, all or none."""
    contents, digests = Contents(), dict[str, str]()
    for part, mission, about_part in missions:
        part_contents, part_digests = _mission_contents(mission, folder, part, about_part)
        contents |= part_contents
        digests |= part_digests
    whole = folder / f"{name}.json"
    return _write({**contents, **(pages or {}), whole: _as_text({**about, "sha256": digests})})


def _write(contents: Contents) -> tuple[Path, ...]:
    texts = {path: text for path, text in contents.items() if text is not None}
    write_together(texts)
    for path in contents.keys() - texts.keys():
        path.unlink()
    return tuple(texts)


def _mission_contents(
    mission: Mission, folder: Path, name: str, about: Mapping[str, Any] | None
) -> tuple[Contents, dict[str, str]]:
    plan = folder / f"{name}.plan"
    contents: Contents = {plan: plan_text(mission), folder / f"{name}.waypoints": waypoints_text(mission)}
    digests = {path.name: digest(text) for path, text in contents.items() if text is not None}
    if about is not None:
        contents[folder / f"{name}.json"] = _as_text({**about, "sha256": digests})
    return contents | _parameter_contents(mission, plan), digests


def _parameter_contents(mission: Mission, path: Path) -> Contents:
    target = parameter_path(path)
    is_ours = target.exists() and read_text(target).startswith(PARAMETERS_HEADER.partition("{}")[0])
    if not mission.parameters:
        return {target: None} if is_ours else {}
    if target.exists() and not is_ours:
        words = "expected a free name for the mission's parameters, not a file of another origin"
        hint = "move it, or write the mission under another name"
        raise BadInput(words, hint=hint, code="already-there", place=target)
    return {target: _parameters_text(mission, path.stem)}


def _parameters_text(mission: Mission, name: str) -> str:
    lines = [PARAMETERS_HEADER.format(name), "# Vehicle-Id Component-Id Name Value Type"]
    table = mission.autopilot.parameter_table
    kinds = {row.name: row.kind for row in (*table.set_up, *table.by_name.values())}
    for parameter, value in mission.parameters.items():
        kind = kinds.get(parameter, REAL32)
        number = f"{value:.0f}" if value == int(value) else repr(float(value))
        lines.append(f"1\t1\t{parameter}\t{number}\t{kind}")  # QGroundControl requires the vehicle's own type
    return "\n".join(lines) + "\n"


def _as_text(contents: Mapping[str, Any]) -> str:
    return json.dumps(contents, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def not_as_written(folder: Path, name: str, report: bool = False) -> list[Path]:
    """Return files that differ from `Flight.write`."""
    about = folder / f"{name}.json"
    record = _read(about)
    digests = _table(record.get("sha256"))
    missions = (folder / f"{name}{suffix}" for suffix in MISSIONS)
    differing = [path for path in missions if path.exists() and digest(_text(path)) != digests.get(path.name)]
    vehicle = parameter_path(about)
    if about.exists() and vehicle.exists() and _parameters(vehicle) != record.get("parameters", {}):
        differing.append(vehicle)
    if about.exists() and not digests:
        differing.append(about)
    page = folder / f"{name}.html"
    if report and page.exists() and '<meta name="generator" content="ipoa-mission">' not in _text(page):
        differing.append(page)
    return differing


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
    """Return the data of the NAME.json next to `path`, if its digest matches `text`."""
    same_name = path.with_suffix(".json")
    for about in (same_name, path.with_name(f"{path.stem.rpartition('-')[0]}.json")):
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
    return value if isinstance(value, float) and math.isfinite(value) else None
