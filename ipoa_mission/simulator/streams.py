"""Rates of the telemetry streams."""

import math
from collections.abc import Mapping, Set

from ipoa_mission.link.definitions import message_name

FASTEST_S, SLOWEST_S = 0.01, 2000.0
#: As a stream or on request.
KNOWN_MESSAGES = frozenset({
    "HEARTBEAT", "SYS_STATUS", "MISSION_CURRENT", "TIMESYNC", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED",
    "GPS_RAW_INT", "BATTERY_STATUS", "ATTITUDE", "VFR_HUD", "EXTENDED_SYS_STATE", "SYSTEM_TIME", "HOME_POSITION",
})  # fmt: skip


class Schedule:
    """A message has one rate for all listeners, the last ordered, as on one link of a vehicle."""

    def __init__(self, usual: Mapping[str, float], fixed: Set[str]) -> None:
        """`usual`: default intervals [s]; `fixed`: streams of constant interval."""
        self._usual = usual
        self._fixed = fixed
        self._intervals = dict(usual)
        self._due = dict.fromkeys(usual, 0.0)

    def set_interval(self, number: int, interval_us: float, now: float) -> bool:
        """Command 511: -1 stops a stream, 0 restores its default; return whether it exists."""
        name = message_name(number)
        if name is None or name not in KNOWN_MESSAGES or name in self._fixed or math.isnan(interval_us):
            return False
        usual = self._usual.get(name, math.inf)
        seconds = math.inf if interval_us < 0 else min(max(interval_us / 1e6, FASTEST_S), SLOWEST_S)
        self._set(name, usual if interval_us == 0 else seconds, now)
        return True

    def set_rate(self, names: Set[str], rate_hz: int, now: float) -> None:
        """REQUEST_DATA_STREAM in whole milliseconds; 0 stops the group."""
        interval_ms = 0 if rate_hz == 0 else 1000 // rate_hz
        for name in names:
            self._set(name, math.inf if interval_ms == 0 else max(interval_ms / 1e3, FASTEST_S), now)

    def _set(self, name: str, seconds: float, now: float) -> None:
        if seconds != self._intervals.get(name, math.inf):
            self._intervals[name] = seconds
            self._due[name] = now + seconds

    def due(self, now: float) -> list[str]:
        names = [name for name, when in self._due.items() if when <= now]
        for name in names:
            self._due[name] = max(self._due[name] + self._intervals[name], now + self._intervals[name] / 2)
        return names

    @property
    def deadline(self) -> float:
        return min(self._due.values())
