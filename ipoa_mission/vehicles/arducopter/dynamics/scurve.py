"""Speed profile of an ArduCopter 4.x leg ("S-curves", Copter 4.1 on).

Jerk rises from 0 to J as `(J/2)(1 - cos(pi t/t_j))`, may stay, and falls. The snap limit is S = pi J / (2 t_j).
"""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

Triple = tuple[float, float, float]
Moment = tuple[float, float, float, float]  # time, acceleration, speed, distance
CONSTANT, RISING, FALLING = 0.0, 1.0, 2.0  # jerk over a segment
MOST_SEGMENTS = 24


class SCurveLimits(NamedTuple):
    """Limits along a leg [m/s, m/s^2, m/s^3, m/s^4]."""

    speed: float
    accel: float
    jerk: float
    snap: float


class Segment(NamedTuple):
    """A span of one jerk shape, and the state at its start."""

    begin: float
    lasts: float
    shape: float
    jerk: float
    accel: float
    speed: float
    distance: float


class Profile(NamedTuple):
    segments: Annotated[list[Segment], MOST_SEGMENTS]  # some never start
    lasts: float
    risen: float  # it accelerates until then [s]
    falls: float  # it brakes from then on [s]
    peak: float
    leave: float = 0.0


def _fill(segments: list[Segment]) -> list[Segment]:
    return segments + [Segment(math.inf, *[0.0] * 6)] * (MOST_SEGMENTS - len(segments))


AT_REST = Profile(
    _fill([Segment(begin=0.0, lasts=0.0, shape=CONSTANT, jerk=0.0, accel=0.0, speed=0.0, distance=0.0)]), *[0.0] * 4
)


@dataclass(frozen=True)
class Ramp:
    ramp: float  # of the jerk [s]
    jerk: float
    hold: float  # at this jerk [s]
    coast: float  # at full acceleration [s]

    @property
    def lasts(self) -> float:
        return 4 * self.ramp + 2 * self.hold + self.coast


def ramp_for(gain: float, limits: SCurveLimits, from_rest: bool = True) -> Ramp:
    """Return the fastest change by `gain`; small ones get shorter ramps from rest, softer ones in motion."""
    if gain <= 1e-9:
        return Ramp(0.0, 0.0, 0.0, 0.0)
    jerk, accel = limits.jerk, limits.accel
    ramp = min(jerk * math.pi / (2 * limits.snap), math.sqrt(accel * math.pi / (2 * limits.snap)))
    jerk = min(jerk, 2 * limits.snap * ramp / math.pi)
    full = accel / jerk + ramp
    if gain >= accel * full:
        return Ramp(ramp, jerk, accel / jerk - ramp, gain / accel - full)
    reached = (-jerk * ramp + math.sqrt((jerk * ramp) ** 2 + 4 * jerk * gain)) / 2
    if reached >= jerk * ramp:
        return Ramp(ramp, jerk, reached / jerk - ramp, 0.0)
    if from_rest:
        ramp = (math.pi * gain / (4 * limits.snap)) ** (1 / 3)
    return Ramp(ramp, gain / (2 * ramp * ramp), 0.0, 0.0)


def profile(length: float, limits: SCurveLimits, enter: float = 0.0, leave: float = 0.0) -> Profile:
    """Return the profile of a leg of `length` > 0 m; end speeds are cut to the peak from rest."""
    peak = _peak(length, limits)
    enter, leave = min(enter, peak), min(leave, peak)
    if enter > 0 or leave > 0:
        if _distance(max(enter, leave), enter, leave, limits) > length:
            enter, leave = (enter, 0.0) if enter > 0 else (0.0, 0.0)  # no room for the change: stop
        peak = _fit_peak(peak, enter, leave, length, limits)
    segments: list[Segment] = []
    up = ramp_for(peak - enter, limits, from_rest=enter <= 0)
    state = _append(segments, up, 1.0, (0.0, 0.0, enter, 0.0))
    down = ramp_for(peak - leave, limits, from_rest=leave <= 0)
    falls, lasts = _cruise_and_brake(segments, state, (peak, leave), down, length)
    return Profile(_fill(segments), lasts=lasts, risen=state[0], falls=falls, peak=peak, leave=leave)


def _cruise_and_brake(
    segments: list[Segment], state: Moment, speeds: tuple[float, float], down: Ramp, length: float
) -> tuple[float, float]:
    """Append the leg after its peak; return when it brakes and ends [s]."""
    (begin, _, _, distance), (peak, leave) = state, speeds
    cruise = max(0.0, (length - distance - (peak + leave) / 2 * down.lasts) / peak)
    segments.append(
        Segment(begin=begin, lasts=cruise, shape=CONSTANT, jerk=0.0, accel=0.0, speed=peak, distance=distance)
    )
    falls = begin + cruise
    return falls, _append(segments, down, -1.0, (falls, 0.0, peak, distance + peak * cruise))[0]


def _distance(peak: float, enter: float, leave: float, limits: SCurveLimits) -> float:
    up = ramp_for(abs(peak - enter), limits, from_rest=enter <= 0)
    down = ramp_for(peak - leave, limits, from_rest=leave <= 0)
    return (peak + enter) / 2 * up.lasts + (peak + leave) / 2 * down.lasts


def _fit_peak(peak: float, enter: float, leave: float, length: float, limits: SCurveLimits) -> float:
    low, high = max(enter, leave), peak
    if _distance(high, enter, leave, limits) <= length:
        return high
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if _distance(middle, enter, leave, limits) <= length else (low, middle)
    return low


def change(current: Profile, time: float, length: float, limits: SCurveLimits) -> Profile:
    """Return a profile whose limit changes at `time` [s], after its acceleration; the same if it brakes."""
    before = current.peak
    if time >= current.falls or limits.speed == before:
        return current
    begin = max(time, current.risen)
    segments = [s for s in current.segments if s.begin + s.lasts <= current.risen]
    cruise = next(s for s in current.segments if s.begin >= current.risen)
    distance = cruise.distance + before * (begin - current.risen)
    if limits.speed < before and _distance(limits.speed, before, 0.0, limits) > length - distance:
        return current
    peak = _fit_peak(limits.speed, before, 0.0, length - distance, limits)
    at_limit = Segment(
        begin=current.risen, lasts=begin - current.risen, shape=CONSTANT,
        jerk=0.0, accel=0.0, speed=before, distance=cruise.distance,
    )  # fmt: skip
    segments.append(at_limit)
    over = ramp_for(abs(peak - before), limits, from_rest=False)
    state = _append(segments, over, math.copysign(1.0, peak - before), (begin, 0.0, before, distance))
    falls, lasts = _cruise_and_brake(segments, state, (peak, 0.0), ramp_for(peak, limits), length)
    return Profile(_fill(segments), lasts=lasts, risen=current.risen, falls=falls, peak=max(peak, before))


def _peak(length: float, limits: SCurveLimits) -> float:
    """Return the peak speed from rest to rest: the limit, or V with V T(V) = L."""
    jerk, accel, snap = limits.jerk, limits.accel, limits.snap
    ramp = min(jerk * math.pi / (2 * snap), math.sqrt(accel * math.pi / (2 * snap)))
    jerk = min(jerk, 2 * snap * ramp / math.pi)
    full = accel / jerk + ramp
    speed = accel / 2 * (math.sqrt(full * full + 4 * length / accel) - full)
    if speed < accel * full:  # 2 a (a/J + t_j)^2 = L
        reached = min(accel, (length * jerk * jerk / 2) ** (1 / 3))
        for _ in range(20):  # Newton, monotonic
            time = reached / jerk + ramp
            step = (2 * reached * time * time - length) / (2 * time * (time + 2 * reached / jerk))
            reached -= step
            if abs(step) < 1e-12:
                break
        speed = reached * (reached / jerk + ramp)
        if reached < jerk * ramp:  # L = 16 S t_j^4 / pi
            speed = 4 * snap / math.pi * (length * math.pi / (16 * snap)) ** 0.75
    return min(limits.speed, speed)


def _append(segments: list[Segment], ramp: Ramp, sign: float, state: Moment) -> Moment:
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
        state = (state[0] + lasts, *motion_in(segment, lasts))
    return state


def motion_in(segment: Segment, t: float) -> Triple:
    """Return acceleration, speed and distance after `t` s: integrals of j t, or of the module's jerk."""
    j, a, v, distance = segment.jerk, segment.accel, segment.speed, segment.distance
    if segment.shape == CONSTANT or segment.lasts <= 0.0:
        return a + j * t, v + t * (a + j * t / 2), distance + t * (v + t * (a / 2 + j * t / 6))
    b = segment.lasts / math.pi
    s = b if segment.shape == RISING else -b
    sine, cosine, half = math.sin(t / b), math.cos(t / b), j / 2
    return (
        a + half * (t - s * sine),
        v + a * t + half * (t * t / 2 + s * b * (cosine - 1.0)),
        distance + v * t + a * t * t / 2 + half * (t * t * t / 6 + s * b * (b * sine - t)),
    )
