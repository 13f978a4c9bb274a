"""Rates and messages of the telemetry streams."""

import math
from collections.abc import Callable, Mapping, Set
from dataclasses import astuple
from enum import IntFlag

from ipoa_mission.link import telemetry
from ipoa_mission.link.codec import Target
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.messages import Message
from ipoa_mission.link.vehicle_state import PREARM_CHECK
from ipoa_mission.link.wire import saturated
from ipoa_mission.simulator.simulated_flight import SimulatedFlight

FASTEST_S, SLOWEST_S = 0.01, 2000.0
MOST_LISTENERS = 16


class Sensor(IntFlag):
    """MAV_SYS_STATUS_SENSOR."""

    GYRO = 1
    ACCEL = 2
    MAG = 4
    PRESSURE = 8
    GPS = 32
    GEOFENCE = 0x100000
    AHRS = 0x200000
    BATTERY = 0x2000000


class Schedule:
    """Every listener has its own rates; a message goes to all at the highest one."""

    def __init__(self, usual: Mapping[str, float], fixed: Set[str]) -> None:
        """`usual`: default intervals [s]; `fixed`: streams of constant interval."""
        self._usual = usual
        self._fixed = fixed
        self._wishes: dict[Target, dict[str, float]] = {}
        self._intervals = dict(usual)
        self._due = dict.fromkeys(usual, 0.0)

    def hear(self, listener: Target) -> None:
        if listener not in self._wishes:
            while len(self._wishes) >= MOST_LISTENERS:
                del self._wishes[next(iter(self._wishes))]
            self._wishes[listener] = {}

    def set_interval(self, number: int, interval_us: float, now: float, listener: Target) -> bool:
        """Command 511: -1 stops a stream, 0 restores its default; return whether it exists."""
        name = message_name(number)
        if name is None or name not in KNOWN_MESSAGES or name in self._fixed or math.isnan(interval_us):
            return False
        self.hear(listener)
        wishes = self._wishes[listener]
        if interval_us == 0:
            wishes.pop(name, None)
        else:
            wishes[name] = math.inf if interval_us < 0 else min(max(interval_us / 1e6, FASTEST_S), SLOWEST_S)
        self._apply(name, now)
        return True

    def set_rate(self, names: Set[str], rate_hz: int, now: float, listener: Target) -> None:
        """REQUEST_DATA_STREAM in whole milliseconds; 0 stops the group."""
        self.hear(listener)
        interval_ms = 0 if rate_hz == 0 else 1000 // rate_hz
        for name in names:
            self._wishes[listener][name] = math.inf if interval_ms == 0 else max(interval_ms / 1e3, FASTEST_S)
            self._apply(name, now)

    def _apply(self, name: str, now: float) -> None:
        before = self._intervals.get(name, math.inf)
        self._intervals[name] = min(self._interval(name, listener) for listener in self._wishes)
        if self._intervals[name] != before:
            self._due[name] = now + self._intervals[name]

    def interval_us(self, number: int, listener: Target) -> int | None:
        """Command 510 [us]; -1: off; None: no such stream."""
        name = message_name(number)
        if name is None or name not in KNOWN_MESSAGES:
            return None
        interval = self._interval(name, listener)
        return -1 if math.isinf(interval) else round(interval * 1e6)

    def due(self, now: float) -> list[str]:
        names = [name for name, when in self._due.items() if when <= now]
        for name in names:
            self._due[name] = max(self._due[name] + self._intervals[name], now + self._intervals[name] / 2)
        return names

    @property
    def deadline(self) -> float:
        return min(self._due.values())

    def _interval(self, name: str, listener: Target) -> float:
        return self._wishes.get(listener, {}).get(name, self._usual.get(name, math.inf))


def _position(flight: SimulatedFlight, now: float) -> telemetry.Position:
    at, (east, north, up) = flight.position, flight.velocity
    height, velocity = at.altitude - flight.home.altitude, (float(north), float(east), -float(up))
    return telemetry.Position(now, at.latitude_deg, at.longitude_deg, at.altitude, height, velocity, flight.yaw)


def _local(flight: SimulatedFlight, now: float) -> telemetry.LocalPosition:
    (east, north, up), (ve, vn, vu) = flight.local, flight.velocity
    return telemetry.LocalPosition(now, (float(north), float(east), -float(up)), (float(vn), float(ve), -float(vu)))


def _gps(flight: SimulatedFlight, now: float) -> telemetry.Gps:
    at, (east, north, _) = flight.position, flight.velocity
    return telemetry.Gps(now, at.latitude_deg, at.longitude_deg, at.altitude, math.hypot(east, north))


def _hud(flight: SimulatedFlight, now: float) -> telemetry.Hud:
    east, north, up = flight.velocity
    speed = math.hypot(east, north)
    heading = saturated(math.degrees(flight.yaw)) % 360
    return telemetry.Hud(speed, speed, heading, 50 if flight.armed else 0, flight.position.altitude, float(up))


FROM_FLIGHT: Mapping[str, Callable[[SimulatedFlight, float], Message]] = {
    "GLOBAL_POSITION_INT": _position,
    "LOCAL_POSITION_NED": _local,
    "GPS_RAW_INT": _gps,
    "BATTERY_STATUS": lambda flight, now: telemetry.BatteryStatus(0, 12.6, -0.01, 100),
    "ATTITUDE": lambda flight, now: telemetry.Attitude(now, flight.roll, flight.pitch, _half_turn(flight.yaw)),
    "VFR_HUD": _hud,
    "EXTENDED_SYS_STATE": lambda flight, now: telemetry.ExtendedState(1 if flight.landed else 2),
    "SYSTEM_TIME": lambda flight, now: telemetry.SystemTime(0.0, now),
    "HOME_POSITION": lambda flight, now: telemetry.HomePosition(*astuple(flight.home)),
    "GPS_GLOBAL_ORIGIN": lambda flight, now: telemetry.GlobalOrigin(*astuple(flight.home)),
}


def status(is_ready: bool, reports_prearm: bool) -> telemetry.SystemStatus:
    """A passed pre-arm check is healthy, on PX4 without being present."""
    sensors = sum(Sensor)
    bits = sensors | (PREARM_CHECK if reports_prearm else 0)
    return telemetry.SystemStatus(bits, bits, sensors | (PREARM_CHECK if is_ready else 0))


#: As a stream or on request.
KNOWN_MESSAGES = frozenset({"HEARTBEAT", "SYS_STATUS", "MISSION_CURRENT", "TIMESYNC", *FROM_FLIGHT})


def _half_turn(angle: float) -> float:
    return math.remainder(angle, 2 * math.pi) if math.isfinite(angle) else 0.0
