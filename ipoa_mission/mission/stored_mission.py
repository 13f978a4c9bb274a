"""From a mission to the items that go over the wire, and back, for each firmware (tables: `autopilots.firmware`).

ArduPilot's list begins with home and it flies from item 1; PX4's begins with the first thing done. That is the
oldest trap of mission uploads (a list without home is accepted, and its take-off silently vanishes), and it is
dealt with here and nowhere else.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.mission.commands import Command, Frame, command_name, plain_frame
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.firmware_tables import Firmware
from ipoa_mission.vehicles.refusal import PARAM_NAMES
from ipoa_mission.vehicles.version import Version
from ipoa_mission.world.frame import Geodetic

#: Centimetres by which an altitude may come back lower: the cut is made in single precision, and so may be one off.
ALTITUDE_SLACK = 0.0101  # [m]
YAW_SLACK = 1e-3  # [deg], of a heading that went through radians in single precision


def to_wire(mission: Mission) -> tuple[Item, ...]:
    """The items as `mission.autopilot` wants them: seq is the index; home first for ArduPilot, not at all for PX4.

    Commands without a position go in frame 2 (PX4 refuses them in any other), DO_JUMP counts as the autopilot does,
    and NaN ("your own") becomes 0 where ArduPilot refuses NaN.
    """
    own = mission.autopilot.firmware(mission.firmware_version)
    items = tuple(_spoken(item, own) for item in mission.items)
    return (home_item(mission.home), *items) if own.home_is_item_0 else items


def from_wire(items: Sequence[Item], autopilot: Autopilot, home: Geodetic | None = None) -> Mission:
    """The mission behind a downloaded list; frames lose their `_INT`, commands without a position get frame 2.

    `home` is what the vehicle itself says; without it ArduPilot's item 0 serves.

    Raises:
        MissionError: a PX4 list holds no home and none is given.
    """
    own = autopilot.firmware()
    if own.home_is_item_0:
        first, items = items[:1], items[1:]
        if home is None and first:
            home = Geodetic(first[0].latitude_deg, first[0].longitude_deg, first[0].altitude)
    if home is None:
        words = f"{own.name} sent no home with its mission, and none is known"
        raise MissionError(words, hint="wait until the vehicle has a position fix", code="home-missing", place="home")
    return Mission(home, tuple(_heard(item, own) for item in items), autopilot)


def settle_frames(items: Sequence[Item], autopilot: Autopilot) -> tuple[Item, ...]:
    """The items with frames as a `Mission` and its files have them: no `_INT`, and frame 2 for what has no position."""
    return tuple(replace(item, frame=_plain_frame(item, autopilot.firmware())) for item in items)


def home_item(home: Geodetic) -> Item:
    """Item 0 of ArduPilot's list and of a `.waypoints` file: a waypoint at home, frame 0, AMSL."""
    return Item(Command.NAV_WAYPOINT, Frame.GLOBAL, (0.0,) * 4, home.latitude_deg, home.longitude_deg, home.altitude)


def as_stored(items: Sequence[Item], autopilot: Autopilot, version: Version | None = None) -> tuple[Item, ...]:
    """What reading back is known to give for items sent (mission, fence or rally), frames without their `_INT`.

    ArduPilot answers with its own home as item 0 of a mission: that one is given as sent. Floats are as MAVLink
    carries them, single precision; an item that the firmware does not know stays as it is.
    `version`: left out, the newest.
    """
    own = autopilot.firmware(version)
    return tuple(_stored(item, own) for item in items)


@dataclass(frozen=True)
class Difference:
    """The first thing that is not as it was sent; `seq` is the number on the wire, None if the counts differ."""

    seq: int | None
    field: str
    sent: str
    got: str

    def __str__(self) -> str:
        place = "the list" if self.seq is None else f"item {self.seq}"
        return f"{place}: {self.field}: sent {self.sent}, the vehicle holds {self.got}"


def compare(
    sent: Sequence[Item], got: Sequence[Item], autopilot: Autopilot, version: Version | None = None
) -> Difference | None:
    """The first difference between a list sent and the list read back, beyond what the firmware is known to change.

    Both as on the wire. A field agrees if it is as sent or as this firmware stores it; positions to the last degE7.
    `version` of the firmware: left out, an item agrees that any version would store so.
    ArduPilot's item 0 is its own home and not compared.
    """
    versions = (version,) if version else [Version(*series) for series in reversed(autopilot.tables.series)]
    newest, *older = (autopilot.firmware(one) for one in versions)
    if len(sent) != len(got):
        return Difference(None, "number of items", str(len(sent)), str(len(got)))
    for seq, (one, other) in enumerate(zip(sent, got, strict=True)):
        if seq == 0 and newest.home_is_item_0 and _is_home(one) and one.command == other.command:
            continue
        difference = _first_difference(one, other, newest)
        if difference and all(_first_difference(one, other, own) for own in older):
            return Difference(seq, *difference)
    return None


def _spoken(item: Item, firmware: Firmware) -> Item:
    if item.command == Command.DO_JUMP and not firmware.home_is_item_0:
        item = replace(item, params=(item.params[0] - 1.0, *item.params[1:]))
    if item.command not in firmware.placed and item.command in firmware.plain:
        item = replace(item, frame=int(Frame.MISSION))
    if firmware.takes_nan is None:
        return item
    own = firmware.takes_nan.get(item.command, frozenset())
    params = [0.0 if math.isnan(p) and n not in own else p for n, p in enumerate(item.params, start=1)]
    return replace(item, params=(params[0], params[1], params[2], params[3]))


def _heard(item: Item, firmware: Firmware) -> Item:
    if item.command == Command.DO_JUMP and not firmware.home_is_item_0:
        item = replace(item, params=(item.params[0] + 1.0, *item.params[1:]))
    return replace(item, frame=_plain_frame(item, firmware))


def _plain_frame(item: Item, firmware: Firmware) -> int:
    if item.command not in firmware.placed and item.command in firmware.plain:
        return int(Frame.MISSION)
    return plain_frame(item.frame)


def _is_home(item: Item) -> bool:
    return item.command == Command.NAV_WAYPOINT and plain_frame(item.frame) == Frame.GLOBAL


# --- what is kept -----------------------------------------------------------------------------------------------


def _single(value: float) -> float:
    """The number as MAVLink carries it; what does not fit is infinite."""
    with np.errstate(over="ignore"):
        return float(np.float32(value))


def _whole(value: float) -> float:
    return float(math.trunc(value)) if math.isfinite(value) else 0.0


def _centimeters(value: float) -> float:
    """Cut as ArduPilot cuts: times a hundred in single precision, then to an integer."""
    scaled = _single(_single(value) * 100.0)
    return _single(_single(math.trunc(scaled)) / 100.0) if math.isfinite(scaled) else 0.0


def _deg_e7(degrees: float) -> float:
    return round(degrees * 1e7) if math.isfinite(degrees * 1e7) else degrees


def _turns(value: float) -> float:
    return _whole(256.0 * value) / 256.0 if 0.0 < value < 1.0 else min(_whole(value), 255.0)


def _radius(value: float) -> float:
    size = abs(_whole(value))
    return math.copysign(size if size <= 255 else 10.0 * min(size // 10, 255), value)


def _half(value: float) -> float:
    with np.errstate(over="ignore"):
        return float(np.float16(value))


KEEP: Mapping[str, Callable[[float], float]] = {
    ".": _single,
    "-": lambda value: 0.0,
    "b": lambda value: float(value > 0.0),
    "s": lambda value: -1.0 if value < 0.0 else 1.0,
    "y": lambda value: _single(value % 360.0),
    "w": _whole,
    "c": _centimeters,
    "m": _whole,
    "d": lambda value: _deg_e7(value) / 1e7,
    "t": _turns,
    "r": _radius,
    "h": _half,
}


def _stored(item: Item, firmware: Firmware) -> Item:
    rows = firmware.kept(item.command, item.frame)
    if rows is None:
        return item
    p1, p2, p3, p4, p5, p6, p7 = (KEEP[letter](value) for letter, value in zip(rows, values_of(item), strict=True))
    command = firmware.renames.get(item.command, item.command)
    autocontinue = item.autocontinue if firmware.keeps_autocontinue else True
    return Item(command, _stored_frame(item, firmware), (p1, p2, p3, p4), p5, p6, p7, autocontinue)


def _stored_frame(item: Item, firmware: Firmware) -> int:
    frame = plain_frame(item.frame)
    unplaced = item.command in firmware.plain and item.command not in firmware.placed
    if firmware.home_is_item_0 and (unplaced or frame == Frame.MISSION or item.command in firmware.fence):
        return int(Frame.GLOBAL)  # ArduPilot has no frame 2 in its store, and gives a fence no frame at all
    return frame


# --- what differs -----------------------------------------------------------------------------------------------


def _first_difference(sent: Item, got: Item, firmware: Firmware) -> tuple[str, str, str] | None:
    stored = _stored(sent, firmware)
    if got.command not in (stored.command, sent.command):
        return "command", command_name(sent.command), command_name(got.command)
    if plain_frame(got.frame) not in (stored.frame, plain_frame(sent.frame)):
        return "frame", str(sent.frame), str(got.frame)
    letters = firmware.kept(sent.command, sent.frame) or UNKNOWN
    for name, letter, was, kept, now in zip(PARAM_NAMES, letters, *map(values_of, (sent, stored, got)), strict=True):
        if not (_agree(letter, kept, now) or _agree(letter, was, now)):
            return name, f"{was:.10g}", f"{now:.10g}"
    is_flown = sent.command not in firmware.fence and sent.command not in firmware.rally
    if is_flown and firmware.keeps_autocontinue and sent.autocontinue != got.autocontinue:
        return "autocontinue", str(sent.autocontinue), str(got.autocontinue)
    return None


UNKNOWN = "....dd."  # of a command that is in no table: nothing is known to change


def values_of(item: Item) -> tuple[float, ...]:
    """param1 to param7."""
    return (*item.params, item.latitude_deg, item.longitude_deg, item.altitude)


def _agree(letter: str, one: float, other: float) -> bool:
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) and math.isnan(other)
    match letter:
        case "d":
            return _deg_e7(one) == _deg_e7(other)
        case "c":
            return abs(one - other) <= ALTITUDE_SLACK
        case "y":
            return abs((one - other + 180.0) % 360.0 - 180.0) <= YAW_SLACK
        case _:
            return _single(one) == _single(other)
