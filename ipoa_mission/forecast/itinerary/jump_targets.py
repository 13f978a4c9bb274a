"""Resolve targets and repeats of DO_JUMP and DO_JUMP_TAG; indices count from 0."""

import math
from collections.abc import Iterator, Sequence

from ipoa_mission.autopilot.commands import JUMPS, Command
from ipoa_mission.mission.items import Item


def jump_target(items: Sequence[Item], index: int, first: int = 1) -> int | None:
    """Return the target of the jump at `index`, the first of two with its tag.

    `first` is the number of the first item for DO_JUMP.
    """
    asked = items[index].params[0]
    if not math.isfinite(asked):
        return None
    if items[index].command == Command.DO_JUMP_TAG:
        return next(tagged(items, asked), None)
    target = int(asked) - first
    return target if 0 <= target < len(items) else None


def tagged(items: Sequence[Item], tag: float) -> Iterator[int]:
    tags = (n for n, item in enumerate(items) if item.command == Command.JUMP_TAG)
    return (n for n in tags if math.isfinite(items[n].params[0]) and int(items[n].params[0]) == int(tag))


def repeats(item: Item) -> float:
    return math.inf if not item.params[1] >= 0 else int(item.params[1])


def led_to(items: Sequence[Item], index: int, moving: frozenset[int]) -> Iterator[int]:
    """Return the possible `moving` targets of a jump, through other jumps too."""
    ahead, seen = [jump_target(items, index) if repeats(items[index]) else None], {index}
    while ahead:
        at = ahead.pop()
        if at is None or at in seen or at >= len(items):
            continue
        seen.add(at)
        if items[at].command in moving:
            yield at
        elif items[at].command in JUMPS:
            ahead += [at + 1, jump_target(items, at) if repeats(items[at]) else None]
        else:
            ahead.append(at + 1)
