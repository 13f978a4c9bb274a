"""`.waypoints` (QGC WPL 110): twelve fields a line, home on line 0; written strictly, read leniently.

The format holds neither a fence, nor rally points, nor which autopilot it is for. Ground stations take a terrain
altitude in it for AMSL, so none is written. PX4 turns the vehicle north where a param4 of NaN becomes 0: NaN stays.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import Command, Frame, command_name
from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text, write_atomically
from ipoa_mission.items import Item, Mission
from ipoa_mission.mission.firmware import home_item, settle_frames
from ipoa_mission.mission.parameter_file import write_beside
from ipoa_mission.world.frame import Geodetic

FIRST_LINE = "QGC WPL 110"
PARAMS = ("param1", "param2", "param3", "param4")
FIELDS = ("seq", "current", "frame", "command", *PARAMS, "latitude", "longitude", "altitude", "autocontinue")
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?nan", re.ASCII | re.IGNORECASE)


def write_waypoints(mission: Mission, path: str | Path) -> tuple[str, ...]:
    """Write home and items; what the format cannot hold is returned in words, for the caller to tell.

    The mission's parameters go beside it (NAME.params).

    Raises:
        BadInput: the file cannot be written, or an altitude is above terrain or no number.
    """
    items = settle_frames(mission.items, mission.autopilot)
    for number, item in enumerate((home_item(mission.home), *items)):
        _check(number, item)
    if mission.autopilot is Autopilot.ARDUPILOT:
        items = tuple(map(_without_nan, items))
    lines = [FIRST_LINE, *(_line(seq, item) for seq, item in enumerate((home_item(mission.home), *items)))]
    write_beside(mission, Path(path))
    write_atomically(Path(path), "\n".join(lines) + "\n")
    return left_out(mission)


def left_out(mission: Mission) -> tuple[str, ...]:
    """What of a mission a `.waypoints` file cannot hold, in words."""
    parts = {"the geofence": mission.fence, "the rally points": mission.rally}
    return tuple(f"{name} cannot be held by a .waypoints file" for name, what in parts.items() if what)


def read_waypoints(path: Path, autopilot: Autopilot = Autopilot.PX4) -> Mission:
    """Read home and items; CRLF, blank lines and `#` comments are let pass.

    Raises:
        BadInput: the message names line and field, as in `a.waypoints: line 4: latitude: expected a number, not "x"`.
    """
    rows = list(_rows(path, read_text(path)))
    if not rows:
        raise BadInput(f"{path}: expected a first item that is home, but there is none")
    (line, first), *others = rows
    if first.command != Command.NAV_WAYPOINT:
        raise BadInput(
            f"{path}: line {line}: command: expected 16 (item 0 is home), not {first.command}",
            hint="a file whose first item is a take-off lost its home item: put one before it",
        )
    if abs(first.latitude_deg) > 90:
        raise BadInput(f"{path}: line {line}: latitude: expected degrees from -90 to 90, not {first.latitude_deg:g}")
    home = Geodetic(first.latitude_deg, first.longitude_deg, first.altitude)
    return Mission(home, settle_frames([item for _, item in others], autopilot), autopilot)


# --- writing ----------------------------------------------------------------------------------------------------


def _check(number: int, item: Item) -> None:
    where = f"item {number} ({command_name(item.command)})" if number else "home"
    if item.frame in (Frame.GLOBAL_TERRAIN_ALT, Frame.GLOBAL_TERRAIN_ALT_INT):
        raise BadInput(
            f"{where}: expected an altitude above home or AMSL, not above terrain: "
            "ground stations would read it as AMSL in a .waypoints file",
            hint="write a .plan file",
        )
    if not all(map(math.isfinite, (item.latitude_deg, item.longitude_deg, item.altitude))):
        raise BadInput(f"{where}: expected a finite position, not one with {item.altitude} for an altitude")


def _without_nan(item: Item) -> Item:
    """The item with 0 for NaN, which means the same to ArduPilot: its own ground stations cannot read NaN."""
    p1, p2, p3, p4 = (0.0 if math.isnan(param) else param for param in item.params)
    return replace(item, params=(p1, p2, p3, p4))


def _line(seq: int, item: Item) -> str:
    params = [_number(value) for value in item.params]
    place = [_number(value, 8) for value in (item.latitude_deg, item.longitude_deg)]
    head = (seq, int(seq == 0), int(item.frame), int(item.command))
    return "\t".join(map(str, (*head, *params, *place, _number(item.altitude), int(item.autocontinue))))


def _number(value: float, least_digits: int = 6) -> str:
    """The shortest decimal that reads back as the same number, without an exponent."""
    return np.format_float_positional(value, unique=True, min_digits=least_digits)


# --- reading ----------------------------------------------------------------------------------------------------


def _rows(path: Path, text: str) -> Iterator[tuple[int, Item]]:
    """Line number and item of every line that holds one."""
    first, *others = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if first.split() != FIRST_LINE.split():
        raise BadInput(f'{path}: line 1: expected "{FIRST_LINE}", not "{first[:40]}"')
    seq = 0
    for number, line in enumerate(others, start=2):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, _item(_Line(path, number, line.split()), seq)
            seq += 1


class _Line:
    """The fields of one line, by name."""

    def __init__(self, path: Path, number: int, fields: list[str]) -> None:
        self.where = f"{path}: line {number}"
        if len(fields) != len(FIELDS):
            raise BadInput(f"{self.where}: expected {len(FIELDS)} fields, not {len(fields)}")
        self.fields = dict(zip(FIELDS, fields, strict=True))

    def number(self, name: str) -> float:
        """A finite number; params may also be `nan`."""
        if not NUMBER.fullmatch(self.fields[name]):
            raise self.wrong(name, "a number")
        value = float(self.fields[name])
        if math.isfinite(value) or (math.isnan(value) and name in PARAMS):
            return value
        raise self.wrong(name, "a finite number")

    def degrees(self, name: str) -> float:
        """Degrees that MAVLink can carry; a latitude beyond 90 is left to the check of the mission."""
        value = self.number(name)
        if abs(value) > 180:
            raise self.wrong(name, "degrees from -180 to 180")
        return value

    def whole(self, name: str, most: int) -> int:
        """A whole number from 0 to `most`."""
        value = self.number(name)
        if not (value.is_integer() and 0 <= value <= most):
            raise self.wrong(name, f"a whole number from 0 to {most}")
        return int(value)

    def wrong(self, name: str, expected: str) -> BadInput:
        """The error that says what was expected in a field."""
        return BadInput(f'{self.where}: {name}: expected {expected}, not "{self.fields[name][:40]}"')


def _item(line: _Line, seq: int) -> Item:
    if line.whole("seq", 65535) != seq:
        raise line.wrong("seq", str(seq))
    line.whole("current", 3)
    frame = line.whole("frame", 255)
    p1, p2, p3, p4 = (line.number(name) for name in PARAMS)
    return Item(
        line.whole("command", 65535),
        frame,
        (p1, p2, p3, p4),
        line.number("latitude") if frame == Frame.MISSION else line.degrees("latitude"),
        line.number("longitude") if frame == Frame.MISSION else line.degrees("longitude"),
        line.number("altitude"),
        bool(line.whole("autocontinue", 1)),
    )
