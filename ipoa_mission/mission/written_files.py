"""Write the files of missions, and find changed ones."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ipoa_mission.errors import BadInput
from ipoa_mission.files import MISSIONS, read_text, write_atomically, write_together
from ipoa_mission.mission.about_file import digest, written_with
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.parameter_file import is_ours, parameter_file, parameter_path
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.mission.waypoints_file import waypoints_text


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
    """Write all or none, parameters named as the first; remove an old file of ours."""
    path = next(iter(contents))
    write_together({**contents, **parameter_file(mission, path)})
    if not mission.parameters and is_ours(parameter_path(path)):
        parameter_path(path).unlink()


def write_several(
    missions: Iterable[tuple[str, Mission, Mapping[str, Any] | None]], folder: Path, name: str, about: Mapping[str, Any]
) -> tuple[Path, ...]:
    """Write missions (name, mission, `about`), then NAME.json."""
    written, digests = list[Path](), dict[str, str]()
    for part, mission, about_part in missions:
        files, own = write_files(mission, folder, part, about_part)
        written += files
        digests |= own
    whole = folder / f"{name}.json"
    write_atomically(whole, _as_text({**about, "sha256": digests}))
    return (*written, whole)


def _as_text(contents: Mapping[str, Any]) -> str:
    return json.dumps(contents, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def not_as_written(folder: Path, name: str, report: bool = False) -> list[Path]:
    """Return files that differ from `Flight.write`."""
    about = folder / f"{name}.json"
    digests = written_with(about)
    missions = (folder / f"{name}{suffix}" for suffix in MISSIONS)
    others = [path for path in missions if path.exists() and digest(_text(path)) != digests.get(path.name)]
    if about.exists() and not digests:
        others.append(about)
    page = folder / f"{name}.html"
    if report and page.exists() and '<meta name="generator" content="ipoa-mission">' not in _text(page):
        others.append(page)
    return others


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except BadInput:
        return ""
