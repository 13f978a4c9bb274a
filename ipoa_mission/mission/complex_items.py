"""QGroundControl's complex items (surveys, scans).

One is written back only with exactly its items in a row, and no jump into them.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.mission.items import ComplexItem, Item
from ipoa_mission.mission.json_node import Node

TRANSECTS, ITEMS = "TransectStyleComplexItem", "Items"


@dataclass(frozen=True)
class Written:
    """A plain item, or `count` items of the complex item `of` from `first` on."""

    first: int
    count: int
    of: ComplexItem | None = None


def complex_item(items: Sequence[Item], document: Any) -> ComplexItem:
    kept = dict(document)
    has_items = isinstance(kept.get(TRANSECTS), dict) and ITEMS in kept[TRANSECTS]
    if has_items:
        kept[TRANSECTS] = {key: value for key, value in kept[TRANSECTS].items() if key != ITEMS}
    return ComplexItem(tuple(items), json.dumps(kept, sort_keys=True), has_items)


def complex_items_in(parts: Sequence[Node | None], items: Sequence[Item]) -> tuple[ComplexItem, ...]:
    """`parts`: the complex item of each mission item."""
    found = []
    for place, numbers in groupby(range(len(items)), lambda n: None if (part := parts[n]) is None else part.place):
        first, *others = numbers
        if place is not None and (part := parts[first]) is not None:
            found.append(complex_item(items[first : first + 1 + len(others)], part.value))
    return tuple(found)


def entries(items: Sequence[Item], complexes: Sequence[ComplexItem]) -> Iterator[Written]:
    targets = {int(item.params[0]) - 1 for item in items if item.command == Command.DO_JUMP}
    first = 0
    while first < len(items):
        of = next((one for one in complexes if _is_here(one, items, first, targets)), None)
        yield Written(first, 1 if of is None else len(of.items), of)
        first += 1 if of is None else len(of.items)


def _is_here(one: ComplexItem, items: Sequence[Item], first: int, targets: set[int]) -> bool:
    last = first + len(one.items)
    if not one.items or items[first].command != one.items[0].command or last > len(items):
        return False
    return repr(tuple(items[first:last])) == repr(one.items) and targets.isdisjoint(
        range(first, last)
    )  # repr: NaN equals NaN


def as_document(one: ComplexItem, number: int, simple: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """`simple` are its items; the first is mission item `number`."""
    document: dict[str, Any] = json.loads(one.json_text)
    if one.has_items:
        own = ("autoContinue", "command", "frame", "params", "type")
        document[TRANSECTS][ITEMS] = [
            {key: item[key] for key in own} | {"doJumpId": number + n} for n, item in enumerate(simple)
        ]
    return document
