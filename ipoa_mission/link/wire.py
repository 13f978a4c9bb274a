"""How each message lies in MAVLink fields: names, units, scaling. No bytes and no pymavlink here.

degE7 is made here and nowhere else, with `round` (truncation moves six coordinates in a hundred by one unit).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

from ipoa_mission.commands import SAME_FRAME, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.items import Item
from ipoa_mission.link import messages as m

M = TypeVar("M", bound=m.Message)
Fields = Mapping[str, Any]

INT32_MAX = 2**31 - 1  # "no value" in an integer coordinate
GLOBAL_FRAMES = frozenset({*SAME_FRAME, *SAME_FRAME.values()})
LOCAL_SCALE = 10_000  # metres in local frames
_SAME_NAMES: Fields = {}
_TYPED: Fields = {"kind": "mission_type"}


@dataclass(frozen=True)
class Layout(Generic[M]):
    """One message on the wire: its MAVLink name, and the two ways between `M` and MAVLink's fields."""

    name: str
    kind: type[M]
    write: Callable[[M], Fields]
    read: Callable[[Any], M]


def write(message: m.Message) -> tuple[str, Fields]:
    """MAVLink's name and fields of a message, without target, which only the sender knows.

    Raises:
        BadInput: a coordinate does not fit the 32 bits that MAVLink has for it.
    """
    layout = _BY_KIND[type(message)]
    if isinstance(message, m.Request) and message.legacy:
        layout = _BY_NAME["MISSION_REQUEST"]
    return layout.name, layout.write(message)


def read(name: str, raw: Any) -> m.Message:
    """The message behind MAVLink's fields (any object that has them as attributes)."""
    message: m.Message = _BY_NAME[name].read(raw)
    return message


def coordinate(degrees: float, frame: int) -> int:
    """Param5 or param6 as MISSION_ITEM_INT has it: degE7 in global frames, as it is in frame 2, else metres x 1e4."""
    if math.isnan(degrees):
        return INT32_MAX if frame in GLOBAL_FRAMES else 0
    value = round(degrees * _scale(frame)) if math.isfinite(degrees) else INT32_MAX + 1
    if not -INT32_MAX <= value < INT32_MAX:
        raise BadInput(f"coordinate: expected one that fits MAVLink's 32 bits, not {degrees}")
    return value


def degrees(value: int, frame: int) -> float:
    """The inverse of `coordinate`."""
    return math.nan if value == INT32_MAX and frame in GLOBAL_FRAMES else value / _scale(frame)


def _scale(frame: int) -> int:
    if frame in GLOBAL_FRAMES:
        return 10_000_000
    return 1 if frame == Frame.MISSION else LOCAL_SCALE


def _plain(name: str, kind: type[M], renamed: Fields = _SAME_NAMES) -> Layout[M]:
    """A message whose fields MAVLink holds as they are, some under another name."""
    names = {field.name: renamed.get(field.name, field.name) for field in fields(kind)}
    return Layout(
        name,
        kind,
        lambda message: {theirs: getattr(message, ours) for ours, theirs in names.items()},
        lambda raw: kind(**{ours: getattr(raw, theirs) for ours, theirs in names.items()}),
    )


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


def _read_item(raw: Any) -> m.ItemAt:
    item = Item(
        raw.command,
        raw.frame,
        (raw.param1, raw.param2, raw.param3, raw.param4),
        degrees(raw.x, raw.frame),
        degrees(raw.y, raw.frame),
        raw.z,
        bool(raw.autocontinue),
    )
    return m.ItemAt(raw.seq, item, raw.mission_type, raw.current)


def _read_old_item(raw: Any) -> m.ItemAt:
    """MISSION_ITEM, whose degrees are single precision (up to 0.85 m off): understood, never sent."""
    params = (raw.param1, raw.param2, raw.param3, raw.param4)
    item = Item(raw.command, raw.frame, params, raw.x, raw.y, raw.z, bool(raw.autocontinue))
    return m.ItemAt(raw.seq, item, raw.mission_type, raw.current)


def _params(raw: Any, count: int) -> tuple[Any, ...]:
    return tuple(getattr(raw, f"param{i}") for i in range(1, count + 1))


def _numbered(params: tuple[float, ...]) -> dict[str, float]:
    return {f"param{i}": value for i, value in enumerate(params, start=1)}


def _e7(latitude_deg: float, longitude_deg: float) -> tuple[int, int]:
    return saturated(latitude_deg * 1e7), saturated(longitude_deg * 1e7)


def _millis(seconds: float) -> int:
    return round(seconds * 1000) & 0xFFFFFFFF


def saturated(value: float, bits: int = 32) -> int:
    """Telemetry never fails: what does not fit a signed integer is told as its end, NaN as 0."""
    most = 2 ** (bits - 1) - 1
    return 0 if math.isnan(value) else round(min(max(value, -most), most))


def _write_position(p: m.Position) -> Fields:
    lat, lon = _e7(p.latitude_deg, p.longitude_deg)
    vx, vy, vz = (saturated(v * 100, 16) for v in p.velocity)
    return {
        "time_boot_ms": _millis(p.time_s),
        "lat": lat,
        "lon": lon,
        "alt": saturated(p.altitude * 1000),
        "relative_alt": saturated(p.height * 1000),
        "vx": vx,
        "vy": vy,
        "vz": vz,
        "hdg": saturated(math.degrees(p.yaw) * 100) % 36000,
    }


def _read_position(raw: Any) -> m.Position:
    return m.Position(
        raw.time_boot_ms / 1000,
        raw.lat / 1e7,
        raw.lon / 1e7,
        raw.alt / 1000,
        raw.relative_alt / 1000,
        (raw.vx / 100, raw.vy / 100, raw.vz / 100),
        math.radians(raw.hdg / 100),
    )


def _write_home(h: m.HomePosition) -> Fields:
    lat, lon = _e7(h.latitude_deg, h.longitude_deg)
    zeros = dict.fromkeys(("x", "y", "z", "approach_x", "approach_y", "approach_z"), 0.0)
    return {
        "latitude": lat,
        "longitude": lon,
        "altitude": saturated(h.altitude * 1000),
        **zeros,
        "q": [1.0, 0.0, 0.0, 0.0],
    }


def _write_origin(o: m.GlobalOrigin) -> Fields:
    lat, lon = _e7(o.latitude_deg, o.longitude_deg)
    return {"latitude": lat, "longitude": lon, "altitude": saturated(o.altitude * 1000)}


def _write_gps(g: m.Gps) -> Fields:
    lat, lon = _e7(g.latitude_deg, g.longitude_deg)
    return {
        "time_usec": round(g.time_s * 1e6),
        "fix_type": g.fix_type,
        "lat": lat,
        "lon": lon,
        "alt": saturated(g.altitude * 1000),
        "eph": 80,
        "epv": 120,
        "vel": saturated(g.speed * 100, 16),
        "cog": 0xFFFF,
        "satellites_visible": g.satellites_visible,
    }


def _write_status(s: m.SystemStatus) -> Fields:
    return {
        "onboard_control_sensors_present": s.present,
        "onboard_control_sensors_enabled": s.enabled,
        "onboard_control_sensors_health": s.health,
        "load": 200,
        "voltage_battery": round(s.voltage * 1000),
        "current_battery": -1,
        "battery_remaining": s.battery_remaining,
        **dict.fromkeys(
            ("drop_rate_comm", "errors_comm", "errors_count1", "errors_count2", "errors_count3", "errors_count4"), 0
        ),
    }


def _clean(text: str | bytes) -> str:
    raw = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
    return raw.split(b"\0")[0].decode("utf-8", "replace")


def _write_transfer(message: m.FileTransfer) -> Fields:
    return {"target_network": 0, "payload": message.payload.ljust(251, b"\0")}


_LAYOUTS: tuple[Layout[Any], ...] = (
    _plain("MISSION_COUNT", m.Count, _TYPED),
    Layout(
        "MISSION_REQUEST",
        m.Request,
        lambda r: {"seq": r.seq, "mission_type": r.kind},
        lambda raw: m.Request(raw.seq, raw.mission_type, legacy=True),
    ),
    Layout(
        "MISSION_REQUEST_INT",
        m.Request,
        lambda r: {"seq": r.seq, "mission_type": r.kind},
        lambda raw: m.Request(raw.seq, raw.mission_type),
    ),
    Layout("MISSION_ITEM", m.ItemAt, _write_item, _read_old_item),
    Layout("MISSION_ITEM_INT", m.ItemAt, _write_item, _read_item),
    _plain("MISSION_ACK", m.Ack, {"result": "type", "kind": "mission_type"}),
    _plain("MISSION_REQUEST_LIST", m.RequestList, _TYPED),
    _plain("MISSION_CLEAR_ALL", m.ClearAll, _TYPED),
    _plain("MISSION_SET_CURRENT", m.SetCurrent),
    _plain("MISSION_CURRENT", m.Current),
    _plain("MISSION_ITEM_REACHED", m.Reached),
    _plain("MISSION_WRITE_PARTIAL_LIST", m.WritePartialList, _TYPED),
    Layout(
        "HEARTBEAT",
        m.Heartbeat,
        lambda h: {
            "type": h.type,
            "autopilot": h.autopilot,
            "base_mode": h.base_mode,
            "custom_mode": h.custom_mode,
            "system_status": h.system_status,
            "mavlink_version": 3,
        },
        lambda raw: m.Heartbeat(raw.type, raw.autopilot, raw.base_mode, raw.custom_mode, raw.system_status),
    ),
    Layout(
        "STATUSTEXT",
        m.Text,
        lambda t: {"severity": t.severity, "text": t.text.encode()[:50], "id": t.id, "chunk_seq": t.chunk_seq},
        lambda raw: m.Text(raw.severity, _clean(raw.text), raw.id, raw.chunk_seq),
    ),
    Layout(
        "EVENT",
        m.Event,
        lambda e: {"id": e.number, "log_levels": e.log_levels, "arguments": e.arguments.ljust(40, b"\0")[:40]},
        lambda raw: m.Event(raw.id, raw.log_levels, bytes(raw.arguments).rstrip(b"\0")),
    ),
    _plain("PING", m.Ping),
    _plain("TIMESYNC", m.TimeSync),
    Layout(
        "COMMAND_LONG",
        m.CommandLong,
        lambda c: {"command": c.command, "confirmation": c.confirmation, **_numbered(c.params)},
        lambda raw: m.CommandLong(raw.command, _params(raw, 7), raw.confirmation),
    ),
    Layout(
        "COMMAND_INT",
        m.CommandInt,
        lambda c: {
            "command": c.command,
            "frame": c.frame,
            "current": 0,
            "autocontinue": 0,
            **_numbered(c.params),
            "x": c.x,
            "y": c.y,
            "z": c.z,
        },
        lambda raw: m.CommandInt(raw.command, raw.frame, _params(raw, 4), raw.x, raw.y, raw.z),
    ),
    _plain("COMMAND_ACK", m.CommandAck),
    _plain("SET_MODE", m.SetMode),
    _plain("PARAM_REQUEST_LIST", m.ParamRequestList),
    Layout(
        "PARAM_REQUEST_READ",
        m.ParamRequestRead,
        lambda p: {"param_id": p.param_id.encode(), "param_index": p.param_index},
        lambda raw: m.ParamRequestRead(_clean(raw.param_id), raw.param_index),
    ),
    Layout(
        "PARAM_SET",
        m.ParamSet,
        lambda p: {"param_id": p.param_id.encode(), "param_value": p.param_value, "param_type": p.param_type},
        lambda raw: m.ParamSet(_clean(raw.param_id), raw.param_value, raw.param_type),
    ),
    Layout(
        "PARAM_VALUE",
        m.ParamValue,
        lambda p: {
            "param_id": p.param_id.encode(),
            "param_value": p.param_value,
            "param_type": p.param_type,
            "param_count": p.param_count,
            "param_index": p.param_index,
        },
        lambda raw: m.ParamValue(
            _clean(raw.param_id), raw.param_value, raw.param_type, raw.param_count, raw.param_index
        ),
    ),
    _plain("REQUEST_DATA_STREAM", m.RequestDataStream),
    _plain("MESSAGE_INTERVAL", m.MessageInterval),
    Layout("FILE_TRANSFER_PROTOCOL", m.FileTransfer, _write_transfer, lambda raw: m.FileTransfer(bytes(raw.payload))),
    Layout(
        "AUTOPILOT_VERSION",
        m.AutopilotVersion,
        lambda a: {"capabilities": a.capabilities, "flight_sw_version": a.flight_sw_version, "uid": a.uid},
        lambda raw: m.AutopilotVersion(raw.capabilities, raw.flight_sw_version, raw.uid),
    ),
    Layout(
        "HOME_POSITION",
        m.HomePosition,
        _write_home,
        lambda raw: m.HomePosition(raw.latitude / 1e7, raw.longitude / 1e7, raw.altitude / 1000),
    ),
    Layout(
        "GPS_GLOBAL_ORIGIN",
        m.GlobalOrigin,
        _write_origin,
        lambda raw: m.GlobalOrigin(raw.latitude / 1e7, raw.longitude / 1e7, raw.altitude / 1000),
    ),
    Layout("GLOBAL_POSITION_INT", m.Position, _write_position, _read_position),
    Layout(
        "LOCAL_POSITION_NED",
        m.LocalPosition,
        lambda p: {
            "time_boot_ms": _millis(p.time_s),
            **dict(zip(("x", "y", "z", "vx", "vy", "vz"), (*p.position, *p.velocity), strict=True)),
        },
        lambda raw: m.LocalPosition(raw.time_boot_ms / 1000, (raw.x, raw.y, raw.z), (raw.vx, raw.vy, raw.vz)),
    ),
    Layout(
        "GPS_RAW_INT",
        m.Gps,
        _write_gps,
        lambda raw: m.Gps(
            raw.time_usec / 1e6,
            raw.lat / 1e7,
            raw.lon / 1e7,
            raw.alt / 1000,
            raw.vel / 100,
            raw.fix_type,
            raw.satellites_visible,
        ),
    ),
    Layout(
        "ATTITUDE",
        m.Attitude,
        lambda a: {"time_boot_ms": _millis(a.time_s), "roll": a.roll, "pitch": a.pitch, "yaw": a.yaw},
        lambda raw: m.Attitude(raw.time_boot_ms / 1000, raw.roll, raw.pitch, raw.yaw),
    ),
    _plain("VFR_HUD", m.Hud),
    Layout(
        "SYS_STATUS",
        m.SystemStatus,
        _write_status,
        lambda raw: m.SystemStatus(
            raw.onboard_control_sensors_present,
            raw.onboard_control_sensors_enabled,
            raw.onboard_control_sensors_health,
            raw.voltage_battery / 1000,
            raw.battery_remaining,
        ),
    ),
    _plain("EXTENDED_SYS_STATE", m.ExtendedState),
    Layout(
        "SYSTEM_TIME",
        m.SystemTime,
        lambda t: {"time_unix_usec": round(t.unix_s * 1e6), "time_boot_ms": _millis(t.boot_s)},
        lambda raw: m.SystemTime(raw.time_unix_usec / 1e6, raw.time_boot_ms / 1000),
    ),
    _plain("RADIO_STATUS", m.RadioStatus),
)

_BY_NAME = {layout.name: layout for layout in _LAYOUTS}
_BY_KIND = {layout.kind: layout for layout in _LAYOUTS}
#: The MAVLink messages that the package understands; it passes by all others.
NAMES = frozenset(_BY_NAME)
