"""Map messages to MAVLink's fields: names, units, scaling.

Only this module makes degE7, with `round`: truncation would move 6 % of the coordinates by one unit.
"""

import math
from typing import Any

from ipoa_mission.autopilot.commands import PLAIN_FRAME, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.link import messages as m
from ipoa_mission.link import telemetry_wire
from ipoa_mission.link.message_layout import Fields, MessageLayout, Value, plain
from ipoa_mission.mission.items import Item

INT32_MAX = 2**31 - 1  # "no value"
GLOBAL_FRAMES = frozenset({*PLAIN_FRAME, *PLAIN_FRAME.values()})
LOCAL_SCALE = 10_000  # local frames


def write(message: m.Message) -> tuple[str, Fields]:
    """Leave the target out; raise BadInput if a coordinate does not fit."""
    layout = _BY_KIND[type(message)]
    if isinstance(message, m.Request) and message.legacy:
        layout = _BY_NAME["MISSION_REQUEST"]
    return layout.name, layout.write(message)


def read(name: str, raw: Any) -> m.Message:
    message: m.Message = _BY_NAME[name].read(raw)
    return message


def coordinate(degrees: float, frame: int) -> int:
    """Return degE7 in global frames, unscaled in frame 2, else meters x 1e4."""
    if math.isnan(degrees):
        return INT32_MAX if frame in GLOBAL_FRAMES else 0
    scaled = degrees * _scale(frame)
    value = round(scaled) if math.isfinite(scaled) else INT32_MAX + 1
    if not -INT32_MAX <= value < INT32_MAX:
        raise BadInput(f"expected one that fits MAVLink's 32 bits, not {degrees}", place="coordinate")
    return value


def degrees(value: int, frame: int) -> float:
    return math.nan if value == INT32_MAX and frame in GLOBAL_FRAMES else value / _scale(frame)


def _scale(frame: int) -> int:
    if frame in GLOBAL_FRAMES:
        return 10_000_000
    return 1 if frame == Frame.MISSION else LOCAL_SCALE


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


def read_item(raw: Any) -> Item:
    return _item(raw, degrees(raw.x, raw.frame), degrees(raw.y, raw.frame))


def _item(raw: Any, latitude: float, longitude: float) -> Item:
    params = (raw.param1, raw.param2, raw.param3, raw.param4)
    return Item(raw.command, raw.frame, params, latitude, longitude, raw.z, bool(raw.autocontinue))


def _read_item(raw: Any) -> m.ItemAt:
    return m.ItemAt(raw.seq, read_item(raw), raw.mission_type, raw.current)


def _read_old_item(raw: Any) -> m.ItemAt:
    """Degrees in single precision: up to 0.85 m off; never sent."""
    return m.ItemAt(raw.seq, _item(raw, raw.x, raw.y), raw.mission_type, raw.current)


def _write_request(message: m.Request) -> Fields:
    return {"seq": message.seq, "mission_type": message.kind}


def _numbered(count: int) -> Value:
    return Value(tuple(f"param{n}" for n in range(1, count + 1)))


def _clean(text: str | bytes) -> str:
    raw = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
    return raw.split(b"\0")[0].decode("utf-8", "replace")


_ID = Value(("param_id",), lambda name: name.encode(), _clean)
_TYPED = {"kind": "mission_type"}
_LAYOUTS: tuple[MessageLayout[Any], ...] = (
    plain("MISSION_COUNT", m.Count, **_TYPED),
    MessageLayout(
        "MISSION_REQUEST", m.Request, _write_request, lambda raw: m.Request(raw.seq, raw.mission_type, legacy=True)
    ),
    MessageLayout("MISSION_REQUEST_INT", m.Request, _write_request, lambda raw: m.Request(raw.seq, raw.mission_type)),
    MessageLayout("MISSION_ITEM", m.ItemAt, _write_item, _read_old_item),
    MessageLayout("MISSION_ITEM_INT", m.ItemAt, _write_item, _read_item),
    plain("MISSION_ACK", m.Ack, result="type", **_TYPED),
    plain("MISSION_REQUEST_LIST", m.RequestList, **_TYPED),
    plain("MISSION_CLEAR_ALL", m.ClearAll, **_TYPED),
    plain("MISSION_SET_CURRENT", m.SetCurrent),
    plain("MISSION_CURRENT", m.Current),
    plain("MISSION_ITEM_REACHED", m.Reached),
    plain("MISSION_WRITE_PARTIAL_LIST", m.WritePartialList, **_TYPED),
    plain("HEARTBEAT", m.Heartbeat, {"mavlink_version": 3}),
    plain("STATUSTEXT", m.Text, text=Value(("text",), lambda text: text.encode()[:50], _clean)),
    plain(
        "EVENT",
        m.Event,
        number="id",
        arguments=Value(
            ("arguments",), lambda given: given.ljust(40, b"\0")[:40], lambda raw: bytes(raw).rstrip(b"\0")
        ),
    ),
    plain("PING", m.Ping),
    plain("TIMESYNC", m.TimeSync),
    plain("COMMAND_LONG", m.CommandLong, params=_numbered(7)),
    plain("COMMAND_INT", m.CommandInt, {"current": 0, "autocontinue": 0}, params=_numbered(4)),
    plain("COMMAND_ACK", m.CommandAck),
    plain("SET_MODE", m.SetMode),
    plain("PARAM_REQUEST_LIST", m.ParamRequestList),
    plain("PARAM_REQUEST_READ", m.ParamRequestRead, param_id=_ID),
    plain("PARAM_SET", m.ParamSet, param_id=_ID),
    plain("PARAM_VALUE", m.ParamValue, param_id=_ID),
    plain("MESSAGE_INTERVAL", m.MessageInterval),
    plain("REQUEST_DATA_STREAM", m.RequestDataStream),
    plain(
        "FILE_TRANSFER_PROTOCOL",
        m.FileTransfer,
        {"target_network": 0},
        payload=Value(("payload",), lambda payload: payload.ljust(251, b"\0"), bytes),
    ),
)

_BY_NAME = {layout.name: layout for layout in (*_LAYOUTS, *telemetry_wire.LAYOUTS)}
_BY_KIND = {layout.kind: layout for layout in _BY_NAME.values()}
NAMES = frozenset(_BY_NAME)
