"""Convert messages to MAVLink's fields and back: names, units, scaling.

Only this module makes degE7, with `round`: truncation would move 6 % of the coordinates by one unit.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any, TypeAlias

from ipoa_mission.autopilot.commands import PLAIN_FRAME, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.link import messages as m
from ipoa_mission.link import telemetry as t
from ipoa_mission.mission.items import Item

Fields: TypeAlias = Mapping[str, Any]
INT32_MAX = 2**31 - 1  # "no value"
SINGLE_MAX = (2.0 - 2.0**-23) * 2.0**127
GLOBAL_FRAMES = frozenset({*PLAIN_FRAME, *PLAIN_FRAME.values()})


@dataclass(frozen=True)
class MessageLayout:
    name: str
    kind: type[m.Message]
    write: Callable[[Any], Fields]
    read: Callable[[Any], m.Message]


@dataclass(frozen=True)
class Value:
    """One field, or several as a tuple."""

    names: tuple[str, ...]
    write: Callable[[Any], Any] = lambda value: value
    read: Callable[[Any], Any] = lambda raw: raw


def write(message: m.Message) -> tuple[str, Fields]:
    """Leave the target out; raise BadInput if a coordinate does not fit."""
    layout = _BY_KIND[type(message)]
    if isinstance(message, m.Request) and message.legacy:
        layout = LAYOUTS["MISSION_REQUEST"]
    return layout.name, layout.write(message)


def read(name: str, raw: Any) -> m.Message:
    return LAYOUTS[name].read(raw)


def coordinate(degrees: float, frame: int) -> int:
    """Return degE7 in global frames, unscaled in frame 2, else meters x 1e4."""
    if math.isnan(degrees):
        return INT32_MAX if frame in GLOBAL_FRAMES else 0
    scaled = degrees * scale(frame)
    value = round(scaled) if math.isfinite(scaled) else INT32_MAX + 1
    if not -INT32_MAX <= value < INT32_MAX:
        raise BadInput(f"expected one that fits MAVLink's 32 bits, not {degrees}", place="coordinate")
    return value


def expect_sendable(item: Item) -> None:
    """Raise BadInput if a number does not fit into its field of MISSION_ITEM_INT."""
    for name, number, most in (("command", item.command, 0xFFFF), ("frame", item.frame, 0xFF)):
        if not 0 <= number <= most:
            raise BadInput(f"expected a number from 0 to {most}, not {number}", place=name)
    coordinate(item.latitude_deg, item.frame)
    coordinate(item.longitude_deg, item.frame)
    singles = {f"param{n}": value for n, value in enumerate(item.params, start=1)} | {"altitude": item.altitude}
    for name, value in singles.items():
        if SINGLE_MAX < abs(value) < math.inf:
            raise BadInput(f"expected a number that fits in single precision, not {value:g}", place=name)


def degrees(value: int, frame: int) -> float:
    return math.nan if value == INT32_MAX and frame in GLOBAL_FRAMES else value / scale(frame)


def scale(frame: int) -> int:
    if frame in GLOBAL_FRAMES:
        return 10_000_000
    return 1 if frame == Frame.MISSION else 10_000


def saturated(value: float, bits: int = 32) -> int:
    """Return 0 for NaN: telemetry must not fail."""
    most = 2 ** (bits - 1) - 1
    return 0 if math.isnan(value) else round(min(max(value, -most), most))


def read_item(raw: Any) -> Item:
    return _item(raw, degrees(raw.x, raw.frame), degrees(raw.y, raw.frame))


def _item(raw: Any, latitude: float, longitude: float) -> Item:
    params = (raw.param1, raw.param2, raw.param3, raw.param4)
    return Item(raw.command, raw.frame, params, latitude, longitude, raw.z, bool(raw.autocontinue))


def _write_item(message: m.ItemAt) -> Fields:
    item = message.item
    return {
        "seq": message.seq,
        "frame": item.frame,
        "command": item.command,
        "current": message.current,
        "autocontinue": int(item.autocontinue),
        **{f"param{i}": value for i, value in enumerate(item.params, start=1)},
        "x": coordinate(item.latitude_deg, item.frame),
        "y": coordinate(item.longitude_deg, item.frame),
        "z": item.altitude,
        "mission_type": message.kind,
    }


def _items(name: str, read: Callable[[Any], Item]) -> MessageLayout:
    return MessageLayout(
        name, m.ItemAt, _write_item, lambda raw: m.ItemAt(raw.seq, read(raw), raw.mission_type, raw.current)
    )


def _requests(name: str, legacy: bool) -> MessageLayout:
    return MessageLayout(
        name,
        m.Request,
        lambda message: {"seq": message.seq, "mission_type": message.kind},
        lambda raw: m.Request(raw.seq, raw.mission_type, legacy),
    )


def _plain(name: str, kind: type[m.Message], also: Fields | None = None, /, **placed: str | Value) -> MessageLayout:
    """MAVLink's own values, except for those `placed` (name or `Value`); `also` are constants."""
    values: list[tuple[str, Value]] = []
    for field in fields(kind):
        place = placed.get(field.name, field.name)
        values.append((field.name, Value((place,)) if isinstance(place, str) else place))
    alone = [(ours, value.names[0], value.write) for ours, value in values if len(value.names) == 1]
    several = [(ours, value) for ours, value in values if len(value.names) != 1]
    readers = [(attrgetter(*value.names), value.read) for _, value in values]

    def write(message: m.Message) -> Fields:
        written = dict(also or {})
        for ours, theirs, to_wire in alone:
            written[theirs] = to_wire(getattr(message, ours))
        for ours, value in several:
            written.update(zip(value.names, value.write(getattr(message, ours)), strict=True))
        return written

    return MessageLayout(name, kind, write, lambda raw: kind(*[from_wire(get(raw)) for get, from_wire in readers]))


def _params(count: int) -> Value:
    return Value(tuple(f"param{n}" for n in range(1, count + 1)))


def _scaled(name: str, by: float, bits: int = 32) -> Value:
    return Value((name,), lambda value: saturated(value * by, bits), lambda raw: raw / by)


def _rounded(name: str, by: float) -> Value:
    return Value((name,), lambda value: round(value * by), lambda raw: raw / by)


def _place(latitude: str, longitude: str, altitude: str) -> dict[str, str | Value]:
    return {
        "latitude_deg": _scaled(latitude, 1e7),
        "longitude_deg": _scaled(longitude, 1e7),
        "altitude": _scaled(altitude, 1000),
    }


def _clean(text: str | bytes) -> str:
    raw = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
    return raw.split(b"\0")[0].decode("utf-8", "replace")


_TYPED = {"kind": "mission_type"}
_ID = Value(("param_id",), lambda name: name.encode(), _clean)
_BOOT = Value(("time_boot_ms",), lambda seconds: round(seconds * 1000) & 0xFFFFFFFF, lambda raw: raw / 1000)
#: Messages in use, by MAVLink's name; where two have one class, the second is sent.
LAYOUTS = {
    layout.name: layout
    for layout in (
        _plain("MISSION_COUNT", m.Count, **_TYPED),
        _requests("MISSION_REQUEST", legacy=True),
        _requests("MISSION_REQUEST_INT", legacy=False),
        _items("MISSION_ITEM", lambda raw: _item(raw, raw.x, raw.y)),  # single precision: up to 0.85 m off
        _items("MISSION_ITEM_INT", read_item),
        _plain("MISSION_ACK", m.Ack, result="type", **_TYPED),
        _plain("MISSION_REQUEST_LIST", m.RequestList, **_TYPED),
        _plain("MISSION_CLEAR_ALL", m.ClearAll, **_TYPED),
        _plain("MISSION_SET_CURRENT", m.SetCurrent),
        _plain("MISSION_CURRENT", m.Current),
        _plain("MISSION_ITEM_REACHED", m.Reached),
        _plain("MISSION_WRITE_PARTIAL_LIST", m.WritePartialList, **_TYPED),
        _plain("HEARTBEAT", m.Heartbeat, {"mavlink_version": 3}),
        _plain("STATUSTEXT", m.Text, text=Value(("text",), lambda text: text.encode()[:50], _clean)),
        _plain(
            "EVENT",
            m.Event,
            number="id",
            arguments=Value(
                ("arguments",), lambda packed: packed.ljust(40, b"\0")[:40], lambda raw: bytes(raw).rstrip(b"\0")
            ),
        ),
        _plain("PING", m.Ping),
        _plain("TIMESYNC", m.TimeSync),
        _plain("COMMAND_LONG", m.CommandLong, params=_params(7)),
        _plain("COMMAND_INT", m.CommandInt, {"current": 0, "autocontinue": 0}, params=_params(4)),
        _plain("COMMAND_ACK", m.CommandAck),
        _plain("SET_MODE", m.SetMode),
        _plain("PARAM_REQUEST_LIST", m.ParamRequestList),
        _plain("PARAM_REQUEST_READ", m.ParamRequestRead, param_id=_ID),
        _plain("PARAM_SET", m.ParamSet, param_id=_ID),
        _plain("PARAM_VALUE", m.ParamValue, param_id=_ID),
        _plain("MESSAGE_INTERVAL", m.MessageInterval),
        _plain("REQUEST_DATA_STREAM", m.RequestDataStream),
        _plain(
            "FILE_TRANSFER_PROTOCOL",
            m.FileTransfer,
            {"target_network": 0},
            payload=Value(("payload",), lambda payload: payload.ljust(251, b"\0"), bytes),
        ),
        _plain("AUTOPILOT_VERSION", t.AutopilotVersion),
        _plain("PROTOCOL_VERSION", t.ProtocolVersion),
        _plain(
            "HOME_POSITION", t.HomePosition, {"q": [1.0, 0.0, 0.0, 0.0]}, **_place("latitude", "longitude", "altitude")
        ),
        _plain("GPS_GLOBAL_ORIGIN", t.GlobalOrigin, **_place("latitude", "longitude", "altitude")),
        _plain(
            "GLOBAL_POSITION_INT",
            t.Position,
            time_s=_BOOT,
            **_place("lat", "lon", "alt"),
            height=_scaled("relative_alt", 1000),
            velocity=Value(
                ("vx", "vy", "vz"),
                lambda velocity: tuple(saturated(axis * 100, 16) for axis in velocity),
                lambda raw: tuple(axis / 100 for axis in raw),
            ),
            yaw=Value(
                ("hdg",), lambda yaw: saturated(math.degrees(yaw) * 100) % 36000, lambda raw: math.radians(raw / 100)
            ),
        ),
        _plain(
            "LOCAL_POSITION_NED",
            t.LocalPosition,
            time_s=_BOOT,
            position=Value(("x", "y", "z")),
            velocity=Value(("vx", "vy", "vz")),
        ),
        _plain(
            "GPS_RAW_INT",
            t.Gps,
            {"eph": 80, "epv": 120, "cog": 0xFFFF},
            time_s=_rounded("time_usec", 1e6),
            **_place("lat", "lon", "alt"),
            speed=_scaled("vel", 100, 16),
        ),
        _plain("ATTITUDE", t.Attitude, time_s=_BOOT),
        _plain("VFR_HUD", t.Hud),
        _plain(
            "SYS_STATUS",
            t.SystemStatus,
            {"load": 200},
            **{name: f"onboard_control_sensors_{name}" for name in ("present", "enabled", "health")},
            voltage=_rounded("voltage_battery", 1000),
            current=_rounded("current_battery", 100),
        ),
        _plain(
            "BATTERY_STATUS",
            t.BatteryStatus,
            # not measured; a charged lithium polymer battery of the whole vehicle
            {"current_consumed": -1, "energy_consumed": -1, "temperature": 0x7FFF}
            | {"battery_function": 1, "type": 1, "charge_state": 1},
            # cells, or the total in the first cells; 0xFFFF: no cell
            voltage=Value(
                ("voltages", "voltages_ext"),
                lambda voltage: ([round(voltage * 1000), *[0xFFFF] * 9], [0] * 4),
                lambda raw: sum(cell for cell in (*raw[0], *raw[1]) if cell != 0xFFFF) / 1000,
            ),
            current=_rounded("current_battery", 100),
        ),
        _plain("WIND", t.WindEstimate, direction_deg="direction"),
        _plain("WIND_COV", t.WindVelocity, velocity=Value(("wind_x", "wind_y", "wind_z"))),
        _plain("EXTENDED_SYS_STATE", t.ExtendedState),
        _plain("SYSTEM_TIME", t.SystemTime, unix_s=_rounded("time_unix_usec", 1e6), boot_s=_BOOT),
        _plain("RADIO_STATUS", t.RadioStatus),
    )
}
_BY_KIND = {layout.kind: layout for layout in LAYOUTS.values()}
