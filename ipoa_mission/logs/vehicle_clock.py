"""Time stamps of a log to the autopilot's clock.

A simulation may run ten times as fast.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ipoa_mission.geometry import Vector
from ipoa_mission.link.messages import Message, TimeSync
from ipoa_mission.link.telemetry import Attitude, LocalPosition, Position, SystemTime


@dataclass(frozen=True)
class ClockReading:
    restarted_s: float = 10.0  # a greater step back is a restart
    pace_s: float = 2.0  # span at each end that gives the rate
    torn_s: float = 60.0  # from its neighbors: damaged
    longest_s: float = 1e8  # a greater TIMESYNC is no boot time


READING = ClockReading()


def vehicle_time(message: Message) -> float | None:
    """Return the time since boot [s], if any."""
    match message:
        case Position() | Attitude() | LocalPosition():
            return message.time_s
        case SystemTime():
            return message.boot_s
        case TimeSync(0, nanoseconds) if 0 < nanoseconds < READING.longest_s * 1e9:
            return nanoseconds / 1e9
    return None


def unwrapped(stamps: Vector, times: Vector) -> Vector:
    times = times.copy()
    for n in np.flatnonzero(np.diff(times) < -READING.restarted_s):
        times[n + 1 :] += times[n] + (stamps[n + 1] - stamps[n]) - times[n + 1]
    return np.asarray(np.maximum.accumulate(times))


def vehicle_times(stamps: Vector, clock_at: Vector, clock: Vector) -> Vector:
    """Return the vehicle's time at `stamps`, from `clock` at others; all stamps increase.

    Without a clock, return the stamps.
    """
    if not len(clock):
        return stamps
    first, last = clock_at[0], clock_at[-1]
    begins = clock[0] + (stamps - first) * _pace(clock_at, clock, slice(None))
    ends = clock[-1] + (stamps - last) * _pace(clock_at, clock, slice(None, None, -1))
    between = np.interp(stamps, clock_at, clock)
    return np.where(stamps < first, begins, np.where(stamps > last, ends, between))


def _pace(clock_at: Vector, clock: Vector, order: slice) -> float:
    at, times = clock_at[order], clock[order]
    near = np.abs(at - at[0]) <= READING.pace_s
    span = at[near][-1] - at[0]
    if not span:
        near = np.ones(len(at), bool)
        span = at[-1] - at[0]
    return float((times[near][-1] - times[0]) / span) if span else 1.0


def growing(stamps: Sequence[float]) -> Vector:
    """Return increasing stamps from the first; damaged ones get their neighbors' median."""
    given = np.asarray(stamps, float)
    around = np.median(sliding_window_view(np.pad(given, 2, mode="edge"), 5), axis=1)
    since = np.where(np.abs(given - around) > READING.torn_s, around, given)
    return np.asarray(np.maximum.accumulate(since - since[0]) + 1e-9 * np.arange(len(since)))
