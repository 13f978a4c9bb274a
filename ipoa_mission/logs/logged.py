import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.vehicle_kind import QUADROTOR
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.link.messages import ARMED_FLAG, CUSTOM_MODE_FLAG, Current, Heartbeat, Message
from ipoa_mission.link.telemetry import Position, SystemTime
from ipoa_mission.logs.logged_measurements import Measured
from ipoa_mission.mission.items import Item

#: ArduPilot's text: "Mission: 4 WP".
ITEM_BEGINS = re.compile(r"Mission: (\d+)\b")


@dataclass(frozen=True)
class Fixes:
    """Positions by the autopilot's clock [s], in order.

    Degrees, altitude AMSL and height above home [m], each (n,); velocity north, east, down (n, 3) [m/s].
    """

    times: Vector
    latitude_deg: Vector
    longitude_deg: Vector
    altitude: Vector
    height: Vector
    velocity: Points

    @classmethod
    def of(cls, rows: Points) -> "Fixes":
        """Make fixes of rows (n, 8) in any order; of equal times the first counts."""
        rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
        times, latitude, longitude, altitude, height = rows.T[:5]
        return cls(times, latitude, longitude, altitude, height, rows[:, 5:])


class Held(Message):
    """The vehicle holds these items; no message of the link."""

    items: tuple[Item, ...]


class Begun(Message):
    """The item at `seq` of `total` begins; no message of the link."""

    seq: int
    total: int
    item: Item


@dataclass(frozen=True)
class Log:
    """A whole log; `events` with times by the autopilot's clock [s], in any order.

    A heartbeat marks a change of arming or mode.
    """

    autopilot: Autopilot
    fixes: Fixes
    events: tuple[tuple[float, Message], ...]
    version: str = ""
    remarks: tuple[str, ...] = field(default=())
    measured: Measured = field(default_factory=Measured)


def messages_of(log: Log) -> Iterator[Message]:
    events = sorted(log.events, key=lambda event: event[0])
    fixes = log.fixes
    at = np.concatenate([fixes.times, np.array([time for time, _ in events])])
    order = np.argsort(at, kind="stable")
    clock = _clock(fixes, at[order])
    last = None
    for n, now in zip(order, clock, strict=True):
        if at[n] != last:
            yield now
            last = at[n]
        if n >= len(fixes.times):
            yield events[n - len(fixes.times)][1]


def _clock(fixes: Fixes, times: Vector) -> Iterator[Message]:
    if not len(fixes.times):
        return (SystemTime(0.0, float(time)) for time in times)
    columns = (fixes.latitude_deg, fixes.longitude_deg, fixes.altitude, fixes.height, *fixes.velocity.T)
    rows = np.column_stack([times, *(np.interp(times, fixes.times, column) for column in columns)]).tolist()
    return (Position(t, lat, lon, alt, up, (north, east, down)) for t, lat, lon, alt, up, north, east, down in rows)


def presence(autopilot: Autopilot, armed: bool, custom_mode: int) -> Heartbeat:
    flags = CUSTOM_MODE_FLAG | (ARMED_FLAG if armed else 0)
    return Heartbeat(QUADROTOR, autopilot.mav_autopilot, flags, custom_mode)


def item_begun(text: str) -> Current | None:
    match = ITEM_BEGINS.match(text)
    return Current(int(match[1])) if match else None


def version_name(flight_sw_version: int) -> str:
    """As in 4.7.0-dev."""
    return str(Version.said(flight_sw_version) or "")


@dataclass(frozen=True)
class LogFormat:
    suffix: str
    read: Callable[[Path], Log]
    no_mission: str


def log_format(suffix: str) -> LogFormat | None:
    formats = (one.part(LogFormat) for one in registered() if one.has(LogFormat))
    return next((one for one in formats if one.suffix == suffix.lower()), None)
