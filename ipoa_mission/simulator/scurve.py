"""Straight legs flown with shaped jerk: acceleration rises and falls by raised-cosine ramps of jerk.

A ramp of height J and length t_j has j(t) = J/2 (1 - cos(pi t / t_j)); the steepest is the snap S = pi J / (2 t_j).
Everything below is integrated in closed form, so a leg can be asked for any moment of its time.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import TypeAlias

Triple: TypeAlias = tuple[float, float, float]  # east, north, up


@dataclass(frozen=True, slots=True)
class Shaping:
    """The most that a leg may ask for along its own direction: m/s, m/s^2, m/s^3, m/s^4."""

    speed: float
    acceleration: float
    jerk: float
    snap: float


@dataclass(frozen=True, slots=True)
class _Piece:
    """A stretch of time with jerk constant (`ramp` 0), rising from nothing (1) or falling to nothing (-1)."""

    begins: float
    lasts: float
    ramp: int
    jerk: float
    acceleration: float
    speed: float
    place: float

    def at(self, t: float) -> Triple:
        """Place, speed and acceleration `t` seconds into the piece."""
        half = self.jerk if self.ramp == 0 else 0.5 * self.jerk
        acceleration = self.acceleration + half * t
        speed = self.speed + (self.acceleration + 0.5 * half * t) * t
        place = self.place + (self.speed + (0.5 * self.acceleration + half * t / 6.0) * t) * t
        if self.ramp and self.lasts > 0.0:
            w = self.lasts / math.pi
            sine, cosine = math.sin(t / w), math.cos(t / w)
            k = half * self.ramp
            acceleration -= k * w * sine
            speed += k * w * w * (cosine - 1.0)
            place += k * w * w * (w * sine - t)
        return place, speed, acceleration


def _bell(gain: float, shaping: Shaping) -> tuple[float, float, float, float]:
    """Jerk, ramp time, time of constant jerk and of constant acceleration that change the speed by `gain` > 0."""
    snap = shaping.snap
    jerk = shaping.jerk
    ramp = 0.5 * math.pi * jerk / snap
    if shaping.acceleration < jerk * ramp:  # too little acceleration for a whole ramp
        ramp = math.sqrt(0.5 * math.pi * shaping.acceleration / snap)
        jerk = 2.0 * snap * ramp / math.pi
    if gain < 2.0 * jerk * ramp * ramp:  # too little gain for a whole ramp
        ramp = (math.pi * gain / (4.0 * snap)) ** (1.0 / 3.0)
        return 2.0 * snap * ramp / math.pi, ramp, 0.0, 0.0
    peak = 0.5 * (math.sqrt((jerk * ramp) ** 2 + 4.0 * jerk * gain) - jerk * ramp)
    if peak <= shaping.acceleration:
        return jerk, ramp, max(peak / jerk - ramp, 0.0), 0.0
    peak = shaping.acceleration
    return jerk, ramp, max(peak / jerk - ramp, 0.0), gain / peak - peak / jerk - ramp


def change_time(gain: float, shaping: Shaping) -> float:
    """Seconds that a change of speed by `gain` takes, from steady to steady."""
    if gain <= 0.0:
        return 0.0
    _, ramp, steady, constant = _bell(gain, shaping)
    return 4.0 * ramp + 2.0 * steady + constant


def _peak_speed(length: float, start: float, end: float, shaping: Shaping) -> float:
    """The highest speed that a leg of `length` has room for; by bisection, as its length grows with its speed."""

    def needed(speed: float) -> float:
        return 0.5 * (start + speed) * change_time(speed - start, shaping) + 0.5 * (end + speed) * change_time(
            speed - end, shaping
        )

    low, high = max(start, end), max(shaping.speed, start, end)
    if needed(high) <= length:
        return high
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if needed(middle) <= length else (low, middle)
    return low


class Leg:
    """Motion along a straight track, and the clock that runs on it."""

    def __init__(self, origin: Triple, destination: Triple, shaping: Shaping, start: float = 0.0, end: float = 0.0):
        self.origin, self.destination, self.shaping = origin, destination, shaping
        self.length = math.dist(origin, destination)
        self.direction: Triple = (
            tuple((d - o) / self.length for o, d in zip(origin, destination, strict=True))  # type: ignore[assignment]
            if self.length > 1e-6
            else (0.0, 0.0, 0.0)
        )
        self.end_speed = end
        self.clock = 0.0
        self._pieces: list[_Piece] = []
        self._begins: list[float] = []
        self.total = 0.0
        self._plan(0.0, start, 0.0)

    def _plan(self, place: float, speed: float, begins: float) -> None:
        """Lay pieces from a steady `speed` at `place`, at clock time `begins`, to the end of the leg."""
        if self.length - place < 1e-6:
            self.peak = self.total = self.turn_in = self.turn_out = begins
            if not self._pieces:
                self._pieces = [_Piece(0.0, 0.0, 0, 0.0, 0.0, 0.0, self.length)]
                self._begins = [0.0]
            return
        peak = self.peak = _peak_speed(self.length - place, speed, self.end_speed, self.shaping)
        self._at = (begins, 0.0, speed, place)
        self.turn_in = self._change(peak - speed)
        used = 0.5 * (self.end_speed + peak) * change_time(peak - self.end_speed, self.shaping)
        self._lay(0, 0.0, max(self.length - self._at[3] - used, 0.0) / peak)
        braking = self._at[0]
        self._change(self.end_speed - peak)
        _, ramp, steady, _ = _bell(peak - self.end_speed, self.shaping) if peak > self.end_speed else (0.0,) * 4
        self.turn_out = braking + 2.0 * ramp + steady
        self.total = self._at[0]

    def _change(self, gain: float) -> float:
        """Lay a change of speed; returns the clock time at which its acceleration begins to fall."""
        if abs(gain) < 1e-9:
            return self._at[0]
        jerk, ramp, steady, constant = _bell(abs(gain), self.shaping)
        jerk = math.copysign(jerk, gain)
        self._lay(1, jerk, ramp)
        self._lay(0, jerk, steady)
        self._lay(-1, jerk, ramp)
        self._lay(0, 0.0, constant)
        falls = self._at[0]
        self._lay(1, -jerk, ramp)
        self._lay(0, -jerk, steady)
        self._lay(-1, -jerk, ramp)
        return falls

    def _lay(self, ramp: int, jerk: float, lasts: float) -> None:
        if lasts <= 0.0:
            return
        begins, acceleration, speed, place = self._at
        piece = _Piece(begins, lasts, ramp, jerk, acceleration, speed, place)
        place, speed, acceleration = piece.at(lasts)
        self._at = (begins + lasts, acceleration, speed, place)
        self._pieces.append(piece)
        self._begins.append(begins)

    def at(self, clock: float) -> Triple:
        """Distance from the origin, speed and acceleration along the track at a moment of its clock."""
        if clock >= self.total:
            return self.length + self.end_speed * (clock - self.total), self.end_speed, 0.0
        piece = self._pieces[bisect_right(self._begins, clock) - 1]
        return piece.at(min(clock - piece.begins, piece.lasts))

    @property
    def remaining(self) -> float:
        """Seconds until the planned end."""
        return max(self.total - self.clock, 0.0)

    @property
    def finished(self) -> bool:
        """Whether the planned motion has ended."""
        return self.clock >= self.total

    def start_at(self, speed: float) -> float:
        """Begin at a speed instead of from rest; half of the leg must be enough to reach it, and half to lose it."""
        start = min(speed, _peak_speed(self.length, 0.0, 0.0, self.shaping))
        self._replan(start)
        return start

    def end_at(self, speed: float) -> float:
        """End at a speed instead of in a stop, likewise."""
        self.end_speed = min(speed, _peak_speed(self.length, 0.0, 0.0, self.shaping))
        self._replan(0.0)
        return self.end_speed

    def _replan(self, start: float) -> None:
        self._pieces, self._begins = [], []
        self._plan(0.0, start, 0.0)

    def change_speed(self, shaping: Shaping) -> None:
        """Go on with another speed limit: let the acceleration fade, then change; too near its end nothing changes."""
        place, speed, acceleration = self.at(self.clock)
        if self.finished:
            return
        was = (self._pieces, self._begins, self.shaping, self.peak, self.total, self.turn_in, self.turn_out)
        self.shaping = shaping
        self._pieces = [p for p in self._pieces if p.begins <= self.clock]
        self._begins = self._begins[: len(self._pieces)]
        self._at = (self.clock, acceleration, speed, place)
        if abs(acceleration) > 1e-6:
            ramp = 0.5 * math.pi * shaping.jerk / shaping.snap
            ramp = min(ramp, math.sqrt(0.5 * math.pi * abs(acceleration) / shaping.snap))
            jerk = -math.copysign(2.0 * shaping.snap * ramp / math.pi, acceleration)
            self._lay(1, jerk, ramp)
            self._lay(0, jerk, max(abs(acceleration / jerk) - ramp, 0.0))
            self._lay(-1, jerk, ramp)
        self._plan(self._at[3], max(self._at[2], 0.0), self._at[0])
        if abs(self._at[3] - self.length) > 0.01:
            self._pieces, self._begins, self.shaping, self.peak, self.total, self.turn_in, self.turn_out = was
