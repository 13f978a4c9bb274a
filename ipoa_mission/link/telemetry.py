from dataclasses import dataclass

from ipoa_mission.link.messages import Message


@dataclass(frozen=True)
class AutopilotVersion(Message):
    """`capabilities`: bits of MAV_PROTOCOL_CAPABILITY."""

    capabilities: int
    flight_sw_version: int = 0
    uid: int = 0


@dataclass(frozen=True)
class ProtocolVersion(Message):
    """MAVLink's version times 100."""

    version: int
    min_version: int
    max_version: int


@dataclass(frozen=True)
class HomePosition(Message):
    """Altitude AMSL [m]."""

    latitude_deg: float
    longitude_deg: float
    altitude: float


@dataclass(frozen=True)
class GlobalOrigin(Message):
    latitude_deg: float
    longitude_deg: float
    altitude: float


@dataclass(frozen=True)
class Position(Message):
    """Altitude AMSL, height above home [m]; velocity north, east, down [m/s]; yaw [rad]."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude: float
    height: float
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0


@dataclass(frozen=True)
class LocalPosition(Message):
    """North, east, down from the origin [m], and velocity [m/s]."""

    time_s: float
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]


@dataclass(frozen=True)
class Gps(Message):
    """A fix of type 3 is three-dimensional."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude: float
    speed: float
    fix_type: int = 3
    satellites_visible: int = 12


@dataclass(frozen=True)
class Attitude(Message):
    """[rad]"""

    time_s: float
    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True)
class Hud(Message):
    """Speeds [m/s], altitude AMSL [m], heading [deg]."""

    airspeed: float
    groundspeed: float
    heading: int
    throttle: int
    alt: float
    climb: float


@dataclass(frozen=True)
class SystemStatus(Message):
    """Sensor bits; battery voltage [V], remaining [%], current [A]."""

    present: int
    enabled: int
    health: int
    voltage: float = 12.6
    battery_remaining: int = 100
    current: float = -0.01  # negative: not measured


@dataclass(frozen=True)
class BatteryStatus(Message):
    """Voltage [V], current [A], remaining [%]; negative: not measured."""

    id: int
    voltage: float
    current: float
    battery_remaining: int = -1


@dataclass(frozen=True)
class WindEstimate(Message):
    """ArduPilot's estimate: from direction [deg], speed [m/s]."""

    direction_deg: float
    speed: float


@dataclass(frozen=True)
class WindVelocity(Message):
    """PX4's estimate: north, east, down [m/s]."""

    velocity: tuple[float, float, float]


@dataclass(frozen=True)
class ExtendedState(Message):
    """`landed_state`: 1 on the ground, 2 in the air, 3 taking off, 4 landing."""

    landed_state: int
    vtol_state: int = 0


@dataclass(frozen=True)
class SystemTime(Message):
    """Seconds since 1970 and since boot."""

    unix_s: float
    boot_s: float


@dataclass(frozen=True)
class RadioStatus(Message):
    """Sent by the radio itself, so never signed."""

    rssi: int
    remrssi: int
