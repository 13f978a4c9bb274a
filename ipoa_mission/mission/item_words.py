import math
from collections.abc import Iterable

import numpy as np

from ipoa_mission.autopilot.commands import Command, short_name
from ipoa_mission.mission.items import Item

HOLDS = frozenset({Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_TIME, Command.NAV_DELAY})


def hold_of(item: Item) -> float | None:
    return item.params[0] if item.command in HOLDS and item.params[0] > 0 else None


def details_of(item: Item) -> str:
    """Return params in words, without hold and speed."""
    first, second = item.params[:2]
    match item.command:
        case Command.DO_JUMP | Command.DO_JUMP_TAG:
            target = "tag" if item.command == Command.DO_JUMP_TAG else "item"
            return f"to {target} {first:g}, " + ("without end" if second == -1 else f"{second:g} times")
        case Command.JUMP_TAG:
            return f"tag {first:g}"
        case Command.NAV_DELAY if item.clock:
            return f"until {item.clock}"
        case Command.NAV_LOITER_TURNS:
            direction = ", counterclockwise" if item.params[2] < 0 else ""
            return f"{first:g} turn{'' if first == 1 else 's'}, radius {abs(item.params[2]):g} m{direction}"
        case Command.NAV_ARC_WAYPOINT:
            return f"{first:g} degrees"
        case Command.NAV_WAYPOINT if second > 0:
            return f"within {second:g} m"
        case Command.NAV_TAKEOFF | Command.NAV_LAND | Command.NAV_RETURN_TO_LAUNCH | Command.DO_CHANGE_SPEED:
            return ""
        case command if command in HOLDS:
            return ""
    return ", ".join(f"param{n} {value:g}" for n, value in enumerate(item.params, 1) if value and math.isfinite(value))


def count_words(count: int, noun: str = "item") -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def name_items(seqs: Iterable[int]) -> str:
    """Return "items 3 to 5, 7" for 3, 4, 5 and 7."""
    numbers = np.unique(list(seqs))
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    words = ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    return f"item{'s' if len(numbers) > 1 else ''} {words}"


def item_words(item: Item) -> str:
    match item.command:
        case Command.NAV_TAKEOFF:
            name = "take off"
        case Command.DO_CHANGE_SPEED:
            name = f"speed {item.params[1]:g} m/s"
        case _:
            name = short_name(item.command)
    hold = hold_of(item)
    return ", ".join(filter(None, [name, details_of(item), "" if hold is None else f"hold {hold:g} s"]))
