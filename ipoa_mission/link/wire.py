"""Convert messages to MAVLink's fields and back: names, units, scaling.

Only this module makes degE7, with `round`: truncation would move 6 % of the coordinates by one unit.
"""

import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any, TypeAlias

from ipoa_mission.autopilot.commands import PLAIN_FRAME, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.link import messages as m
from ipoa_mission.link.definitions import definition_of, unit_and_type
from ipoa_mission.mission.items import Item

Fields: TypeAlias = Mapping[str, Any]
ITEM = definition_of("MISSION_ITEM_INT")
INT32_MAX = 2**31 - 1  # "no value"
SINGLE_MAX = (2.0 - 2.0**-23) * 2.0**127
GLOBAL_FRAMES = frozenset({*PLAIN_FRAME, *PLAIN_FRAME.values()})
#: SI units to those of MAVLink's integers.
_FACTORS = {"degE7": 1e7, "mm": 1e3, "cm/s": 1e2, "ms": 1e3, "us": 1e6, "mV": 1e3, "cA": 1e2}
_LARGEST = {f"{sign}int{bits}_t": 2 ** (bits - (not sign)) - 1 for bits in (16, 32, 64) for sign in ("", "u")}
#: Fields without a class's own: not measured, or a charged lithium polymer battery of the whole vehicle.
_CONSTANTS: Mapping[str, Fields] = {
    "HEARTBEAT": {"mavlink_version": 3},
    "HOME_POSITION": {"q": [1.0, 0.0, 0.0, 0.0]},
    "GPS_RAW_INT": {"eph": 80, "epv": 120, "cog": 0xFFFF},
    "SYS_STATUS": {"load": 200},
    "BATTERY_STATUS": {"current_consumed": -1, "energy_consumed": -1, "temperature": 0x7FFF}
    | {"battery_function": 1, "type": 1, "charge_state": 1},
}


@dataclass(frozen=True)
class _Value:
    ours: str
    theirs: tuple[str, ...]
    write: Callable[[Any], Any] = lambda value: value
    read: Callable[[Any], Any] = lambda raw: raw


def write(message: m.Message) -> tuple[str, Fields]:
    """Leave the target out; raise BadInput if a coordinate does not fit."""
    match message:
        case m.ItemAt(seq, item, kind):
            fields_of_item = vars(ITEM.unpack(item_payload(seq, item, kind)))
            return message.NAME, {k: value for k, value in fields_of_item.items() if not k.startswith("target_")}
        case m.Request(seq, kind, legacy):
            return "MISSION_REQUEST" if legacy else message.NAME, {"seq": seq, "mission_type": kind}
    written = dict(_CONSTANTS.get(message.NAME, {}))
    for value in _LAYOUTS[message.NAME]:
        raw = value.write(getattr(message, value.ours))
        written.update(zip(value.theirs, raw if len(value.theirs) > 1 else (raw,), strict=True))
    return message.NAME, written


def is_read(name: str) -> bool:
    return name in _LAYOUTS or name in ("MISSION_ITEM", "MISSION_REQUEST")


def read(name: str, raw: Any) -> m.Message:
    match name:
        case "MISSION_REQUEST" | "MISSION_REQUEST_INT":
            return m.Request(raw.seq, raw.mission_type, name == "MISSION_REQUEST")
        case "MISSION_ITEM":  # single precision: up to 0.85 m off
            return m.ItemAt(raw.seq, _item(raw, raw.x, raw.y), raw.mission_type)
        case "MISSION_ITEM_INT":
            return m.ItemAt(raw.seq, read_item(raw), raw.mission_type)
    return KINDS[name](*[value.read(attrgetter(*value.theirs)(raw)) for value in _LAYOUTS[name]])


def coordinate(degrees: float, frame: int) -> int:
    """Return degE7 in global frames, unscaled in frame 2, else meters x 1e4."""
    if math.isnan(degrees):
        return INT32_MAX if frame in GLOBAL_FRAMES else 0
    scaled = degrees * scale(frame)
    value = round(scaled) if math.isfinite(scaled) else INT32_MAX + 1
    if not -INT32_MAX <= value < INT32_MAX:
        raise BadInput(f"expected one that fits MAVLink's 32 bits, not {degrees}", place="coordinate")
    return value


def item_payload(seq: int, item: Item, kind: int, target: tuple[int, int] = (0, 0)) -> bytes:
    """Return MISSION_ITEM_INT with all zeros; raise BadInput if a number does not fit its field."""
    place = coordinate(item.latitude_deg, item.frame), coordinate(item.longitude_deg, item.frame)
    whole = seq, item.command, *target, item.frame, 0, item.autocontinue, kind
    try:
        return ITEM.layout.pack(*item.params, *place, item.altitude, *whole)
    except (struct.error, OverflowError):
        raise _misfit(item) from None


def _misfit(item: Item) -> BadInput:
    for name, number, most in (("command", item.command, 0xFFFF), ("frame", item.frame, 0xFF)):
        if not isinstance(number, int) or not 0 <= number <= most:
            return BadInput(f"expected a whole number from 0 to {most}, not {number}", place=name)
    singles = {f"param{n}": value for n, value in enumerate(item.params, start=1)} | {"altitude": item.altitude}
    name, value = next((name, value) for name, value in singles.items() if SINGLE_MAX < abs(value) < math.inf)
    return BadInput(f"expected a number that fits in single precision, not {value:g}", place=name)


def degrees(value: int, frame: int) -> float:
    return math.nan if value == INT32_MAX and frame in GLOBAL_FRAMES else value / scale(frame)


def scale(frame: int) -> int:
    if frame in GLOBAL_FRAMES:
        return 10_000_000
    return 1 if frame == Frame.MISSION else 10_000


def saturated(value: float, most: int = INT32_MAX) -> int:
    """Return 0 for NaN: telemetry must not fail."""
    return 0 if math.isnan(value) else round(min(max(value, -most), most))


def item_of(payload: bytes) -> Item:
    return read_item(ITEM.unpack(payload))


def read_item(raw: Any) -> Item:
    return _item(raw, degrees(raw.x, raw.frame), degrees(raw.y, raw.frame))


def _item(raw: Any, latitude: float, longitude: float) -> Item:
    params = (raw.param1, raw.param2, raw.param3, raw.param4)
    return Item(raw.command, raw.frame, params, latitude, longitude, raw.z, bool(raw.autocontinue))


def _clean(text: str | bytes, errors: str = "replace") -> str:
    raw = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
    return raw.split(b"\0")[0].decode("utf-8", errors)


#: By MAVLink's name of a field: to it and back.
_CONVERSIONS: Mapping[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "text": (lambda text: text.encode()[:50], lambda raw: _clean(raw, "surrogateescape")),  # a chunk may cut a letter
    "param_id": (lambda name: name.encode(), _clean),
    "payload": (lambda payload: payload.ljust(251, b"\0"), bytes),
    "arguments": (lambda packed: packed.ljust(40, b"\0")[:40], lambda raw: bytes(raw).rstrip(b"\0")),
    "hdg": (lambda yaw: saturated(math.degrees(yaw) * 100) % 36000, lambda raw: math.radians(raw / 100)),
    # cells, or the total in the first cells; 0xFFFF: no cell
    "voltages": (
        lambda voltage: ([round(voltage * 1000), *[0xFFFF] * 9], [0] * 4),
        lambda raw: sum(cell for cell in (*raw[0], *raw[1]) if cell != 0xFFFF) / 1000,
    ),
}


def _layout(kind: type[m.Message]) -> list[_Value]:
    return [_value(kind.NAME, field.name, getattr(field.type, "__metadata__", ())) for field in fields(kind)]


def _value(message: str, ours: str, theirs: tuple[str, ...]) -> _Value:
    if not theirs:
        return _Value(ours, (ours,))
    if theirs[0] in _CONVERSIONS:
        return _Value(ours, theirs, *_CONVERSIONS[theirs[0]])
    unit, wire_type = unit_and_type(message, theirs[0])
    if unit not in _FACTORS:
        return _Value(ours, theirs)
    factor = _FACTORS[unit]
    most = _LARGEST[wire_type]

    def scale_up(value: Any) -> Any:
        return tuple(map(scale_up, value)) if isinstance(value, tuple) else saturated(value * factor, most)

    def scale_down(raw: Any) -> Any:
        return tuple(map(scale_down, raw)) if isinstance(raw, tuple) else raw / factor

    return _Value(ours, theirs, scale_up, scale_down)


KINDS: Mapping[str, type[m.Message]] = {
    kind.NAME: kind
    for kind in vars(m).values()
    if isinstance(kind, type) and issubclass(kind, m.Message) and kind is not m.Message
}
_LAYOUTS = {name: _layout(kind) for name, kind in KINDS.items()}
