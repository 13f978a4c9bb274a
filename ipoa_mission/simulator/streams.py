"""What an autopilot tells unasked, and how often; each interval can be changed by command 511."""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from ipoa_mission.link.codec import message_name
from ipoa_mission.link.messages import (
    Attitude,
    ExtendedState,
    GlobalOrigin,
    Gps,
    HomePosition,
    Hud,
    LocalPosition,
    Message,
    Position,
    SystemStatus,
    SystemTime,
)
from ipoa_mission.link.wire import saturated
from ipoa_mission.simulator.flight import Flight

#: Seconds between two messages of a kind.
INTERVALS_S: Mapping[str, float] = MappingProxyType(
    {
        "HEARTBEAT": 1.0,
        "SYS_STATUS": 1.0,
        "SYSTEM_TIME": 1.0,
        "GPS_RAW_INT": 0.5,
        "GLOBAL_POSITION_INT": 0.2,
        "LOCAL_POSITION_NED": 0.5,
        "ATTITUDE": 0.2,
        "VFR_HUD": 0.5,
        "EXTENDED_SYS_STATE": 0.5,
        "MISSION_CURRENT": 0.2,
        "HOME_POSITION": 5.0,
    }
)
FASTEST_S, SLOWEST_S = 0.01, 2000.0

GYRO, ACCEL, MAG, PRESSURE, GPS = 1, 2, 4, 8, 32
GEOFENCE, AHRS, BATTERY, PREARM = 0x100000, 0x200000, 0x2000000, 0x10000000
SENSORS = GYRO | ACCEL | MAG | PRESSURE | GPS | GEOFENCE | AHRS | BATTERY


class Schedule:
    """When which stream is due."""

    def __init__(self) -> None:
        self._intervals = dict(INTERVALS_S)
        self._due = dict.fromkeys(INTERVALS_S, 0.0)

    def set_interval(self, number: int, interval_us: float, now: float) -> bool:
        """Command 511: -1 stops a stream, 0 restores it; whether there is such a stream."""
        name = message_name(number)
        if name is None or name not in INTERVALS_S or math.isnan(interval_us):
            return False
        if interval_us < 0:
            self._due[name] = math.inf
        else:
            wanted_s = interval_us / 1e6 if interval_us else INTERVALS_S[name]
            self._intervals[name] = min(max(wanted_s, FASTEST_S), SLOWEST_S)
            self._due[name] = now + self._intervals[name]
        return True

    def interval_us(self, number: int) -> int:
        """What command 510 asks: microseconds, -1 for a stream that is off, 0 for none."""
        name = message_name(number)
        if name not in self._due:
            return 0
        return -1 if math.isinf(self._due[name]) else round(self._intervals[name] * 1e6)

    def due(self, now: float) -> list[str]:
        """The streams that are due by now, each once."""
        names = [name for name, when in self._due.items() if when <= now]
        for name in names:
            self._due[name] = max(self._due[name] + self._intervals[name], now + self._intervals[name] / 2)
        return names

    @property
    def deadline(self) -> float:
        """When the next is due."""
        return min(self._due.values())


def position(flight: Flight, now: float) -> Position:
    """GLOBAL_POSITION_INT of a flight."""
    at, (east, north, up) = flight.position, flight.velocity
    return Position(
        now,
        at.latitude_deg,
        at.longitude_deg,
        at.altitude,
        at.altitude - flight.home.altitude,
        (float(north), float(east), -float(up)),
        flight.yaw,
    )


def _local(flight: Flight, now: float) -> LocalPosition:
    (east, north, up), (ve, vn, vu) = flight.local, flight.velocity
    return LocalPosition(now, (float(north), float(east), -float(up)), (float(vn), float(ve), -float(vu)))


def _gps(flight: Flight, now: float) -> Gps:
    at, (east, north, _) = flight.position, flight.velocity
    return Gps(now, at.latitude_deg, at.longitude_deg, at.altitude, math.hypot(east, north))


def _hud(flight: Flight, now: float) -> Hud:
    east, north, up = flight.velocity
    speed = math.hypot(east, north)
    heading = saturated(math.degrees(flight.yaw)) % 360
    return Hud(speed, speed, heading, 50 if flight.armed else 0, flight.position.altitude, float(up))


#: The streams that show the flight alone; heartbeat, status and mission need the autopilot.
FROM_FLIGHT: Mapping[str, Callable[[Flight, float], Message]] = MappingProxyType(
    {
        "GLOBAL_POSITION_INT": position,
        "LOCAL_POSITION_NED": _local,
        "GPS_RAW_INT": _gps,
        "ATTITUDE": lambda flight, now: Attitude(now, flight.roll, flight.pitch, _half_turn(flight.yaw)),
        "VFR_HUD": _hud,
        "EXTENDED_SYS_STATE": lambda flight, now: ExtendedState(1 if flight.landed else 2),
        "SYSTEM_TIME": lambda flight, now: SystemTime(0.0, now),
        "HOME_POSITION": lambda flight, now: HomePosition(
            flight.home.latitude_deg, flight.home.longitude_deg, flight.home.altitude
        ),
        "GPS_GLOBAL_ORIGIN": lambda flight, now: GlobalOrigin(
            flight.home.latitude_deg, flight.home.longitude_deg, flight.home.altitude
        ),
    }
)


def status(is_ready: bool) -> SystemStatus:
    """SYS_STATUS: all sensors healthy, and the pre-arm check once it is passed."""
    bits = SENSORS | PREARM
    return SystemStatus(bits, bits, bits if is_ready else SENSORS)


def _half_turn(angle: float) -> float:
    return math.remainder(angle, 2 * math.pi) if math.isfinite(angle) else 0.0
