"""Items over all commands, params and kinds of values, and real autopilots' verdicts.

A record's rows are by command and frame: a letter for each of 7 params times 4 values, in the order of `VALUES`. The
letter is the MAV_MISSION_RESULT in base 36. All other params are 0, and its place is near home.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.version import Version
from ipoa_mission.mission.items import Item

RECORDS = Path(__file__).parent / "data" / "recorded_verdicts"
PLACE = (47.3978, 8.5457, 20.0)
#: 0, NaN, 1, and out of range, for each param.
VALUES = 4 * ((0.0, math.nan, 1.0, 1e6),) + 2 * ((0.0, math.nan, 1.0, 181.0),) + ((0.0, math.nan, 1.0, 1e6),)
#: In no mission of either firmware, or unknown.
STRANGERS = (0, 1, 23, 95, 176, 186, 192, 300, 31_999)
COMMANDS = tuple(sorted({*map(int, Command), *STRANGERS}))
FRAMES = (Frame.GLOBAL_RELATIVE_ALT_INT, Frame.MISSION)
LETTERS = "0123456789abcdefghijklmnopqrstuvwxyz"
SLOTS = range(7)
#: A whole-number altitude in ArduPilot: NaN ends its simulator.
UNASKED = frozenset({int(Command.DO_GIMBAL_MANAGER_PITCHYAW)})
UNKNOWN = "?"


def item(command: int, frame: int, slot: int, value: float) -> Item:
    """The item with this value in one of its seven params."""
    values = [0.0] * 4 + list(PLACE if frame != Frame.MISSION else (0.0, 0.0, 0.0))
    values[slot] = value
    return Item(command, frame, tuple(values[:4]), *values[4:])  # type: ignore[arg-type]


def row(command: int, frame: int) -> Iterator[Item]:
    """The 28 items of a row."""
    for slot in SLOTS:
        for value in VALUES[slot]:
            yield item(command, frame, slot, value)


@dataclass(frozen=True)
class Record:
    """`rows` by command and frame; `table`: the version whose table is to agree."""

    autopilot: Autopilot
    table: Version
    says: str
    commit: str
    rows: dict[tuple[int, int], str]

    def verdicts(self) -> Iterator[tuple[Item, int]]:
        for (command, frame), letters in self.rows.items():
            for item_there, letter in zip(row(command, frame), letters, strict=True):
                if letter != UNKNOWN:
                    yield item_there, LETTERS.index(letter)


def read_record(path: Path) -> Record:
    read = json.loads(path.read_text(encoding="utf-8"))
    rows = {tuple(map(int, key.split())): letters for key, letters in read["rows"].items()}
    return Record(autopilot_named(read["autopilot"]), Version.parsed(read["table"]), read["says"], read["commit"], rows)  # type: ignore[arg-type]
