import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.forecast.itinerary.itinerary import CONDITIONS, Itinerary
from ipoa_mission.forecast.timing.flight_model import NEVER_MISSED, Missed, Prediction
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Vector, leg_lengths
from ipoa_mission.mission.item_words import name_items
from ipoa_mission.mission.items import LEFT_OUT, Mission
from ipoa_mission.mission.program import behind_landing, stays_at

COUNTED_TERMS = (
    "distance over speed, climb of the take-off, holds, RTL's descent; no take-off delay, no landing, no corner"
)


def route_time(itinerary: Itinerary, prediction: Prediction) -> float:
    visits = itinerary.visits
    ends = [n for n, visit in enumerate(visits) if visit.item.is_waypoint]
    starts = [n for n, visit in enumerate(visits) if visit.item.command in WAYPOINTS | {Command.NAV_TAKEOFF}]
    if not ends or starts[0] == ends[-1]:
        return math.nan
    begin = float(prediction.done[starts[0]])
    end = float(prediction.done[ends[-1]])
    path = prediction.track.between(begin, end).points
    return end - begin if len(path) > 1 and leg_lengths(path).max() > 1e-6 else math.nan


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
        route_s: from the first place to the last waypoint; NaN without a route [s].
        items: in the order flown, once for each pass.
        track: the path as flown, in home's local frame.
        remarks: what the model leaves out.
        waits: times of day that its items wait for, not included.
    """

    total_s: float
    low_s: float
    high_s: float
    qgroundcontrol_s: float
    route_s: float
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


def times_of(itinerary: Itinerary, prediction: Prediction) -> Estimate:
    items = _item_times(itinerary, prediction)
    remarks = prediction.remarks
    if itinerary.over_terrain:
        remarks = (*remarks, f"{name_items(itinerary.over_terrain)}: height over terrain taken as height over home")
    conditions = [seq for seq, item in itinerary.visits if item.command in CONDITIONS and item is not LEFT_OUT]
    if conditions:
        remarks = (*remarks, f"{name_items(conditions)}: the delayed action counts as done at once")
    knows_clock = itinerary.mission.autopilot.guidance.waits_until_clock
    waits = [(visit.seq, visit.item.clock) for visit in itinerary.visits if knows_clock and visit.item.clock]
    behind = behind_landing(itinerary.mission)
    if behind is not None:
        remarks = (*remarks, f"item {behind[1].seq}: the mission ends at item {behind[0].seq}; the times go on")
    staying = [at.seq for at in stays_at(itinerary.mission)]
    if staying:
        remarks = (*remarks, f"{name_items(staying)}: the time until an operator goes on is not in the times")
    remarks += tuple(f"item {seq}: the wait until {until} is not in the times" for seq, until in waits)
    if itinerary.start_height is not None:
        remarks = (*remarks, "the mission has no take-off: the time starts over home, at the height of its first place")
    return Estimate(
        total_s=items[-1].done_s if items else 0.0,
        low_s=items[-1].low_s if items else 0.0,
        high_s=items[-1].high_s if items else 0.0,
        qgroundcontrol_s=qgroundcontrol_time(itinerary.mission),
        route_s=route_time(itinerary, prediction),
        items=items,
        track=prediction.track.local(),
        remarks=tuple(dict.fromkeys(remarks)),
        waits=tuple(dict.fromkeys(f"of item {seq} until {until}" for seq, until in waits)),
    )


def _item_times(itinerary: Itinerary, prediction: Prediction) -> tuple[ItemTime, ...]:
    items = list[ItemTime]()
    begun = 0.0
    times = (map(float, values) for values in (prediction.done, prediction.low, prediction.high))
    risks = prediction.missed or (NEVER_MISSED,) * len(itinerary.visits)
    track = prediction.track
    track_times = np.ascontiguousarray(track.times)
    speeds = np.ascontiguousarray(track.speeds)
    axes = [np.ascontiguousarray(axis) for axis in track.points.T]  # NumPy would copy strided ones for each item
    for visit, done, low, high, reason, missed in zip(itinerary.visits, *times, prediction.reasons, risks, strict=True):
        length, peak = _flown(track_times, axes, speeds, begun, done)
        lasted = done - begun
        items.append(
            ItemTime(
                visit.seq,
                visit.item.command,
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


def _flown(
    track_times: Vector, axes: Sequence[Vector], speeds: Vector, begin: float, end: float
) -> tuple[float, float]:
    if end <= begin:
        return 0.0, 0.0
    first, last = np.searchsorted(track_times, [begin, end])
    times = np.concatenate([[begin], track_times[first:last], [end]])
    points = np.column_stack([np.interp(times, track_times, axis) for axis in axes])
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return length, float(np.interp(times, track_times, speeds).max())


def qgroundcontrol_time(mission: Mission) -> float:
    """Return the mission time [s] that QGroundControl shows: distance over speed.

    Legs are great circles; DO_CHANGE_SPEED counts from the next item. RTL adds the height over the descent speed (4.4
    has these swapped).
    """
    hover_speed, ascent_speed, descent_speed = 5.0, 3.0, 1.0  # its settings without a vehicle [m/s]
    delays = {Command.NAV_WAYPOINT, Command.NAV_DELAY, Command.CONDITION_DELAY}
    speed = mission.cruise_speed or hover_speed
    here = (mission.home.latitude_deg, mission.home.longitude_deg)
    height = 0.0
    total = 0.0
    taken_off = False
    for item in mission.items:
        if item.command == Command.NAV_RETURN_TO_LAUNCH:
            way_home = _great_circle(here, (mission.home.latitude_deg, mission.home.longitude_deg))
            return total + way_home / speed + abs(height) / descent_speed
        if item.command == Command.NAV_TAKEOFF and not taken_off:
            total += abs(item.height(mission.home)) / ascent_speed
            taken_off = True
        if item.command in delays and item.params[0] > 0:
            total += item.params[0]
        if item.has_position:
            there = (item.latitude_deg, item.longitude_deg)
            total += _great_circle(here, there) / speed
            here = there
            height = item.height(mission.home)
        if item.command == Command.DO_CHANGE_SPEED and item.params[1] > 0:
            speed = item.params[1]
    return total


def _great_circle(begin: tuple[float, float], end: tuple[float, float]) -> float:
    latitude, longitude = np.radians([begin, end]).T
    by_latitude = math.sin((latitude[1] - latitude[0]) / 2) ** 2
    by_longitude = math.sin((longitude[1] - longitude[0]) / 2) ** 2
    half = by_latitude + math.cos(latitude[0]) * math.cos(latitude[1]) * by_longitude
    return 2 * 6_371_007.0 * math.asin(math.sqrt(half))  # Earth's radius [m] of QGeoCoordinate::distanceTo
