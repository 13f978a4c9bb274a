"""Estimate the time of a mission by item."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ipoa_mission.forecast.itinerary.itinerary import CONDITIONS, Itinerary, flying_already
from ipoa_mission.forecast.timing.prediction import NEVER_MISSED, Missed, Prediction
from ipoa_mission.forecast.timing.qgroundcontrol import qgroundcontrol_time
from ipoa_mission.forecast.timing.route_time import RouteTime, route_time
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Vector
from ipoa_mission.mission.items import Mission


@dataclass(frozen=True)
class ItemTime:
    """The forecast of one item.

    Attributes:
        seq: its number in the mission's file; home is 0.
        command: MAV_CMD.
        done_s: in the mean of its flights [s].
        low_s: the earliest of nine flights in ten [s].
        high_s: the latest of nine flights in ten [s].
        duration_s: [s].
        length: flown [m].
        peak_speed: over the ground [m/s].
        mean_speed: over the ground [m/s].
        reason: why it is slow ("corner 87 deg", "hold"), or "".
        missed: the risk to turn back to it, included in the times.

    Example:
        >>> from ipoa_mission import estimate, read_mission
        >>> first = estimate(read_mission("missions/sitl.plan")).items[0]
        >>> first.seq, first.low_s <= first.done_s <= first.high_s
        (1, True)
    """

    seq: int
    command: int
    done_s: float
    low_s: float
    high_s: float
    duration_s: float
    length: float
    peak_speed: float
    mean_speed: float
    reason: str
    missed: Missed = NEVER_MISSED


@dataclass(frozen=True, repr=False)
class Estimate:
    """The time of a mission, from arming to disarming, or to the last item in the air.

    Attributes:
        total_s: in the mean of its flights [s].
        low_s: the shortest of nine flights in ten [s].
        high_s: the longest of nine flights in ten [s].
        qgroundcontrol_s: the time that QGroundControl shows [s].
        route: the time from the first place to the last waypoint.
        items: in the order flown, once for each pass.
        track: the path as flown, in home's local frame.
        remarks: what the model leaves out.
        waits: times of day that its items wait for, not included.
    """

    total_s: float
    low_s: float
    high_s: float
    qgroundcontrol_s: float
    route: RouteTime
    items: tuple[ItemTime, ...]
    track: Track
    remarks: tuple[str, ...]
    waits: tuple[str, ...] = ()

    @property
    def besides(self) -> str:
        return f" and the wait{'s' if len(self.waits) > 1 else ''} {', '.join(self.waits)}" if self.waits else ""

    def __repr__(self) -> str:
        between = f"between {self.low_s:.0f} and {self.high_s:.0f}"
        return f"<Estimate: {self.total_s:.1f} s, {between}; {len(self.items)} items>"


def times_of(mission: Mission, route: Itinerary, prediction: Prediction) -> Estimate:
    items = _item_times(route, prediction)
    remarks = prediction.remarks
    if route.over_terrain:
        remarks = (*remarks, f"{_items(route.over_terrain)}: height over terrain taken as height over home")
    conditions = [visit.seq for visit in route.visits if visit.item.command in CONDITIONS]
    if conditions:
        remarks = (*remarks, f"{_items(conditions)}: the delayed action counts as done at once")
    knows_clock = mission.autopilot.guidance.waits_until_clock
    waits = [(visit.seq, visit.item.clock) for visit in route.visits if knows_clock and visit.item.clock]
    remarks += tuple(f"item {seq}: the wait until {until} is not in the times" for seq, until in waits)
    if flying_already(route) is not None:
        remarks = (*remarks, "the mission has no take-off: the time starts over home, at the height of its first place")
    return Estimate(
        total_s=items[-1].done_s if items else 0.0,
        low_s=items[-1].low_s if items else 0.0,
        high_s=items[-1].high_s if items else 0.0,
        qgroundcontrol_s=qgroundcontrol_time(mission),
        route=route_time(route, prediction.done, prediction.track, mission.autopilot, mission.parameters),
        items=items,
        track=prediction.track.local(),
        remarks=tuple(dict.fromkeys(remarks)),
        waits=tuple(dict.fromkeys(f"of item {seq} until {until}" for seq, until in waits)),
    )


def _items(seqs: Iterable[int]) -> str:
    once = dict.fromkeys(seqs)
    return f"item{'s' if len(once) > 1 else ''} {', '.join(map(str, once))}"


def _item_times(route: Itinerary, prediction: Prediction) -> tuple[ItemTime, ...]:
    items, begun = [], 0.0
    times = (map(float, values) for values in (prediction.done, prediction.low, prediction.high))
    risks = prediction.missed or (NEVER_MISSED,) * len(route.visits)
    track = prediction.track  # NumPy would copy strided axes for each item
    clock, speeds, *axes = map(np.ascontiguousarray, (track.times, track.speeds, *track.points.T))
    for visit, done, low, high, reason, missed in zip(route.visits, *times, prediction.reasons, risks, strict=True):
        length, peak = _flown(clock, axes, speeds, begun, done)
        lasted = done - begun
        items.append(
            ItemTime(
                seq=visit.seq,
                command=visit.item.command,
                done_s=done,
                low_s=max(low, 0.0),
                high_s=high,
                duration_s=lasted,
                length=length,
                peak_speed=peak,
                mean_speed=length / lasted if lasted > 0 else 0.0,
                reason=reason,
                missed=missed,
            )
        )
        begun = done
    return tuple(items)


def _flown(clock: Vector, axes: Sequence[Vector], speeds: Vector, begin: float, end: float) -> tuple[float, float]:
    if end <= begin:
        return 0.0, 0.0
    first, last = np.searchsorted(clock, [begin, end])
    times = np.concatenate([[begin], clock[first:last], [end]])
    points = np.column_stack([np.interp(times, clock, axis) for axis in axes])
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return length, float(np.interp(times, clock, speeds).max())
