"""Messages of the link as data: one frozen class each, in SI units and degrees.

A field that MAVLink does not scale keeps MAVLink's own name. Received numbers stay plain integers, because an unknown
mission type is no error of the reader; the enumerations name the known ones.
"""

from dataclasses import dataclass
from enum import IntEnum

from ipoa_mission.mission.items import Item

CRITICAL, WARNING, INFO = 2, 4, 6  # MAV_SEVERITY; lower is worse


class MissionType(IntEnum):
    """MAV_MISSION_TYPE: the three lists of a vehicle."""

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
    """MAV_AUTOPILOT: the values used here."""

    GENERIC = 0
    ARDUPILOT = 3
    INVALID = 8  # not an autopilot: a ground station, a gimbal
    PX4 = 12


#: MISSION_STATE: there is no flyable mission.
NO_MISSION = 1
#: MAV_STATE_STANDBY: an autopilot below it is still booting.
STANDBY = 3
#: MAV_MODE_FLAG_SAFETY_ARMED in HEARTBEAT.base_mode.
ARMED_FLAG = 128
#: MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.
CUSTOM_MODE_FLAG = 1
#: MAV_COMP_ID_AUTOPILOT1, and our own ids as a ground station (MAV_COMP_ID_MISSIONPLANNER).
AUTOPILOT_COMPONENT = 1
STATION_SYSTEM, STATION_COMPONENT = 245, 190


@dataclass(frozen=True)
class Message:
    pass


# --- the mission service -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Count(Message):
    """MISSION_COUNT: the number of items that follow."""

    count: int
    kind: int = MissionType.MISSION


@dataclass(frozen=True)
class Request(Message):
    """MISSION_REQUEST_INT, or the old MISSION_REQUEST (`legacy`) with the same meaning."""

    seq: int
    kind: int = MissionType.MISSION
    legacy: bool = False


@dataclass(frozen=True)
class ItemAt(Message):
    """MISSION_ITEM_INT: the item at `seq`. `current` 2 and 3 are orders to a flying ArduPilot, never sent here."""

    seq: int
    item: Item
    kind: int = MissionType.MISSION
    current: int = 0


@dataclass(frozen=True)
class Ack(Message):
    """MISSION_ACK: the `Result` of a transfer; PX4 adds the id under which it keeps the list (0: none given)."""

    result: int
    kind: int = MissionType.MISSION
    opaque_id: int = 0


@dataclass(frozen=True)
class RequestList(Message):
    """MISSION_REQUEST_LIST: asks for the number of items."""

    kind: int = MissionType.MISSION


@dataclass(frozen=True)
class ClearAll(Message):
    """MISSION_CLEAR_ALL."""

    kind: int = MissionType.MISSION


@dataclass(frozen=True)
class SetCurrent(Message):
    """MISSION_SET_CURRENT: continue at item `seq` (superseded by command 224, which PX4 lacks)."""

    seq: int


@dataclass(frozen=True)
class Current(Message):
    """MISSION_CURRENT: the current item; states: 0 unknown, 1 none, 2 not started, 3 active, 4 paused, 5 done.

    `total` is 0 if unknown, 65535 for no mission; `mission_id` is as in the `Ack` that took the mission.
    """

    seq: int
    total: int = 0
    mission_state: int = 0
    mission_mode: int = 0
    mission_id: int = 0


@dataclass(frozen=True)
class Reached(Message):
    """MISSION_ITEM_REACHED."""

    seq: int


@dataclass(frozen=True)
class WritePartialList(Message):
    """MISSION_WRITE_PARTIAL_LIST: announces new items `start_index` to `end_index`."""

    start_index: int
    end_index: int
    kind: int = MissionType.MISSION


# --- presence, words, time -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Heartbeat(Message):
    """HEARTBEAT: type, autopilot, mode and status."""

    type: int
    autopilot: int
    base_mode: int = 0
    custom_mode: int = 0
    system_status: int = STANDBY

    @property
    def armed(self) -> bool:
        return bool(self.base_mode & ARMED_FLAG)


@dataclass(frozen=True)
class Text(Message):
    """STATUSTEXT: words for a human; severity 0 (emergency) to 7 (debug). A long text comes in chunks with one `id`."""

    severity: int
    text: str
    id: int = 0
    chunk_seq: int = 0


@dataclass(frozen=True)
class Event(Message):
    """EVENT: PX4's numbered messages (`number` is its id); the ground station has the words."""

    number: int
    log_levels: int
    arguments: bytes = b""


@dataclass(frozen=True)
class Ping(Message):
    """PING: a request is addressed to (0, 0), its answer to the requester."""

    time_usec: int
    seq: int


@dataclass(frozen=True)
class TimeSync(Message):
    """TIMESYNC [ns]: a question has `tc1` 0."""

    tc1: int
    ts1: int


# --- commands and parameters ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class CommandLong(Message):
    """COMMAND_LONG."""

    command: int
    params: tuple[float, float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    confirmation: int = 0


@dataclass(frozen=True)
class CommandInt(Message):
    """COMMAND_INT: x and y are integers on the command's own scale."""

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float


@dataclass(frozen=True)
class CommandAck(Message):
    """COMMAND_ACK: the `CommandResult` of a command."""

    command: int
    result: int
    progress: int = 0
    result_param2: int = 0


@dataclass(frozen=True)
class SetMode(Message):
    """SET_MODE: the old command for a mode."""

    base_mode: int
    custom_mode: int


@dataclass(frozen=True)
class ParamRequestList(Message):
    """PARAM_REQUEST_LIST."""


@dataclass(frozen=True)
class ParamRequestRead(Message):
    """PARAM_REQUEST_READ: by name, or by index unless that is -1."""

    param_id: str
    param_index: int = -1


@dataclass(frozen=True)
class ParamSet(Message):
    """PARAM_SET."""

    param_id: str
    param_value: float
    param_type: int = 9


@dataclass(frozen=True)
class ParamValue(Message):
    """PARAM_VALUE: parameter `param_index` of `param_count`; type 9 is a float."""

    param_id: str
    param_value: float
    param_type: int
    param_count: int
    param_index: int


@dataclass(frozen=True)
class MessageInterval(Message):
    """MESSAGE_INTERVAL: interval of a message [us]; 0 unknown, -1 never."""

    message_id: int
    interval_us: int


@dataclass(frozen=True)
class RequestDataStream(Message):
    """REQUEST_DATA_STREAM: starts or stops a group of messages (MAV_DATA_STREAM, 0 for all) at a rate [Hz]."""

    req_stream_id: int
    req_message_rate: int
    start_stop: int = 1


@dataclass(frozen=True)
class FileTransfer(Message):
    """FILE_TRANSFER_PROTOCOL: 251 bytes of MAVFTP."""

    payload: bytes


#: Messages of the two ends of one transfer, of a list or of a file; they concern nobody else.
TRANSFER = (Count, Request, ItemAt, Ack, RequestList, ClearAll, WritePartialList, FileTransfer)
