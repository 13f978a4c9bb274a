"""The autopilot's clock behind the stamps of whoever wrote a log down.

Most messages say nothing of time, and a simulation may run ten times as fast as its ground station's clock. So the
vehicle's time at a stamp lies between the messages around it that tell it, and before the first of them it goes on
as fast as it did then.
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
    """How the vehicle's clock and the stamps of a log are read where they jump or break off."""

    restarted_s: float = 10.0  # one that falls back by more has begun anew; by less, frames have overtaken each other
    pace_s: float = 2.0  # as much of the log at each end tells how fast the clock goes there
    torn_s: float = 60.0  # a stamp that is so far from those around it was not written so
    longest_s: float = 1e8  # a TIMESYNC of more is no time since boot


READING = ClockReading()


def vehicle_time(message: Message) -> float | None:
    """The vehicle's time since boot [s] that a message of its own tells, if it does."""
    match message:
        case Position() | Attitude() | LocalPosition():
            return message.time_s
        case SystemTime():
            return message.boot_s
        case TimeSync(0, nanoseconds) if 0 < nanoseconds < READING.longest_s * 1e9:
            return nanoseconds / 1e9
    return None


def unwrapped(stamps: Vector, times: Vector) -> Vector:
    """The same times where they go on over a restart of the autopilot, by the stamps between."""
    times = times.copy()
    for n in np.flatnonzero(np.diff(times) < -READING.restarted_s):
        times[n + 1 :] += times[n] + (stamps[n + 1] - stamps[n]) - times[n + 1]
    return np.asarray(np.maximum.accumulate(times))


def vehicle_times(stamps: Vector, clock_at: Vector, clock: Vector) -> Vector:
    """The vehicle's time at each of `stamps`, by those `clock` at others; all stamps grow. Without any, the stamps."""
    if not len(clock):
        return stamps
    first, last = clock_at[0], clock_at[-1]
    begins = clock[0] + (stamps - first) * _pace(clock_at, clock, slice(None))
    ends = clock[-1] + (stamps - last) * _pace(clock_at, clock, slice(None, None, -1))
    between = np.interp(stamps, clock_at, clock)
    return np.where(stamps < first, begins, np.where(stamps > last, ends, between))


def _pace(clock_at: Vector, clock: Vector, order: slice) -> float:
    """How fast the vehicle's clock goes at the end of the log from which `order` counts."""
    at, times = clock_at[order], clock[order]
    near = np.abs(at - at[0]) <= READING.pace_s
    span = at[near][-1] - at[0]
    if not span:
        near = np.ones(len(at), bool)
        span = at[-1] - at[0]
    return float((times[near][-1] - times[0]) / span) if span else 1.0


def growing(stamps: Sequence[float]) -> Vector:
    """Stamps that tell the order too: each a little later than the one before, counted from the first.

    One that is far from those around it is a torn record's, and takes their place.
    """
    given = np.asarray(stamps, float)
    around = np.median(sliding_window_view(np.pad(given, 2, mode="edge"), 5), axis=1)
    since = np.where(np.abs(given - around) > READING.torn_s, around, given)
    return np.asarray(np.maximum.accumulate(since - since[0]) + 1e-9 * np.arange(len(since)))
