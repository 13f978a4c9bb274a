"""One frozen class a message, in SI units and degrees; unscaled fields keep MAVLink's name.

Received numbers stay integers: an unknown one is no error.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import dataclass_transform

from ipoa_mission.mission.items import Item

CRITICAL, WARNING, INFO = 2, 4, 6  # MAV_SEVERITY; lower is worse


class MissionType(IntEnum):
    MISSION = 0
    FENCE = 1
    RALLY = 2
    ALL = 255  # in CLEAR_ALL only


class Result(IntEnum):
    """MAV_MISSION_RESULT."""

    ACCEPTED = 0
    ERROR = 1
    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    NO_SPACE = 4
    INVALID = 5
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12
    INVALID_SEQUENCE = 13
    DENIED = 14
    OPERATION_CANCELLED = 15


class CommandResult(IntEnum):
    """MAV_RESULT."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5
    CANCELLED = 6


class MavAutopilot(IntEnum):
    GENERIC = 0
    ARDUPILOT = 3
    INVALID = 8  # a ground station, a gimbal
    PX4 = 12


#: MISSION_STATE.
NO_MISSION = 1
#: MAV_STATE_STANDBY; lower: still booting.
STANDBY = 3
#: MAV_MODE_FLAG_SAFETY_ARMED in HEARTBEAT.base_mode.
ARMED_FLAG = 128
CUSTOM_MODE_FLAG = 1
#: MAV_COMP_ID_AUTOPILOT1, and ours (MAV_COMP_ID_MISSIONPLANNER).
AUTOPILOT_COMPONENT = 1
STATION_SYSTEM, STATION_COMPONENT = 245, 190


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class Message:
    """Each subclass is a frozen dataclass."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True)(cls)


class Count(Message):
    count: int
    kind: int = MissionType.MISSION


class Request(Message):
    seq: int
    kind: int = MissionType.MISSION
    legacy: bool = False


class ItemAt(Message):
    """MISSION_ITEM_INT; `current` 2 and 3 are orders to a flying ArduPilot, never sent here."""

    seq: int
    item: Item
    kind: int = MissionType.MISSION
    current: int = 0


class Ack(Message):
    """MISSION_ACK with the `Result`; PX4 adds its id of the list (0: none)."""

    result: int
    kind: int = MissionType.MISSION
    opaque_id: int = 0


class RequestList(Message):
    kind: int = MissionType.MISSION


class ClearAll(Message):
    kind: int = MissionType.MISSION


class SetCurrent(Message):
    """MISSION_SET_CURRENT (superseded by command 224, which PX4 lacks)."""

    seq: int


class Current(Message):
    """MISSION_CURRENT; states: 0 unknown, 1 none, 2 not started, 3 active, 4 paused, 5 done.

    `total`: 0 unknown, 65535 no mission; `mission_id`: as in its `Ack`.
    """

    seq: int
    total: int = 0
    mission_state: int = 0
    mission_mode: int = 0
    mission_id: int = 0


class Reached(Message):
    seq: int


class WritePartialList(Message):
    start_index: int
    end_index: int
    kind: int = MissionType.MISSION


class Heartbeat(Message):
    type: int
    autopilot: int
    base_mode: int = 0
    custom_mode: int = 0
    system_status: int = STANDBY

    @property
    def armed(self) -> bool:
        return bool(self.base_mode & ARMED_FLAG)


class Text(Message):
    """STATUSTEXT; severity 0 (emergency) to 7 (debug); chunks of a long text share an `id`."""

    severity: int
    text: str
    id: int = 0
    chunk_seq: int = 0


class Event(Message):
    """EVENT of PX4; the ground station has its words."""

    number: int
    log_levels: int
    arguments: bytes = b""


class Ping(Message):
    """PING; a request is addressed to (0, 0)."""

    time_usec: int
    seq: int


class TimeSync(Message):
    """TIMESYNC [ns]: a question has `tc1` 0."""

    tc1: int
    ts1: int


class CommandLong(Message):
    command: int
    params: tuple[float, float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    confirmation: int = 0


class CommandInt(Message):
    """COMMAND_INT; x and y on the command's own scale."""

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float


class CommandAck(Message):
    command: int
    result: int
    progress: int = 0
    result_param2: int = 0


class SetMode(Message):
    base_mode: int
    custom_mode: int


class ParamRequestList(Message):
    """PARAM_REQUEST_LIST."""


class ParamRequestRead(Message):
    """PARAM_REQUEST_READ by name, or by index unless -1."""

    param_id: str
    param_index: int = -1


class ParamSet(Message):
    param_id: str
    param_value: float
    param_type: int = 9


class ParamValue(Message):
    """PARAM_VALUE; type 9 is a float."""

    param_id: str
    param_value: float
    param_type: int
    param_count: int
    param_index: int


class MessageInterval(Message):
    """MESSAGE_INTERVAL [us]; 0 unknown, -1 never."""

    message_id: int
    interval_us: int


class RequestDataStream(Message):
    """REQUEST_DATA_STREAM: MAV_DATA_STREAM (0: all) at a rate [Hz]."""

    req_stream_id: int
    req_message_rate: int
    start_stop: int = 1


class FileTransfer(Message):
    """251 bytes of MAVFTP."""

    payload: bytes


#: Messages that only the two ends of a transfer need.
TRANSFER = (Count, Request, ItemAt, Ack, RequestList, ClearAll, WritePartialList, FileTransfer)
