"""Edit a mission's items, and keep all else in its file."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from difflib import SequenceMatcher
from io import StringIO
from pathlib import Path
from typing import Any, TypeAlias

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.complex_items import entries
from ipoa_mission.mission.items import Item, Mission, MissionFile
from ipoa_mission.mission.mission_io import mission_text, parse_mission, still_holds


def with_item(mission: Mission, seq: int, item: Item) -> Mission:
    """Replace an item outside surveys and scans."""
    _expect_alone(mission, seq)
    return replace(mission, items=(*mission.items[: seq - 1], item, *mission.items[seq:]))


def with_inserted(mission: Mission, seq: int, item: Item) -> Mission:
    _expect_number(seq, len(mission.items) + 1)
    if (part := _complex_at(mission, seq)) is not None and part.start < seq:
        raise _inside(seq, part)
    moved = _renumbered(mission, seq, 1)
    return replace(moved, items=(*moved.items[: seq - 1], item, *moved.items[seq - 1 :]))


def without_item(mission: Mission, seq: int) -> Mission:
    """Remove an item outside surveys and scans that no jump leads to."""
    _expect_alone(mission, seq)
    removed = mission.items[seq - 1]
    for number, item in enumerate(mission.items, start=1):
        leads_here = item.command == Command.DO_JUMP and item.params[0] == seq
        of_tag = item.command == Command.DO_JUMP_TAG and removed.command == Command.JUMP_TAG
        if number != seq and (leads_here or (of_tag and item.params[0] == removed.params[0])):
            words = f"expected no jump to it, but item {number} has one"
            raise BadInput(words, hint=f"change item {number} first", place=f"item {seq}")
    moved = _renumbered(mission, seq + 1, -1)
    return replace(moved, items=(*moved.items[: seq - 1], *moved.items[seq:]))


def _renumbered(mission: Mission, first: int, by: int) -> Mission:

    def moved(number: int) -> int:
        return number + by if number >= first else number

    items = [
        replace(item, params=(float(moved(int(item.params[0]))), *item.params[1:]))
        if item.command == Command.DO_JUMP and float(item.params[0]).is_integer()
        else item
        for item in mission.items
    ]
    return replace(mission, items=tuple(items))


def with_plain_items(mission: Mission, seq: int) -> Mission:
    part = _complex_at(mission, seq)
    if part is None:
        return mission
    here = repr(mission.items[part.start - 1 : part.stop - 1])  # repr: NaN equals NaN
    return replace(mission, complex_items=tuple(each for each in mission.complex_items if repr(each.items) != here))


def complex_at(mission: Mission) -> tuple[range | None, ...]:
    numbers: list[range | None] = []
    for indices, of in entries(mission.items, mission.complex_items):
        part = None if of is None else range(indices.start + 1, indices.stop + 1)
        numbers += [part] * len(indices)
    return tuple(numbers)


def _complex_at(mission: Mission, seq: int) -> range | None:
    return complex_at(mission)[seq - 1] if 1 <= seq <= len(mission.items) else None


def _expect_alone(mission: Mission, seq: int) -> None:
    _expect_number(seq, len(mission.items))
    if (part := _complex_at(mission, seq)) is not None:
        raise _inside(seq, part)


def _expect_number(seq: int, most: int) -> None:
    if not 1 <= seq <= most:
        raise BadInput(f"expected a number from 1 to {most}", code="no-such-item", place=f"item {seq}")


def _inside(seq: int, part: range) -> BadInput:
    words = f"expected an item outside QGroundControl's surveys and scans, not item {seq} of {part.start} to"
    hint = "make plain items of the survey or scan first"
    return BadInput(f"{words} {part.stop - 1}", hint=hint, code="complex-item")


Table: TypeAlias = dict[str, Any]


def text_with(mission: Mission, file: MissionFile, path: Path) -> str:
    if still_holds(file, mission):
        return file.source
    new = mission_text(mission, file.suffix)
    if file.suffix == ".plan":
        kept = _merged(json.loads(file.source), json.loads(mission_text(file.mission, ".plan")), json.loads(new))
        text = json.dumps(kept, indent=4, sort_keys=True) + "\n"
    else:
        text = _merged_lines(file, mission, new)
    kept_mission, new_mission = (parse_mission(path, each, mission.autopilot) for each in (text, new))
    if not still_holds(kept_mission, new_mission.mission):
        words = "expected a change that keeps the rest of the file, not this one"
        raise BadInput(words, hint="save it as another file", code="complex-item", place=path.name)
    return text


def _merged_lines(file: MissionFile, mission: Mission, new: str) -> str:
    """Return the source with changed items' lines; comments and blank lines stay before their item."""
    first, *lines = StringIO(file.source, newline="").readlines()
    line_end = first[len(first.rstrip("\r\n")) :]
    rows = list[str]()
    comments = [""]  # before each row, and after the last
    for line in lines:
        if not line.split() or line.lstrip().startswith("#"):
            comments[-1] += line
        else:
            rows.append(line.rstrip("\r\n"))
            comments.append("")
    home = tuple(map(float, rows[0].split()[8:11]))
    old = [repr(home), *map(repr, file.mission.items)]  # repr: NaN equals NaN
    place = (mission.home.latitude_deg, mission.home.longitude_deg, mission.home.altitude)
    now = [repr(place), *map(repr, mission.items)]
    written = new.splitlines()[1:]
    text = first
    for kind, before, old_end, seq, new_end in SequenceMatcher(None, old, now, autojunk=False).get_opcodes():
        for n in range(max(old_end - before, new_end - seq)):
            if before + n < old_end:
                text += comments[before + n]
            if seq + n < new_end:
                row = re.sub(r"\S+", str(seq + n), rows[before + n], count=1) if kind == "equal" else written[seq + n]
                text += row + line_end
    return text + comments[-1]


def _merged(source: Table, old: Table, new: Table) -> Table:
    """Return `new`, with the changes that `source` has from `old`."""
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
                yield {**was, **({"doJumpId": item["doJumpId"]} if "doJumpId" in was else {})}
            elif paired and item.get("type") == was.get("type") == "SimpleItem" and "coordinate" not in was:
                changed = {"doJumpId", "AMSLAltAboveTerrain", "Altitude", "AltitudeMode"}
                changed |= {"params"} if item["command"] == Command.DO_JUMP else set()
                yield _merged(was, before, item) | {key: item[key] for key in item if key in changed}
            else:
                yield item


def _comparable(item: Table) -> str:
    return json.dumps({key: value for key, value in item.items() if key != "doJumpId"}, sort_keys=True)
