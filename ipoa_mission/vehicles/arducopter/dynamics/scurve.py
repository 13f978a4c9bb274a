"""A leg of ArduCopter 4.x as a speed profile: it rises with raised-cosine jerk ramps, cruises, falls as it rose.

The laws are those of ArduPilot's published behavior ("S-curves", Copter 4.1 on): jerk rises from 0 to J over the ramp
time t_j as (J/2)(1 - cos(pi t/t_j)), may stay at J, and falls again; S = pi J / (2 t_j) is the snap limit.
"""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

CONSTANT, RISING, FALLING = 0.0, 1.0, 2.0  # shapes of jerk over a segment
MOST_SEGMENTS = 24  # of a profile: three changes of speed, and what lies between them


@dataclass(frozen=True)
class SCurveLimits:
    """What a leg keeps along its direction: speed [m/s], acceleration [m/s^2], jerk [m/s^3], snap [m/s^4]."""

    speed: float
    accel: float
    jerk: float
    snap: float


class Segment(NamedTuple):
    """From `begin` [s], `lasts` [s]: jerk of a shape and peak, and the acceleration, speed and way it starts with."""

    begin: float
    lasts: float
    shape: float
    jerk: float
    accel: float
    speed: float
    way: float


class Profile(NamedTuple):
    """A leg's segments; it `lasts` [s], accelerates until `risen`, brakes from `falls`, peaks at `peak` [m/s].

    It ends at the speed `leave`.

    After the last segment come those that never begin, so that there are `MOST_SEGMENTS`.
    """

    segments: Annotated[list[Segment], MOST_SEGMENTS]
    lasts: float
    risen: float
    falls: float
    peak: float
    leave: float = 0.0


def _filled(segments: list[Segment]) -> list[Segment]:
    return segments + [Segment(math.inf, *[0.0] * 6)] * (MOST_SEGMENTS - len(segments))


AT_REST = Profile(_filled([Segment(0.0, 0.0, CONSTANT, 0.0, 0.0, 0.0, 0.0)]), 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Ramp:
    """A change of speed: jerk ramps of `ramp` s each, `hold` s at `jerk`, `coast` s at full acceleration; S-shaped."""

    gain: float
    ramp: float
    jerk: float
    hold: float
    coast: float

    @property
    def lasts(self) -> float:
        """Duration of the whole change [s]."""
        return 4 * self.ramp + 2 * self.hold + self.coast


def ramp_for(gain: float, limits: SCurveLimits, from_rest: bool = True) -> Ramp:
    """The quickest change of speed by `gain`; a small one has shorter ramps from rest, softer ones in motion."""
    if gain <= 1e-9:
        return Ramp(0.0, 0.0, 0.0, 0.0, 0.0)
    jerk, accel = limits.jerk, limits.accel
    ramp = min(jerk * math.pi / (2 * limits.snap), math.sqrt(accel * math.pi / (2 * limits.snap)))
    jerk = min(jerk, 2 * limits.snap * ramp / math.pi)
    full = accel / jerk + ramp  # time from no acceleration to no acceleration, were there no coasting
    if gain >= accel * full:
        return Ramp(gain, ramp, jerk, accel / jerk - ramp, gain / accel - full)
    reached = (-jerk * ramp + math.sqrt((jerk * ramp) ** 2 + 4 * jerk * gain)) / 2
    if reached >= jerk * ramp:
        return Ramp(gain, ramp, jerk, reached / jerk - ramp, 0.0)
    if from_rest:
        ramp = (math.pi * gain / (4 * limits.snap)) ** (1 / 3)
    return Ramp(gain, ramp, gain / (2 * ramp * ramp), 0.0, 0.0)


def profile(length: float, limits: SCurveLimits, enter: float = 0.0, leave: float = 0.0) -> Profile:
    """The profile of a leg of `length` > 0 m; `enter` and `leave` are speeds, cut to the peak of the leg from rest.

    From rest to rest the peak V solves V T(V) = L where the limit cannot be reached, T(V) being the time to reach V
    (each ramp is symmetric in time, so it covers its mean speed times its time).
    """
    peak = _peak(length, limits)
    enter, leave = min(enter, peak), min(leave, peak)
    if enter > 0 or leave > 0:
        if _covers(max(enter, leave), enter, leave, limits) > length:
            enter, leave = (enter, 0.0) if enter > 0 else (0.0, 0.0)  # no room to change over: stop there instead
        peak = _fitting(peak, enter, leave, length, limits)
    up = ramp_for(peak - enter, limits, from_rest=enter <= 0)
    down = ramp_for(peak - leave, limits, from_rest=leave <= 0)
    segments: list[Segment] = []
    state = _append(segments, up, 1.0, (0.0, 0.0, enter, 0.0))
    risen = state[0]
    cruise = max(0.0, (length - state[3] - (peak + leave) / 2 * down.lasts) / peak)
    segments.append(Segment(state[0], cruise, CONSTANT, 0.0, 0.0, peak, state[3]))
    falls = risen + cruise
    state = _append(segments, down, -1.0, (falls, 0.0, peak, state[3] + peak * cruise))
    return Profile(_filled(segments), state[0], risen, falls, peak, leave)


def _covers(peak: float, enter: float, leave: float, limits: SCurveLimits) -> float:
    """The way that the two changes of speed take: each its mean speed times its time."""
    up = ramp_for(peak - enter, limits, from_rest=enter <= 0)
    down = ramp_for(peak - leave, limits, from_rest=leave <= 0)
    return (peak + enter) / 2 * up.lasts + (peak + leave) / 2 * down.lasts


def _fitting(peak: float, enter: float, leave: float, length: float, limits: SCurveLimits) -> float:
    """The highest speed up to `peak` whose two changes fit into the length."""
    low, high = max(enter, leave), peak
    if _covers(high, enter, leave, limits) <= length:
        return high
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if _covers(middle, enter, leave, limits) <= length else (low, middle)
    return low


def change(current: Profile, at: float, length: float, limits: SCurveLimits) -> Profile:
    """The rest of a leg whose speed limit changes `at` s into it: its acceleration is finished, then speed moves over.

    As in the autopilot a leg that brakes already is left alone; a higher speed is one that the way left has room for.
    """
    before = current.peak
    if at >= current.falls or limits.speed == before:
        return current
    begin = max(at, current.risen)
    segments = [s for s in current.segments if s.begin + s.lasts <= current.risen]
    cruise = next(s for s in current.segments if s.begin >= current.risen)
    way = cruise.way + before * (begin - current.risen)

    def needs(peak: float) -> float:
        over, down = ramp_for(abs(peak - before), limits, from_rest=False), ramp_for(peak, limits)
        return (before + peak) / 2 * over.lasts + peak / 2 * down.lasts

    peak = limits.speed
    if needs(peak) > length - way:
        if peak < before:
            return current
        low, high = before, peak
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if needs(middle) <= length - way else (low, middle)
        peak = low
    over, down = ramp_for(abs(peak - before), limits, from_rest=False), ramp_for(peak, limits)
    segments.append(Segment(current.risen, begin - current.risen, CONSTANT, 0.0, 0.0, before, cruise.way))
    state = _append(segments, over, math.copysign(1.0, peak - before), (begin, 0.0, before, way))
    lasts = max(0.0, (length - state[3] - peak / 2 * down.lasts) / peak)
    segments.append(Segment(state[0], lasts, CONSTANT, 0.0, 0.0, peak, state[3]))
    falls = state[0] + lasts
    state = _append(segments, down, -1.0, (falls, 0.0, peak, state[3] + peak * lasts))
    return Profile(_filled(segments), state[0], current.risen, falls, max(peak, before))


def _peak(length: float, limits: SCurveLimits) -> float:
    """The speed reached in the middle of a leg from rest to rest: the limit, or where V T(V) = L."""
    jerk, accel, snap = limits.jerk, limits.accel, limits.snap
    ramp = min(jerk * math.pi / (2 * snap), math.sqrt(accel * math.pi / (2 * snap)))
    jerk = min(jerk, 2 * snap * ramp / math.pi)
    full = accel / jerk + ramp
    speed = accel / 2 * (math.sqrt(full * full + 4 * length / accel) - full)
    if speed < accel * full:  # full acceleration is not reached: 2 a (a/J + t_j)^2 = L for the a that is
        reached = min(accel, (length * jerk * jerk / 2) ** (1 / 3))
        for _ in range(20):  # Newton, from above: it falls monotonically
            time = reached / jerk + ramp
            step = (2 * reached * time * time - length) / (2 * time * (time + 2 * reached / jerk))
            reached -= step
            if abs(step) < 1e-12:
                break
        speed = reached * (reached / jerk + ramp)
        if reached < jerk * ramp:  # nor is full jerk: L = 16 S t_j^4 / pi
            speed = 4 * snap / math.pi * (length * math.pi / (16 * snap)) ** 0.75
    return min(limits.speed, speed)


def _append(
    segments: list[Segment], ramp: Ramp, sign: float, state: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """Add the seven segments of a change of speed; the state (time, acceleration, speed, way) after it."""
    jerk = sign * ramp.jerk
    for shape, lasts, j in (
        (RISING, ramp.ramp, jerk),
        (CONSTANT, ramp.hold, jerk),
        (FALLING, ramp.ramp, jerk),
        (CONSTANT, ramp.coast, 0.0),
        (RISING, ramp.ramp, -jerk),
        (CONSTANT, ramp.hold, -jerk),
        (FALLING, ramp.ramp, -jerk),
    ):
        segment = Segment(state[0], lasts, shape, j, *state[1:])
        segments.append(segment)
        accel, speed, way = _moved(segment, lasts)
        state = (state[0] + lasts, state[1] + accel, state[2] + speed, state[3] + way)
    return state


def _moved(segment: Segment, t: float) -> tuple[float, float, float]:
    """What a segment adds to acceleration, speed and way within t seconds."""
    j, a, v = segment.jerk, segment.accel, segment.speed
    accel, speed, way = j * t, a * t + j * t * t / 2, v * t + a * t * t / 2 + j * t**3 / 6
    if segment.shape == CONSTANT or segment.lasts <= 0:
        return accel, speed, way
    b = segment.lasts / math.pi
    s = b if segment.shape == RISING else -b
    half = j / 2
    return (
        half * (t - s * math.sin(t / b)),
        a * t + half * (t * t / 2 + s * b * (math.cos(t / b) - 1)),
        v * t + a * t * t / 2 + half * (t**3 / 6 + s * b * (b * math.sin(t / b) - t)),
    )
