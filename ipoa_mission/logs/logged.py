import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ipoa_mission.autopilot.autopilot import QUADROTOR, Autopilot, registered
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import LogUseless
from ipoa_mission.geometry import Matrix, Vector
from ipoa_mission.link.messages import ARMED_FLAG, CUSTOM_MODE_FLAG, Current, Heartbeat, Message, Position, SystemTime
from ipoa_mission.mission.items import Item

Battery = tuple[float, float, float]  # [s, V, A]; NaN or negative: not measured


@dataclass(frozen=True, eq=False)
class Measured:
    """Batteries: s, V, A, each (n, 3); attitude: s, roll, pitch, yaw [rad] (m, 4). Times increase."""

    batteries: tuple[Matrix, ...] = ()
    attitude: Matrix = field(default_factory=lambda: np.empty((0, 4)))

    @classmethod
    def of(cls, batteries: Iterable[Iterable[Battery]], attitude: Iterable[tuple[float, ...]] | Matrix) -> "Measured":
        """Make measurements of rows in any order; without voltage left out."""
        read = (_sorted(battery, 3) for battery in batteries)
        angles = _sorted(attitude, 4)
        sound = (np.abs(angles[:, 1:]) < 2 * np.pi + 0.01).all(axis=1)  # yaw may be up to 360 degrees
        return cls(tuple(rows for rows in read if (rows[:, 1] > 0).any()), angles[sound])

    def between(self, begin: float, end: float) -> "Measured":
        return Measured(tuple(_cut(battery, begin, end) for battery in self.batteries), _cut(self.attitude, begin, end))

    def power(self) -> Matrix:
        """Return all batteries' power (n, 2) [s, W], at the first one's times; refuse unmeasured current."""
        measured = []
        reasons = []
        for battery in self.batteries:
            volts = battery[:, 1]  # [V]
            current = battery[:, 2]  # [A]
            most = 10_000.0  # beyond it a reading is wrong
            sound = battery[(volts > 0) & (volts < most) & (current >= 0) & (current < most)]
            amperes = sound[:, 2]
            if len(sound) < 2 or amperes.max() <= 0:
                reasons.append("its battery has no current sensor: the current is always 0 A or -1")
            elif np.ptp(amperes) <= 1e-3 * amperes.mean():  # a measured current varies more
                reasons.append(f"the current of its battery is a constant, {amperes[0]:.3g} A, and not measured")
            else:
                measured.append((sound[:, 0], sound[:, 1] * amperes))
        if not measured:
            raise LogUseless(reasons[0] if reasons else "it has no battery's voltage and current")
        times = measured[0][0]
        return np.column_stack([times, sum(np.interp(times, at, watts) for at, watts in measured)])


def in_order(rows: Matrix) -> Matrix:
    """Return rows by their times in the first column; of equal times the first."""
    return np.asarray(rows[np.unique(rows[:, 0], return_index=True)[1]])


def _sorted(rows: Iterable[tuple[float, ...]] | Matrix, columns: int) -> Matrix:
    table = np.asarray(list(rows), float).reshape(-1, columns)
    return in_order(table[np.isfinite(table[:, :2]).all(axis=1)])


def _cut(rows: Matrix, begin: float, end: float) -> Matrix:
    cut = rows[(rows[:, 0] >= begin) & (rows[:, 0] <= end)].copy()
    cut[:, 0] -= begin
    return cut


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
    """A log, by the autopilot's clock [s].

    `fixes` (n, 8) in order: time; latitude, longitude [deg]; altitude AMSL, height above home [m]; velocity north, east
    and down [m/s]. `events` in any order; a heartbeat marks a change of arming or mode.
    """

    autopilot: Autopilot
    fixes: Matrix
    events: tuple[tuple[float, Message], ...]
    version: str = ""
    remarks: tuple[str, ...] = ()
    measured: Measured = field(default_factory=Measured)


def messages_of(log: Log) -> Iterator[Message]:
    """Return positions and events in order, each after the clock at its time."""
    events = sorted(log.events, key=lambda event: event[0])
    at = np.concatenate([log.fixes[:, 0], np.array([time for time, _ in events])])
    order = np.argsort(at, kind="stable")
    last = None
    for n, now in zip(order, _clock(log.fixes, at[order]), strict=True):
        if at[n] != last:
            yield now
            last = at[n]
        if n >= len(log.fixes):
            yield events[n - len(log.fixes)][1]


def _clock(fixes: Matrix, times: Vector) -> Iterator[Message]:
    if not len(fixes):
        return (SystemTime(0.0, float(time)) for time in times)
    rows = np.column_stack([times, *(np.interp(times, fixes[:, 0], column) for column in fixes.T[1:])]).tolist()
    return (Position(t, lat, lon, alt, up, (north, east, down)) for t, lat, lon, alt, up, north, east, down in rows)


def presence(autopilot: Autopilot, armed: bool, custom_mode: int) -> Heartbeat:
    return Heartbeat(QUADROTOR, autopilot.mav_autopilot, CUSTOM_MODE_FLAG | (ARMED_FLAG if armed else 0), custom_mode)


def item_begun(text: str) -> Current | None:
    """Return the item of ArduPilot's text, as "Mission: 4 WP"."""
    match = re.match(r"Mission: (\d+)\b", text)
    return Current(int(match[1])) if match else None


def version_name(flight_sw_version: int) -> str:
    """As in 4.7.0-dev."""
    return str(Version.of_flight_sw(flight_sw_version) or "")


@dataclass(frozen=True)
class LogFormat:
    suffix: str
    read: Callable[[Path], Log]
    no_mission: str


def log_format(suffix: str) -> LogFormat | None:
    formats = (autopilot.part(LogFormat) for autopilot in registered() if autopilot.has(LogFormat))
    return next((each for each in formats if each.suffix == suffix.lower()), None)
