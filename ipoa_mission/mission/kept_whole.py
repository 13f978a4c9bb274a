"""Write a mission file with changed items, and keep all else in it."""

import json
from collections.abc import Iterator
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, TypeAlias

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.mission.mission_io import mission_text, parse_mission

Table: TypeAlias = dict[str, Any]
NUMBER = "doJumpId"
CHANGED_KEYS = (NUMBER, "AMSLAltAboveTerrain", "Altitude", "AltitudeMode")


def text_with(mission: Mission, file: MissionFile, path: Path) -> str:
    if file.still_holds(mission) and mission.complex_items == file.mission.complex_items:
        return file.source
    new = mission_text(mission, file.suffix)
    if file.suffix == ".plan":
        kept = _merged(json.loads(file.source), json.loads(mission_text(file.mission, ".plan")), json.loads(new))
        text = json.dumps(kept, indent=4, sort_keys=True) + "\n"
    else:
        first, rest = new.split("\n", 1)
        comments = [line for line in file.source.splitlines() if line.lstrip().startswith("#")]
        text = "\n".join([first, *comments, rest])
    plain, whole = (parse_mission(path, one, mission.autopilot) for one in (new, text))
    if not whole.still_holds(plain.mission):
        words = "expected a change that keeps the rest of the file, not this one"
        raise BadInput(words, hint="save it as another file", code="complex-item", place=path.name)
    return text


def _merged(source: Table, old: Table, new: Table) -> Table:
    """Return `new` with differences of `source` from `old`, our text of the unchanged mission."""
    merged: Table = dict(new)
    for key, value in source.items():
        if key == "items" and isinstance(value, list) and key in old and key in new:
            merged[key] = list(_merged_items(value, old[key], new[key]))
        elif (key not in old and key not in new) or (key in new and old.get(key) == new[key]):
            merged[key] = value
        elif isinstance(value, dict) and isinstance(old.get(key), dict) and isinstance(new.get(key), dict):
            merged[key] = _merged(value, old[key], new[key])
    return merged


def _merged_items(source: list[Table], old: list[Table], new: list[Table]) -> Iterator[Table]:
    if len(source) != len(old):
        yield from new
        return
    same = SequenceMatcher(None, list(map(_comparable, old)), list(map(_comparable, new)), autojunk=False)
    for kind, first, last, begin, end in same.get_opcodes():
        paired = kind == "equal" or (kind == "replace" and last - first == end - begin)
        for n, item in enumerate(new[begin:end]):
            was, before = (source[first + n], old[first + n]) if paired else ({}, {})
            if kind == "equal" and item.get("type") == "SimpleItem" and item["command"] != Command.DO_JUMP:
                yield {**was, **({NUMBER: item[NUMBER]} if NUMBER in was else {})}
            elif paired and item.get("type") == was.get("type") == "SimpleItem" and "coordinate" not in was:
                changed = (*CHANGED_KEYS, "params") if item["command"] == Command.DO_JUMP else CHANGED_KEYS
                yield _merged(was, before, item) | {key: item[key] for key in changed if key in item}
            else:
                yield item


def _comparable(item: Table) -> str:
    return json.dumps({key: value for key, value in item.items() if key != NUMBER}, sort_keys=True)
