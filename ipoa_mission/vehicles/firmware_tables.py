"""What a firmware takes in a mission, and what it keeps of it, by version: tables, no behavior.

The tables are read in each version's source by `tools.generate.firmware_tables`; how a list is kept was measured on
ArduCopter 4.7.0-dev and PX4 1.17.0. A row gives, for each of the seven params, what a read-back returns:

    `.` what was sent          `-` 0                          `b` 1 where positive, else 0
    `w` cut to a whole number  `s` 1 or -1, by its sign       `y` a heading wrapped into 0 to 360
    `c` cut to centimetres     `m` cut to whole metres        `d` degrees in steps of 1e-7
    `t` turns: whole, below one in 256ths                     `r` a radius: whole metres to 255, tens of metres to 2550
    `h` half precision
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ipoa_mission.errors import BadInput
from ipoa_mission.mission.commands import Command, Frame
from ipoa_mission.vehicles.jump_profile import JumpProfile
from ipoa_mission.vehicles.version import Version

NO_VERSION = Version(0, 0)


@dataclass(frozen=True)
class Firmware:
    """The habits of one firmware: a command is in `placed` (with a position), in `plain` (frame 2), or in neither."""

    name: str
    autopilot: str  # as scenarios name it
    home_is_item_0: bool  # on the wire and in the counting of DO_JUMP
    keeps_autocontinue: bool
    fence: Mapping[int, str]
    rally: Mapping[int, str]
    fence_is_union: bool  # of areas to stay in: inside one is enough; else the vehicle must be inside all
    max_items: int  # the home item counts
    max_fence_items: int
    max_rally_points: int
    highest_altitude: float  # [m]; items as far above or below are refused
    longest_hold: float = math.inf  # [s]
    holds_whole_seconds: bool = False
    nan_holds: bool = False  # a hold of NaN is one for ever
    photo_looks_s: float = 0.02  # so often it is looked whether the vehicle is far enough on for the next photo [s]
    frame_2_is_amsl: bool = False  # of an item that needs a place
    jumps: JumpProfile = field(default_factory=JumpProfile)
    version: Version = NO_VERSION  # of the table: major and minor
    commit: str = ""  # of the source that was read, and its day
    date: str = ""
    frames: frozenset[int] = frozenset()  # of commands with a position
    placed: Mapping[int, str] = field(default_factory=dict)
    plain: Mapping[int, str] = field(default_factory=dict)
    takes_nan: Mapping[int, frozenset[int]] | None = None  # which params; None: NaN is taken anywhere
    used: Mapping[int, frozenset[int]] | None = None  # params that may be other than 0 or NaN; None: any may
    roi_modes: Mapping[str, frozenset[int]] = field(default_factory=dict)  # param1, in `placed` and in `plain`
    sixteen_bits: frozenset[int] = frozenset()  # refused unless param1 fits in them, without a sign
    never_flown: frozenset[int] = frozenset()  # taken and kept, and then no mission with it is flown
    renames: Mapping[int, int] = field(default_factory=dict)  # stored under another number

    def kept(self, command: int, frame: int) -> str | None:
        """The row for an item, seven letters; None where the firmware has no such command."""
        tables = (self.plain, self.placed) if frame == Frame.MISSION else (self.placed, self.plain)
        for table in (*tables, self.fence, self.rally):
            if command in table:
                return table[command]
        return None

    def takes(self, command: int) -> bool:
        """Whether a mission may hold it."""
        return command in self.placed or command in self.plain

    def __str__(self) -> str:
        return f"{self.name} {self.version.major}.{self.version.minor}"


def rows(rows: Mapping[str, str]) -> Mapping[int, str]:
    """Row of each command, from the commands of each row; one that the package has no name for is its number."""
    return {
        int(name) if name.isdigit() else int(Command[name]): row
        for row, names in rows.items()
        for name in names.split()
    }


def _numbers(words: str) -> frozenset[int]:
    return frozenset(map(int, words.split()))


def _commands(names: str) -> frozenset[int]:
    return frozenset(int(Command[name]) for name in names.split())


def _slots(table: Mapping[str, Any], name: str) -> Mapping[int, frozenset[int]] | None:
    """Some of the seven params, by command; None where a table has none of this name."""
    return {command: _numbers(row) for command, row in rows(table[name]).items()} if name in table else None


class FirmwareTables:
    """The tables of one firmware by series, read from a file made by `tools.generate.firmware_tables`."""

    def __init__(self, habits: Firmware, path: Path) -> None:
        self._habits, self.path = habits, path
        self._made: dict[tuple[int, int], Firmware] = {}

    @cached_property
    def _tables(self) -> Mapping[tuple[int, int], Mapping[str, Any]]:
        """By series, oldest first."""
        read = json.loads(self.path.read_text(encoding="utf-8")) if self.path.exists() else {}
        return {Version.parsed(name).series: table for name, table in read.items()}

    @property
    def series(self) -> tuple[tuple[int, int], ...]:
        """The series that have a table, oldest first; where there is no file, that of the habits alone."""
        return tuple(self._tables) or (self._habits.version.series,)

    def of(self, version: Version) -> Firmware:
        """The tables of a version: those of its series, or of the nearest one that has some.

        >>> from ipoa_mission.vehicles.autopilot import Autopilot
        >>> str(Autopilot.PX4.tables.of(Version(1, 16, 2)))
        'PX4 1.16'
        """
        known = self.series
        if not self._tables:
            return self._habits
        older = [series for series in known if series <= version.series]
        series = older[-1] if older else known[0]
        if series not in self._made:
            self._made[series] = self._read(series)
        return self._made[series]

    def _read(self, series: tuple[int, int]) -> Firmware:
        table = self._tables[series]
        return replace(
            self._habits,
            version=Version(*series),
            commit=table["commit"],
            date=table["date"],
            jumps=replace(self._habits.jumps, resets=table.get("resets_jumps", False)),
            frames=_numbers(table["frames"]),
            placed=rows(table["placed"]),
            plain=rows(table["plain"]),
            takes_nan=_slots(table, "nan"),
            used=_slots(table, "used"),
            roi_modes={where: _numbers(modes) for where, modes in table.get("roi", {}).items()},
            sixteen_bits=_commands(table.get("sixteen_bits", "")),
            never_flown=_commands(table.get("never_flown", "")),
            renames={int(Command[one]): int(Command[other]) for one, other in table.get("renames", {}).items()},
        )

    def expect(self, version: Version) -> Version:
        """The version, if there is a table of it.

        Raises:
            BadInput: there is none, with those that there are.
        """
        if version.series not in self.series:
            names = ", ".join(f"{major}.{minor}" for major, minor in self.series)
            words = f"expected one of {self._habits.autopilot}'s {names}, not {version}"
            raise BadInput(words, code="unknown-version", place="firmware version")
        return version
