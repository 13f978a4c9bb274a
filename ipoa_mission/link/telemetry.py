"""Telemetry messages in SI units and degrees; see `messages`."""

from ipoa_mission.link.messages import Message


class AutopilotVersion(Message):
    """`capabilities`: bits of MAV_PROTOCOL_CAPABILITY."""

    capabilities: int
    flight_sw_version: int = 0
    uid: int = 0


class ProtocolVersion(Message):
    """MAVLink's version times 100."""

    version: int
    min_version: int
    max_version: int


class HomePosition(Message):
    """Altitude AMSL [m]."""

    latitude_deg: float
    longitude_deg: float
    altitude: float


class GlobalOrigin(Message):
    latitude_deg: float
    longitude_deg: float
    altitude: float


class Position(Message):
    """Altitude AMSL, height above home [m]; velocity north, east, down [m/s]; yaw [rad]."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude: float
    height: float
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0


class LocalPosition(Message):
    """North, east, down from the origin [m], and velocity [m/s]."""

    time_s: float
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]


class Gps(Message):
    """A fix of type 3 is three-dimensional."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude: float
    speed: float
    fix_type: int = 3
    satellites_visible: int = 12


class Attitude(Message):
    """[rad]"""

    time_s: float
    roll: float
    pitch: float
    yaw: float


class Hud(Message):
    """Speeds [m/s], altitude AMSL [m], heading [deg]."""

    airspeed: float
    groundspeed: float
    heading: int
    throttle: int
    alt: float
    climb: float


class SystemStatus(Message):
    """Sensor bits; battery voltage [V], remaining [%], current [A]."""

    present: int
    enabled: int
    health: int
    voltage: float = 12.6
    battery_remaining: int = 100
    current: float = -0.01  # negative: not measured


class BatteryStatus(Message):
    """Voltage [V], current [A], remaining [%]; negative: not measured."""

    id: int
    voltage: float
    current: float
    battery_remaining: int = -1


class WindEstimate(Message):
    """ArduPilot's estimate: from direction [deg], speed [m/s]."""

    direction_deg: float
    speed: float


class WindVelocity(Message):
    """PX4's estimate: north, east, down [m/s]."""

    velocity: tuple[float, float, float]


class ExtendedState(Message):
    """`landed_state`: 1 on the ground, 2 in the air, 3 taking off, 4 landing."""

    landed_state: int
    vtol_state: int = 0


class SystemTime(Message):
    """Seconds since 1970 and since boot."""

    unix_s: float
    boot_s: float


class RadioStatus(Message):
    """Sent by the radio itself, so never signed."""

    rssi: int
    remrssi: int
