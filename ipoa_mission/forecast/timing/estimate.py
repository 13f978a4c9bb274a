"""How long a mission will fly: one answer for every autopilot, leg by leg, with QGroundControl's number beside it."""

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
    """One item as it will be flown.

    Attributes:
        seq: its number in the mission's file; home is 0.
        command: MAV_CMD.
        done_s: when it is done, in the mean of its flights [s] ...
        low_s: ... in nine flights of ten from so early ...
        high_s: ... to so late.
        duration_s: how long it takes [s].
        length: of the path flown for it [m].
        peak_speed: on that path, over the ground [m/s].
        mean_speed: the same.
        reason: what kept it slow ("corner 87 deg", "leg shorter than its braking distance", "hold"); "" where nothing
            did.
        missed: the risk of a waypoint: in which share of the flights the vehicle passes it at a height that does not
            count and turns back, and what that costs; the times have it in them.

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
    """A mission's time, from the vehicle's arming on the ground to its disarming, or to the last item done in the air.

    Attributes:
        total_s: in the mean of its flights [s] ...
        low_s: ... in nine flights of ten from so much ...
        high_s: ... to so much.
        qgroundcontrol_s: what QGroundControl shows for it [s].
        route: the time between the first place and the last waypoint against the least that the same path takes under
            the same limits.
        items: in the order flown; one in a loop appears once for each time it is flown. An RTL or LAND is done when the
            vehicle has disarmed.
        track: the path as it will be flown, corners cut, in home's local frame; its speeds are over the ground, in
            three dimensions.
        remarks: what of the mission the model does not know.
        waits: until when it waits at its items, of which the times know nothing.
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
        """What the whole time leaves out, to go behind it; else empty."""
        return f" and the wait{'s' if len(self.waits) > 1 else ''} {', '.join(self.waits)}" if self.waits else ""

    def __repr__(self) -> str:
        between = f"between {self.low_s:.0f} and {self.high_s:.0f}"
        return f"<Estimate: {self.total_s:.1f} s, {between}; {len(self.items)} items>"


def times_of(mission: Mission, route: Itinerary, prediction: Prediction) -> Estimate:
    """What is told of a mission's times, and the path, of its prediction."""
    items = _item_times(route, prediction)
    remarks = prediction.remarks
    if route.over_terrain:
        remarks = (*remarks, f"{_items(route.over_terrain)}: height over terrain taken as height over home")
    conditions = [visit.seq for visit in route.visits if visit.item.command in CONDITIONS]
    if conditions:
        remarks = (*remarks, f"{_items(conditions)}: what they put off is taken as done at once")
    knows_clock = mission.autopilot.guidance.waits_until_clock
    waits = [(visit.seq, visit.item.clock) for visit in route.visits if knows_clock and visit.item.clock]
    remarks += tuple(f"item {seq}: the wait until {until} is not in the times" for seq, until in waits)
    if flying_already(route) is not None:
        remarks = (*remarks, "the mission has no take-off: counted from over home, as high as its first place")
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
    """`item 3`, or `items 3, 5`."""
    once = dict.fromkeys(seqs)
    return f"item{'s' if len(once) > 1 else ''} {', '.join(map(str, once))}"


def _item_times(route: Itinerary, prediction: Prediction) -> tuple[ItemTime, ...]:
    items, begun = [], 0.0
    times = (map(float, values) for values in (prediction.done, prediction.low, prediction.high))
    risks = prediction.missed or (NEVER_MISSED,) * len(route.visits)
    track = prediction.track  # whose axes NumPy would copy whole for each item, did they not lie in one piece each
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
    """Length flown and peak speed between two times, of a track's times, east, north, up and speeds, each (n,)."""
    if end <= begin:
        return 0.0, 0.0
    first, last = np.searchsorted(clock, [begin, end])
    times = np.concatenate([[begin], clock[first:last], [end]])
    points = np.column_stack([np.interp(times, clock, axis) for axis in axes])
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return length, float(np.interp(times, clock, speeds).max())
