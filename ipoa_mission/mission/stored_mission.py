"""Missions, fences and rally points as items on the wire (tables: `autopilot.firmware_tables`).

Only this module adds and removes ArduPilot's home: without it, ArduPilot loses the take-off.
"""

import ctypes
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame, command_name, plain_frame
from ipoa_mission.autopilot.firmware_tables import PARAM_NAMES, Firmware
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item, Mission

#: Command: stay inside.
POLYGON = {Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION: True, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False}
CIRCLE = {Command.NAV_FENCE_CIRCLE_INCLUSION: True, Command.NAV_FENCE_CIRCLE_EXCLUSION: False}


def to_wire(mission: Mission) -> tuple[Item, ...]:
    """Return items as sent: in frame 2 without a position for PX4, 0 for a NaN that ArduPilot refuses."""
    firmware = mission.firmware
    items = tuple(_sent(item, firmware) for item in mission.items)
    return (home_item(mission.home), *items) if firmware.home_is_item_0 else items


def from_wire(items: Sequence[Item], autopilot: Autopilot, home: Geodetic | None = None) -> Mission:
    """Return the mission with the reported `home`, or ArduPilot's item 0; raise MissionError for PX4 without one."""
    firmware = autopilot.firmware()
    if firmware.home_is_item_0:
        first = items[:1]
        items = items[1:]
        if home is None and first:
            home = Geodetic(first[0].latitude_deg, first[0].longitude_deg, first[0].altitude)
    if home is None:
        words = f"{firmware.name} sent no home with its mission, and none is known"
        raise MissionError(words, hint="wait until the vehicle has a position fix", code="home-missing", place="home")
    return Mission(home, resolve_frames([_jumping(item, 1.0, firmware) for item in items], autopilot), autopilot)


def resolve_frames(items: Sequence[Item], autopilot: Autopilot) -> tuple[Item, ...]:
    """Return items in the frames of files: no `_INT`, and frame 2 without a position."""
    firmware = autopilot.firmware()
    return tuple(replace(item, frame=_plain_frame(item, firmware)) for item in items)


def home_item(home: Geodetic) -> Item:
    return Item(Command.NAV_WAYPOINT, Frame.GLOBAL, (0.0,) * 4, home.latitude_deg, home.longitude_deg, home.altitude)


def as_stored(items: Sequence[Item], autopilot: Autopilot, version: Version | None = None) -> tuple[Item, ...]:
    """Return sent items as stored: single precision, no `_INT`; ArduPilot's home as sent."""
    firmware = autopilot.firmware(version)
    return tuple(_stored(item, firmware) for item in items)


@dataclass(frozen=True)
class Difference:
    """`seq` counts from 1, home is 0; None if the counts differ."""

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
    """Return the first difference that the firmware of `version` (None: any) does not make, home aside."""
    versions = (version,) if version else [Version(*series) for series in reversed(autopilot.tables.series)]
    newest, *older = map(autopilot.firmware, versions)
    if len(sent) != len(got):
        return Difference(None, "number of items", str(len(sent)), str(len(got)))
    for seq, (item, stored) in enumerate(zip(sent, got, strict=True)):
        is_home = seq == 0 and newest.home_is_item_0 and _is_home(item) and item.command == stored.command
        if is_home or stored is item:
            continue
        difference = _first_difference(item, stored, newest)
        if difference and all(_first_difference(item, stored, firmware) for firmware in older):
            return Difference(seq + first_number(sent, autopilot), *difference)
    return None


def first_number(items: Sequence[Item], autopilot: Autopilot) -> int:
    """Return 0 for a list with ArduPilot's home, else 1."""
    return 0 if items and autopilot.seq_offset and _is_home(items[0]) else 1


def _sent(item: Item, firmware: Firmware) -> Item:
    item = _jumping(item, -1.0, firmware)
    if _is_plain(item, firmware):
        item = replace(item, frame=int(Frame.MISSION))
    if firmware.takes_nan is None:
        return item
    nan_params = firmware.takes_nan.get(item.command, frozenset())
    params = [0.0 if math.isnan(p) and n not in nan_params else p for n, p in enumerate(item.params, start=1)]
    return replace(item, params=(params[0], params[1], params[2], params[3]))


def _jumping(item: Item, farther: float, firmware: Firmware) -> Item:
    if item.command != Command.DO_JUMP or firmware.home_is_item_0:
        return item
    return replace(item, params=(item.params[0] + farther, *item.params[1:]))


def _is_plain(item: Item, firmware: Firmware) -> bool:
    return item.command in firmware.plain and item.command not in firmware.placed


def _plain_frame(item: Item, firmware: Firmware) -> int:
    return int(Frame.MISSION) if _is_plain(item, firmware) else plain_frame(item.frame)


def _is_home(item: Item) -> bool:
    return item.command == Command.NAV_WAYPOINT and plain_frame(item.frame) == Frame.GLOBAL


def _single(value: float) -> float:
    return ctypes.c_float(value).value  # a tenth of the time of np.float32 and errstate


def _half(value: float) -> float:
    with np.errstate(over="ignore"):
        return float(np.float16(value))


def _whole(value: float) -> float:
    return float(math.trunc(value)) if math.isfinite(value) else 0.0


def _centimeters(value: float) -> float:
    """As ArduPilot: times 100 in single precision, then to an integer."""
    scaled = _single(_single(value) * 100.0)
    return _single(_single(math.trunc(scaled)) / 100.0) if math.isfinite(scaled) else 0.0


def _deg_e7(degrees: float) -> float:
    return round(degrees * 1e7) if math.isfinite(degrees * 1e7) else degrees


def _turns(value: float) -> float:
    return _whole(256.0 * value) / 256.0 if 0.0 < value < 1.0 else min(_whole(value), 255.0)


def _radius(value: float) -> float:
    size = abs(_whole(value))
    return math.copysign(size if size <= 255 else 10.0 * min(size // 10, 255), value)


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
    if firmware.home_is_item_0 and (_plain_frame(item, firmware) == Frame.MISSION or item.command in firmware.fence):
        return int(Frame.GLOBAL)  # ArduPilot stores no frame 2, and no frame for a fence
    return plain_frame(item.frame)


def _first_difference(sent: Item, got: Item, firmware: Firmware) -> tuple[str, str, str] | None:
    stored = _stored(sent, firmware)
    if got.command not in (stored.command, sent.command):
        return "command", command_name(sent.command), command_name(got.command)
    if plain_frame(got.frame) not in (stored.frame, plain_frame(sent.frame)):
        return "frame", str(sent.frame), str(got.frame)
    letters = firmware.kept(sent.command, sent.frame) or "....dd."  # of an unknown command
    for name, letter, was, kept, now in zip(PARAM_NAMES, letters, *map(values_of, (sent, stored, got)), strict=True):
        if was != now and not (_agree(letter, kept, now) or _agree(letter, was, now)):
            return name, f"{was:.10g}", f"{now:.10g}"
    is_flown = sent.command not in firmware.fence and sent.command not in firmware.rally
    if is_flown and firmware.keeps_autocontinue and sent.autocontinue != got.autocontinue:
        return "autocontinue", str(sent.autocontinue), str(got.autocontinue)
    return None


def values_of(item: Item) -> tuple[float, ...]:
    return (*item.params, item.latitude_deg, item.longitude_deg, item.altitude)


def refuse_infinite(items: Sequence[Item]) -> None:
    for seq, item in enumerate(items, start=1):
        for name, value in zip(PARAM_NAMES, values_of(item), strict=True):
            if math.isinf(value):
                raise BadInput(f"expected a number or NaN, not {value}", place=f"item {seq} ({item.name}): {name}")


def _agree(letter: str, expected: float, actual: float) -> bool:
    if math.isnan(expected) or math.isnan(actual):
        return math.isnan(expected) and math.isnan(actual)
    match letter:
        case "d":
            return _deg_e7(expected) == _deg_e7(actual)
        case "c":  # ArduPilot truncates altitudes to the centimeter in single precision
            return abs(expected - actual) <= 0.0101  # [m]
        case "y":  # through radians in single precision
            return abs((expected - actual + 180.0) % 360.0 - 180.0) <= 1e-3  # [deg]
        case _:
            return _single(expected) == _single(actual)


def fence_to_wire(fence: Sequence[FencePolygon | FenceCircle]) -> tuple[Item, ...]:
    items = list[Item]()
    places: tuple[tuple[float, float], ...]
    for part in fence:
        if isinstance(part, FenceCircle):
            commands = CIRCLE
            size = part.radius
            places = (part.center,)
        else:
            commands = POLYGON
            size = float(len(part.vertices))
            places = part.vertices
        command = next(command for command, inside in commands.items() if inside == part.inclusion)
        items += [Item(command, Frame.GLOBAL, (size, 0.0, 0.0, 0.0), *place) for place in places]
    return tuple(items)


def fence_from_wire(items: Sequence[Item]) -> tuple[FencePolygon | FenceCircle, ...]:
    """Return the fence without ArduPilot's return point (5000)."""
    fence: list[FencePolygon | FenceCircle] = []
    at = 0
    while at < len(items):
        item = items[at]
        place = f"fence item {at + 1}"
        count = 1
        if item.command in POLYGON:
            count = int(item.params[0]) if math.isfinite(item.params[0]) else 0
            if count < 3:
                words = f"expected a polygon of 3 vertices or more, not {item.params[0]:g}"
                raise MissionError(words, code="fence-broken", place=place)
            ring = items[at : at + count]
            if len(ring) < count or any((v.command, v.params[0]) != (item.command, item.params[0]) for v in ring):
                words = f"expected a polygon of {count} vertices, but the list ends before"
                raise MissionError(words, code="fence-broken", place=place)
            vertices = tuple((v.latitude_deg, v.longitude_deg) for v in ring)
            fence.append(FencePolygon(vertices, POLYGON[Command(item.command)]))
        elif item.command in CIRCLE:
            center = (item.latitude_deg, item.longitude_deg)
            fence.append(FenceCircle(center, item.params[0], CIRCLE[Command(item.command)]))
        elif item.command != Command.NAV_FENCE_RETURN_POINT:
            raise MissionError(f"expected a fence, not {item.name}", code="not-a-mission-item", place=place)
        at += count
    return tuple(fence)


def rally_to_wire(rally: Sequence[Geodetic]) -> tuple[Item, ...]:
    kind = Command.NAV_RALLY_POINT, Frame.GLOBAL_RELATIVE_ALT, (0.0,) * 4
    return tuple(Item(*kind, place.latitude_deg, place.longitude_deg, place.altitude) for place in rally)


def rally_from_wire(items: Sequence[Item]) -> tuple[Geodetic, ...]:
    for at, item in enumerate(items, 1):
        if item.command != Command.NAV_RALLY_POINT:
            words = f"expected a rally point, not {item.name}"
            raise MissionError(words, code="not-a-mission-item", place=f"rally item {at}")
    return tuple(Geodetic(item.latitude_deg, item.longitude_deg, item.altitude) for item in items)
