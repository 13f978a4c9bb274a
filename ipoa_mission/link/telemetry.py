"""Telemetry messages in SI units and degrees, altitudes AMSL; see `messages`."""

from typing import Annotated, TypeAlias

from ipoa_mission.link.messages import Message

Vector3: TypeAlias = tuple[float, float, float]
Booted: TypeAlias = Annotated[float, "time_boot_ms"]  # [s] since boot


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


class GlobalOrigin(Message, name="GPS_GLOBAL_ORIGIN"):
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
    vtol_state: int = 0


class SystemTime(Message, name="SYSTEM_TIME"):
    unix_s: Annotated[float, "time_unix_usec"]
    boot_s: Booted
