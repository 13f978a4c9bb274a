"""Write the files of missions, all or none; find changed ones, and the NAME.json written with a mission."""

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from ipoa_mission.autopilot.commands import Command, Frame, command_name
from ipoa_mission.autopilot.parameters import REAL32, Parameters
from ipoa_mission.errors import BadInput
from ipoa_mission.files import MISSIONS, read_text, write_atomically, write_together
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.complex_items import as_document, entries
from ipoa_mission.mission.items import FencePolygon, Item, Mission
from ipoa_mission.mission.landing_ground import landing_ground_entry
from ipoa_mission.mission.parameter_file import parameter_path, read_parameter_file
from ipoa_mission.mission.plan_file import ALTITUDE_MODES, AltitudeMode, tidy
from ipoa_mission.mission.stored_mission import resolve_frames
from ipoa_mission.mission.waypoints_file import waypoints_text

PARAMETERS_HEADER = "# Parameters of the vehicle that {} was made for"
LANDING_GROUND_KEY = "landing_ground_m"


def digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()


def write_files(
    mission: Mission, folder: Path, name: str, about: Mapping[str, Any] | None = None
) -> tuple[tuple[Path, ...], dict[str, str]]:
    """Write all files or none, NAME.json of `about`; return them, and digests of the first two."""
    plan = folder / f"{name}.plan"
    contents = {plan: plan_text(mission), folder / f"{name}.waypoints": waypoints_text(mission)}
    digests = {path.name: digest(text) for path, text in contents.items()}
    if about is not None:
        contents[folder / f"{name}.json"] = _as_text({**about, "sha256": digests})
    write_with_parameters(mission, contents)
    return (*contents, *([parameter_path(plan)] if mission.parameters else [])), digests


def write_with_parameters(mission: Mission, contents: Mapping[Path, str]) -> None:
    """Write all or none, parameters named as the first; remove an old file of ours, replace no other."""
    path = next(iter(contents))
    target = parameter_path(path)
    is_ours = target.exists() and read_text(target).startswith(PARAMETERS_HEADER.partition("{}")[0])
    if not mission.parameters:
        write_together(contents)
        if is_ours:
            target.unlink()
        return
    if target.exists() and not is_ours:
        words = "expected a free name for the mission's parameters, not a file of another origin"
        hint = "move it, or write the mission under another name"
        raise BadInput(words, hint=hint, code="already-there", place=target)
    write_together({**contents, target: _parameters_text(mission, path.stem)})


def _parameters_text(mission: Mission, name: str) -> str:
    lines = [PARAMETERS_HEADER.format(name), "# Vehicle-Id Component-Id Name Value Type"]
    rows = mission.autopilot.parameter_table.by_name
    for parameter, value in mission.parameters.items():
        kind = rows[parameter].kind if parameter in rows else REAL32
        number = f"{value:.0f}" if value == int(value) else repr(float(value))
        lines.append(f"1\t1\t{parameter}\t{number}\t{kind}")  # QGroundControl requires the vehicle's own type
    return "\n".join(lines) + "\n"


def write_several(
    missions: Iterable[tuple[str, Mission, Mapping[str, Any] | None]], folder: Path, name: str, about: Mapping[str, Any]
) -> tuple[Path, ...]:
    written, digests = list[Path](), dict[str, str]()
    for part, mission, about_part in missions:
        files, part_digests = write_files(mission, folder, part, about_part)
        written += files
        digests |= part_digests
    whole = folder / f"{name}.json"
    write_atomically(whole, _as_text({**about, "sha256": digests}))
    return (*written, whole)


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


# --- the text of a .plan ----------------------------------------------------------------------------------------


def plan_text(mission: Mission) -> str:
    return json.dumps(_plan(mission), indent=4, sort_keys=True, allow_nan=False) + "\n"


def _plan(mission: Mission) -> dict[str, Any]:
    items = resolve_frames(mission.items, mission.autopilot)
    for number, item in enumerate(items, start=1):
        _check(number, item, len(items))
    modes = Counter(ALTITUDE_MODES[Frame(item.frame)] for item in items if item.frame in ALTITUDE_MODES)
    header: dict[str, Any] = {
        "firmwareType": mission.autopilot.mav_autopilot,
        "globalPlanAltitudeMode": next(iter(modes), AltitudeMode.RELATIVE) if len(modes) < 2 else AltitudeMode.MIXED,
        "items": [*_entries(items, mission)],
        "plannedHomePosition": _place(mission.home, "home"),
        "vehicleType": mission.vehicle_type,
        "version": 2,
    }
    if mission.cruise_speed is not None:
        header |= {"cruiseSpeed": tidy(mission.cruise_speed), "hoverSpeed": tidy(mission.cruise_speed)}
    circles, polygons = list[dict[str, Any]](), list[dict[str, Any]]()
    for part in mission.fence:
        entry = {"inclusion": part.inclusion, "version": 1}
        if isinstance(part, FencePolygon):
            polygons.append(entry | {"polygon": [list(map(tidy, vertex)) for vertex in part.vertices]})
        else:
            circles.append(entry | {"circle": {"center": list(map(tidy, part.center)), "radius": tidy(part.radius)}})
    return {
        **({"landingGround": ground} if (ground := landing_ground_entry(mission)) else {}),
        "fileType": "Plan",
        "geoFence": {"circles": circles, "polygons": polygons, "version": 2},
        "groundStation": "QGroundControl",
        "mission": header,
        "rallyPoints": {
            "points": [_place(place, f"rally[{n}]") for n, place in enumerate(mission.rally)],
            "version": 2,
        },
        "version": 1,
    }


def _entries(items: Sequence[Item], mission: Mission) -> Iterator[dict[str, Any]]:
    parts = [replace(part, items=resolve_frames(part.items, mission.autopilot)) for part in mission.complex_items]
    for indices, of in entries(items, parts):
        simple = [_simple_item(index + 1, items[index]) for index in indices]
        yield simple[0] if of is None else as_document(of, indices.start + 1, simple)


def _check(number: int, item: Item, count: int) -> None:
    where = f"item {number} ({command_name(item.command)})"
    if item.frame in ALTITUDE_MODES and not math.isfinite(item.altitude):
        raise BadInput(f"expected an altitude, not {item.altitude}", code="altitude-missing", place=where)
    if item.command == Command.DO_JUMP and item.params[0] not in range(1, count + 1):
        words = f"expected an item number from 1 to {count}, not {item.params[0]:g}"
        raise BadInput(words, code="jump-target", place=f"{where}: param1")


def _simple_item(number: int, item: Item) -> dict[str, Any]:
    params = [*item.params, item.latitude_deg, item.longitude_deg, item.altitude]
    written: dict[str, Any] = {
        "autoContinue": item.autocontinue,
        "command": int(item.command),
        "doJumpId": number,
        "frame": int(item.frame),
        "params": [tidy(value) for value in params],
        "type": "SimpleItem",
    }
    if item.frame not in ALTITUDE_MODES:
        return written
    return written | {
        "AMSLAltAboveTerrain": None,
        "Altitude": tidy(item.altitude),
        "AltitudeMode": ALTITUDE_MODES[Frame(item.frame)],
    }


def _place(place: Geodetic, name: str) -> list[float | int | None]:
    numbers = (place.latitude_deg, place.longitude_deg, place.altitude)
    if not all(map(math.isfinite, numbers)):
        raise BadInput(f"expected latitude, longitude and altitude, not {numbers}", code="altitude-missing", place=name)
    return [tidy(number) for number in numbers]
