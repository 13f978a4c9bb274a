"""QGroundControl's complex items (surveys, scans).

One is written back only with exactly its items in a row, and without a jump into them.
"""

import json
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NoReturn

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.items import ComplexItem, Item
from ipoa_mission.mission.json_node import Node

TRANSECTS = "TransectStyleComplexItem"
ITEMS = "Items"


def complex_items_in(parts: Sequence[Node | None], items: Sequence[Item]) -> tuple[ComplexItem, ...]:
    groups: dict[str, tuple[Node, list[Item]]] = {}
    for part, item in zip(parts, items, strict=True):
        if part is not None:
            groups.setdefault(part.place, (part, []))[1].append(item)

    return tuple(ComplexItem(tuple(of_part), json.dumps(part.value)) for part, of_part in groups.values())


def entries(items: Sequence[Item], complexes: Sequence[ComplexItem]) -> Iterator[tuple[range, ComplexItem | None]]:
    """Yield a range of item indices for each plain item (None) and each complex item."""
    targets = {int(item.params[0]) - 1 for item in items if item.command == Command.DO_JUMP}

    first = 0
    while first < len(items):
        of = next((each for each in complexes if _is_here(each, items, first, targets)), None)
        end = first + (1 if of is None else len(of.items))
        yield range(first, end), of
        first = end


def _is_here(part: ComplexItem, items: Sequence[Item], first: int, targets: set[int]) -> bool:
    end = first + len(part.items)
    if not part.items or items[first].command != part.items[0].command or end > len(items):
        return False
    is_same = repr(tuple(items[first:end])) == repr(part.items)  # repr: NaN equals NaN
    return is_same and targets.isdisjoint(range(first, end))


def as_document(part: ComplexItem, number: int, simple: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """`simple` are its items; the first is mission item `number`."""
    document: dict[str, Any] = json.loads(part.json_text, parse_constant=partial(_refuse_constant, number))

    holder = document.get(TRANSECTS, document)
    keys = ("autoContinue", "command", "frame", "params", "type")
    holder[ITEMS] = [{key: item[key] for key in keys} | {"doJumpId": number + n} for n, item in enumerate(simple)]
    return document


def _refuse_constant(number: int, name: str) -> NoReturn:
    raise BadInput(f"expected finite numbers, not {name}", place=f"complex item at item {number}")
