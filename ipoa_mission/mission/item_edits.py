from collections.abc import Callable, Sequence
from dataclasses import replace

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.complex_items import entries
from ipoa_mission.mission.items import Item, Mission


def with_item(mission: Mission, seq: int, item: Item) -> Mission:
    """Replace an item outside surveys and scans."""
    _expect_alone(mission, seq)
    return replace(mission, items=(*mission.items[: seq - 1], item, *mission.items[seq:]))


def with_inserted(mission: Mission, seq: int, item: Item) -> Mission:
    if not 1 <= seq <= len(mission.items) + 1:
        words = f"expected a number from 1 to {len(mission.items) + 1}"
        raise BadInput(words, code="no-such-item", place=f"item {seq}")
    if (of := _complex_at(mission, seq)) is not None and of.start < seq:
        raise _one_of(seq, of)
    items = [_jumping(one, lambda target: target + (target >= seq)) for one in mission.items]
    scanned = tuple((first + (first >= seq - 1), height) for first, height in mission.scanned)
    return replace(mission, items=(*items[: seq - 1], item, *items[seq - 1 :]), scanned=scanned)


def without_item(mission: Mission, seq: int) -> Mission:
    """Remove an item outside surveys and scans that is no jump's target."""
    _expect_alone(mission, seq)
    for number, item in enumerate(mission.items, start=1):
        leads_here = item.command == Command.DO_JUMP and item.params[0] == seq
        of_tag = item.command == Command.DO_JUMP_TAG and mission.items[seq - 1].command == Command.JUMP_TAG
        if number != seq and (leads_here or (of_tag and item.params[0] == mission.items[seq - 1].params[0])):
            raise BadInput(
                f"expected no jump to it, but item {number} has one",
                hint=f"change item {number} first",
                place=f"item {seq}",
            )
    items = [_jumping(one, lambda target: target - (target > seq)) for one in mission.items]
    scanned = tuple((first - (first >= seq), height) for first, height in mission.scanned)
    return replace(mission, items=(*items[: seq - 1], *items[seq:]), scanned=scanned)


def with_plain_items(mission: Mission, seq: int) -> Mission:
    of = _complex_at(mission, seq)
    if of is None:
        return mission
    here = repr(mission.items[of.start - 1 : of.stop - 1])  # repr: NaN equals NaN
    return replace(mission, complex_items=tuple(one for one in mission.complex_items if repr(one.items) != here))


def complex_at(mission: Mission) -> tuple[range | None, ...]:
    """Return the item numbers of each item's survey or scan."""
    found: list[range | None] = []
    for entry in entries(mission.items, mission.complex_items):
        numbers = None if entry.of is None else range(entry.first + 1, entry.first + 1 + entry.count)
        found += [numbers] * entry.count
    return tuple(found)


def _complex_at(mission: Mission, seq: int) -> range | None:
    found: Sequence[range | None] = complex_at(mission)
    return found[seq - 1] if 1 <= seq <= len(found) else None


def _expect_alone(mission: Mission, seq: int) -> None:
    if not 1 <= seq <= len(mission.items):
        raise BadInput(f"expected a number from 1 to {len(mission.items)}", code="no-such-item", place=f"item {seq}")
    if (of := _complex_at(mission, seq)) is not None:
        raise _one_of(seq, of)


def _one_of(seq: int, of: range) -> BadInput:
    return BadInput(
        f"expected an item outside QGroundControl's surveys and scans, not item {seq} of {of.start} to {of.stop - 1}",
        hint="make plain items of the survey or scan first",
        code="complex-item",
    )


def _jumping(item: Item, moved: Callable[[int], int]) -> Item:
    if item.command != Command.DO_JUMP or not float(item.params[0]).is_integer():
        return item
    return replace(item, params=(float(moved(int(item.params[0]))), *item.params[1:]))
