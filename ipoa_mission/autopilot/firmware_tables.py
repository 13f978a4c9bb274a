"""Mission items that a firmware accepts and stores, by version.

`tools.generate.firmware_tables` reads the tables in the sources. The read-back was measured on ArduCopter 4.7.0-dev and
PX4 1.17.0. A row gives the read-back of each of the seven params:

    `.` as sent                `-` 0                          `b` 1 if positive, else 0
    `w` truncated to integer   `s` 1 or -1, by its sign       `y` a heading wrapped into 0 to 360
    `c` truncated to cm        `m` truncated to m             `d` degrees in steps of 1e-7
    `t` turns: integer, below one in 256ths                   `r` a radius: in m to 255, in 10 m to 2550
    `h` half precision
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.guidance_profile import JumpProfile
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput

NO_VERSION = Version(0, 0)
POLYGON = frozenset({Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION})
PARAM_NAMES = ("param1", "param2", "param3", "param4", "latitude", "longitude", "altitude")


@dataclass(frozen=True)
class Firmware:
    """One firmware's tables: `placed` commands have a position, `plain` are in frame 2."""

    name: str
    autopilot: str
    home_is_item_0: bool  # also as target of DO_JUMP
    keeps_autocontinue: bool
    fence: Mapping[int, str]
    rally: Mapping[int, str]
    max_items: int  # with home
    max_fence_items: int
    max_rally_points: int
    highest_altitude: float  # |altitude| must be below [m]
    longest_hold: float = math.inf  # [s]
    holds_whole_seconds: bool = False
    nan_holds: bool = False  # of NaN: without end
    photo_looks_s: float = 0.02  # polling of the photo distance [s]
    frame_2_is_amsl: bool = False  # with a position
    jumps: JumpProfile = field(default_factory=JumpProfile)
    fence_union_by: tuple[str, int] = ("", 0)  # with this parameter's bit one inclusion is enough, else all count
    version: Version = NO_VERSION  # of the table: major, minor
    commit: str = ""  # of the source, with its `date`
    date: str = ""
    frames: frozenset[int] = frozenset()  # with a position
    placed: Mapping[int, str] = field(default_factory=dict)
    plain: Mapping[int, str] = field(default_factory=dict)
    takes_nan: Mapping[int, frozenset[int]] | None = None  # params; None: all
    used: Mapping[int, frozenset[int]] | None = None  # params other than 0 or NaN; None: all
    roi_modes: Mapping[str, frozenset[int]] = field(default_factory=dict)  # param1 in `placed` and `plain`
    sixteen_bits: frozenset[int] = frozenset()  # param1, unsigned
    never_flown: frozenset[int] = frozenset()  # accepted, but refused at the start
    renames: Mapping[int, int] = field(default_factory=dict)  # stored as another command

    def kept(self, command: int, frame: int) -> str | None:
        """Return an item's row; None: no such command."""
        tables = (self.plain, self.placed) if frame == Frame.MISSION else (self.placed, self.plain)
        for table in (*tables, self.fence, self.rally):
            if command in table:
                return table[command]
        return None

    def takes(self, command: int) -> bool:
        return command in self.placed or command in self.plain

    def __str__(self) -> str:
        return f"{self.name} {self.version.major}.{self.version.minor}"


def rows(rows: Mapping[str, str]) -> Mapping[int, str]:
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
    return {command: _numbers(row) for command, row in rows(table[name]).items()} if name in table else None


class FirmwareTables:
    """Tables by series, from the file of `tools.generate.firmware_tables`."""

    def __init__(self, defaults: Firmware, path: Path) -> None:
        self._defaults, self.path = defaults, path

    @cached_property
    def _tables(self) -> Mapping[tuple[int, int], Firmware]:
        if not self.path.exists():
            return {self._defaults.version.series: self._defaults}
        read = json.loads(self.path.read_text(encoding="utf-8"))
        tables = (self._read(Version.parsed(name), table) for name, table in read.items())
        return {table.version.series: table for table in tables}

    @property
    def series(self) -> tuple[tuple[int, int], ...]:
        return tuple(self._tables)

    def of(self, version: Version) -> Firmware:
        """Return a series' table, that of the nearest older one, or the oldest.

        >>> from ipoa_mission.autopilot.autopilot import Autopilot
        >>> str(Autopilot.PX4.tables.of(Version(1, 16, 2)))
        'PX4 1.16'
        """
        older = [series for series in self.series if series <= version.series]
        return self._tables[older[-1] if older else self.series[0]]

    def _read(self, version: Version, table: Mapping[str, Any]) -> Firmware:
        return replace(
            self._defaults,
            version=version,
            commit=table["commit"],
            date=table["date"],
            jumps=replace(self._defaults.jumps, resets=table.get("resets_jumps", False)),
            frames=_numbers(table["frames"]),
            placed=rows(table["placed"]),
            plain=rows(table["plain"]),
            takes_nan=_slots(table, "nan"),
            used=_slots(table, "used"),
            roi_modes={where: _numbers(modes) for where, modes in table.get("roi", {}).items()},
            sixteen_bits=_commands(table.get("sixteen_bits", "")),
            never_flown=_commands(table.get("never_flown", "")),
            renames={int(Command[sent]): int(Command[stored]) for sent, stored in table.get("renames", {}).items()},
        )

    def expect(self, version: Version) -> Version:
        """Raise BadInput if the version's series has no table."""
        if version.series not in self.series:
            names = ", ".join(f"{major}.{minor}" for major, minor in self.series)
            words = f"expected one of {self._defaults.autopilot}'s {names}, not {version}"
            raise BadInput(words, code="unknown-version", place="firmware version")
        return version


class Refused(NamedTuple):
    """MAV_MISSION_RESULT, number of the wrong value or 0, reason."""

    result: str
    param: int = 0
    words: str = ""


Refusal: TypeAlias = Callable[[Firmware, int, int, Sequence[float]], Refused | None]


class Refusals(NamedTuple):
    """Checks of each list; `mission` takes the number of items on the wire, `ends` all commands."""

    mission: Callable[[Firmware, int, int, Sequence[float], int], Refused | None]
    fence: Refusal
    rally: Refusal
    ends: Callable[[Set[int], Mapping[str, float]], Refused | None] = lambda *_: None
