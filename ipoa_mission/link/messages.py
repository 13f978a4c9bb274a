"""One frozen class a message. A field with MAVLink's own name has its value too; others are in SI units and degrees.

Received numbers stay integers: an unknown one is no error.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, ClassVar, TypeAlias, dataclass_transform

from ipoa_mission.autopilot.autopilot import VehicleKind
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


class MissionState(IntEnum):
    """MISSION_STATE."""

    UNKNOWN = 0
    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


#: MAV_AUTOPILOT_INVALID: a ground station, a gimbal.
NO_AUTOPILOT = 8
#: MAV_STATE_STANDBY; lower: still booting.
STANDBY = 3
#: MAV_MODE_FLAG_SAFETY_ARMED in HEARTBEAT.base_mode.
ARMED_FLAG = 128
CUSTOM_MODE_FLAG = 1
AUTOPILOT_COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1
STATION_SYSTEM = 245
STATION_COMPONENT = 190  # MAV_COMP_ID_MISSIONPLANNER


#: A field's annotation has MAVLink's names, where they differ.
Kind: TypeAlias = Annotated[int, "mission_type"]
ParamId: TypeAlias = Annotated[str, "param_id"]
Params: TypeAlias = Annotated[
    tuple[float, float, float, float, float, float, float], *(f"param{number}" for number in range(1, 8))
]
Vector3: TypeAlias = tuple[float, float, float]
Booted: TypeAlias = Annotated[float, "time_boot_ms"]  # [s] since boot


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class Message:
    """Each subclass is a frozen dataclass; `name` is MAVLink's, if it has one."""

    NAME: ClassVar[str]

    def __init_subclass__(cls, name: str = "") -> None:
        dataclass(frozen=True)(cls)
        cls.NAME = name


class Count(Message, name="MISSION_COUNT"):
    count: int
    kind: Kind = MissionType.MISSION


class Request(Message, name="MISSION_REQUEST_INT"):
    seq: int
    kind: Kind = MissionType.MISSION
    legacy: bool = False  # MISSION_REQUEST


class ItemAt(Message, name="MISSION_ITEM_INT"):
    seq: int
    item: Item
    kind: Kind = MissionType.MISSION


class Ack(Message, name="MISSION_ACK"):
    result: Annotated[int, "type"]
    kind: Kind = MissionType.MISSION
    opaque_id: int = 0  # PX4's id of the list; 0: none


class RequestList(Message, name="MISSION_REQUEST_LIST"):
    kind: Kind = MissionType.MISSION


class ClearAll(Message, name="MISSION_CLEAR_ALL"):
    kind: Kind = MissionType.MISSION


class SetCurrent(Message, name="MISSION_SET_CURRENT"):
    """Superseded by command 224, which PX4 lacks."""

    seq: int


class Current(Message, name="MISSION_CURRENT"):
    """`total`: 0 unknown, 65535 no mission; `mission_id`: as in its `Ack`."""

    seq: int
    total: int = 0
    mission_state: int = MissionState.UNKNOWN
    mission_mode: int = 0
    mission_id: int = 0


class Reached(Message, name="MISSION_ITEM_REACHED"):
    seq: int


class WritePartialList(Message, name="MISSION_WRITE_PARTIAL_LIST"):
    start_index: int
    end_index: int
    kind: Kind = MissionType.MISSION


class Heartbeat(Message, name="HEARTBEAT"):
    type: int
    autopilot: int
    base_mode: int = 0
    custom_mode: int = 0
    system_status: int = STANDBY

    @property
    def armed(self) -> bool:
        return bool(self.base_mode & ARMED_FLAG)

    @property
    def vehicle(self) -> VehicleKind | None:
        """Return None for a ground station or a gimbal."""
        return None if self.autopilot == NO_AUTOPILOT else VehicleKind(self.autopilot, self.type)


class Text(Message, name="STATUSTEXT"):
    """Severity 0 (emergency) to 7 (debug); chunks of a long text share an `id`."""

    severity: int
    text: Annotated[str, "text"]
    id: int = 0
    chunk_seq: int = 0


class Event(Message, name="EVENT"):
    """The ground station has PX4's words."""

    number: Annotated[int, "id"]
    log_levels: int
    arguments: Annotated[bytes, "arguments"] = b""


class Ping(Message, name="PING"):
    """A request is addressed to (0, 0)."""

    time_usec: int
    seq: int


class TimeSync(Message, name="TIMESYNC"):
    """[ns]; a question has `tc1` 0."""

    tc1: int
    ts1: int


class CommandLong(Message, name="COMMAND_LONG"):
    command: int
    params: Params = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    confirmation: int = 0


class CommandInt(Message, name="COMMAND_INT"):
    command: int
    frame: int
    params: Annotated[tuple[float, float, float, float], "param1", "param2", "param3", "param4"]
    x: int  # on the command's own scale
    y: int
    z: float


class CommandAck(Message, name="COMMAND_ACK"):
    command: int
    result: int


class SetMode(Message, name="SET_MODE"):
    base_mode: int
    custom_mode: int


class ParamRequestList(Message, name="PARAM_REQUEST_LIST"):
    pass


class ParamRequestRead(Message, name="PARAM_REQUEST_READ"):
    param_id: ParamId
    param_index: int = -1  # by name


class ParamSet(Message, name="PARAM_SET"):
    param_id: ParamId
    param_value: float
    param_type: int = 9  # a float


class ParamValue(Message, name="PARAM_VALUE"):
    param_id: ParamId
    param_value: float
    param_type: int
    param_count: int
    param_index: int


class RequestDataStream(Message, name="REQUEST_DATA_STREAM"):
    req_stream_id: int  # MAV_DATA_STREAM; 0: all
    req_message_rate: int  # [Hz]
    start_stop: int = 1


class FileTransfer(Message, name="FILE_TRANSFER_PROTOCOL"):
    payload: Annotated[bytes, "payload"]  # 251 bytes of MAVFTP


class AutopilotVersion(Message, name="AUTOPILOT_VERSION"):
    capabilities: int  # bits of MAV_PROTOCOL_CAPABILITY
    flight_sw_version: int = 0
    uid: int = 0


class ProtocolVersion(Message, name="PROTOCOL_VERSION"):
    version: int  # MAVLink's times 100
    min_version: int
    max_version: int


class HomePosition(Message, name="HOME_POSITION"):
    latitude_deg: Annotated[float, "latitude"]
    longitude_deg: Annotated[float, "longitude"]
    altitude: Annotated[float, "altitude"]


class Position(Message, name="GLOBAL_POSITION_INT"):
    time_s: Booted
    latitude_deg: Annotated[float, "lat"]
    longitude_deg: Annotated[float, "lon"]
    altitude: Annotated[float, "alt"]
    height: Annotated[float, "relative_alt"]  # above home [m]
    velocity: Annotated[Vector3, "vx", "vy", "vz"] = (0.0, 0.0, 0.0)  # north, east, down
    yaw: Annotated[float, "hdg"] = 0.0  # [rad]


class LocalPosition(Message, name="LOCAL_POSITION_NED"):
    time_s: Booted
    position: Annotated[Vector3, "x", "y", "z"]  # from the origin
    velocity: Annotated[Vector3, "vx", "vy", "vz"]


class Gps(Message, name="GPS_RAW_INT"):
    time_s: Annotated[float, "time_usec"]
    latitude_deg: Annotated[float, "lat"]
    longitude_deg: Annotated[float, "lon"]
    altitude: Annotated[float, "alt"]
    speed: Annotated[float, "vel"]
    fix_type: int = 3  # three-dimensional
    satellites_visible: int = 12


class Attitude(Message, name="ATTITUDE"):
    time_s: Booted
    roll: float
    pitch: float
    yaw: float


class Hud(Message, name="VFR_HUD"):
    airspeed: float
    groundspeed: float
    heading: int  # [deg]
    throttle: int
    alt: float
    climb: float


class SystemStatus(Message, name="SYS_STATUS"):
    """Sensor bits, and the battery: [V], remaining [%], [A]."""

    present: Annotated[int, "onboard_control_sensors_present"]
    enabled: Annotated[int, "onboard_control_sensors_enabled"]
    health: Annotated[int, "onboard_control_sensors_health"]
    voltage: Annotated[float, "voltage_battery"] = 12.6
    battery_remaining: int = 100
    current: Annotated[float, "current_battery"] = -0.01  # negative: not measured


class BatteryStatus(Message, name="BATTERY_STATUS"):
    """[V], [A], remaining [%]; negative: not measured."""

    id: int
    voltage: Annotated[float, "voltages", "voltages_ext"]
    current: Annotated[float, "current_battery"]
    battery_remaining: int = -1


class WindEstimate(Message, name="WIND"):
    """Of ArduPilot."""

    direction_deg: Annotated[float, "direction"]  # from
    speed: float


class WindVelocity(Message, name="WIND_COV"):
    """Of PX4."""

    velocity: Annotated[Vector3, "wind_x", "wind_y", "wind_z"]  # north, east, down


class ExtendedState(Message, name="EXTENDED_SYS_STATE"):
    landed_state: int  # 1 on the ground, 2 in the air, 3 taking off, 4 landing


class SystemTime(Message, name="SYSTEM_TIME"):
    unix_s: Annotated[float, "time_unix_usec"]
    boot_s: Booted
