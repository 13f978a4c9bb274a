"""How long a mission will fly: one answer for every autopilot, leg by leg, with QGroundControl's number beside it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.geometry import Vector
from ipoa_mission.items import Mission
from ipoa_mission.itinerary.itinerary import CONDITIONS, Itinerary, flying_already, itinerary
from ipoa_mission.timing.flight_model import FlightModel
from ipoa_mission.timing.prediction import NEVER_MISSED, Missed, Prediction, Track
from ipoa_mission.timing.qgroundcontrol import qgroundcontrol_time
from ipoa_mission.timing.route import RouteTime, route_time
from ipoa_mission.vehicles.known_parameters import expect_known
from ipoa_mission.vehicles.parameters import NO_PARAMETERS, Parameters
from ipoa_mission.wind import CALM, Wind

EARTH_RADIUS = 6_371_000.0  # [m]


@dataclass(frozen=True)
class ItemTime:
    """One item as it will be flown: done at `done_s`, in nine flights of ten from `low_s` to `high_s`.

    `length` [m] is the path flown for it and `peak_speed`, `mean_speed` [m/s] the speeds along it; `reason` says what
    kept it slow ("corner 87 deg", "leg shorter than its braking distance", "hold"), and is "" where nothing did.
    `missed` is the risk of a waypoint: in which share of the flights the vehicle passes it at a height that does not
    count and turns back, and what that costs; the other times have it in them.
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

    `items` are in the order flown, numbered as in the mission's file (home is 0); an item in a loop appears once for
    each time it is flown. An RTL or LAND is done when the vehicle has disarmed. `track` is
    the path as it will be flown, corners cut, in home's local frame; its speeds are over the ground, in three
    dimensions. `route` holds the time between the first place and the last waypoint against the least that the same
    path takes under the same limits. `remarks` say what of the mission the model does not know.
    """

    total_s: float
    low_s: float
    high_s: float
    qgroundcontrol_s: float
    route: RouteTime
    items: tuple[ItemTime, ...]
    track: Track
    remarks: tuple[str, ...]

    def __repr__(self) -> str:
        between = f"between {self.low_s:.0f} and {self.high_s:.0f}"
        return f"<Estimate: {self.total_s:.1f} s, {between}; {len(self.items)} items>"


def estimate(
    mission: Mission, parameters: Parameters = NO_PARAMETERS, wind: Wind = CALM, fast: bool | None = None
) -> Estimate:
    """Predict when each item of the mission will be done, by the model of `mission.autopilot`.

    `parameters` of the vehicle go before those that the mission carries, and these before the autopilot's defaults.
    `fast` runs the same arithmetic compiled (True: some seconds the first time on a machine, then milliseconds a
    mission), plain (False), or, by default, compiled only where that is ready and quicker. The result is the same.

    >>> from ipoa_mission.items import land, takeoff, waypoint
    >>> from ipoa_mission.world.frame import Geodetic
    >>> home, there = Geodetic(47.397742, 8.545594, 488.0), Geodetic(47.398642, 8.545594, 488.0)
    >>> items = (takeoff(home, 15.0), waypoint(there, 15.0), land(there))
    >>> quad = Mission(home, items, Autopilot.ARDUPILOT, parameters={"LAND_SPEED": 40.0})
    >>> estimate(quad).total_s > estimate(quad, {"LAND_SPEED": 50.0}).total_s
    True

    Raises:
        BadInput: the mission has no end, or a parameter has no sense or is none of this autopilot's.
        MissionError: the vehicle does not get on, as against a wind stronger than it can fly; or it is no multicopter.
    """
    expect_known(parameters, mission.autopilot)
    mission = mission.with_parameters(parameters)
    route, prediction = predict(mission, wind, fast)
    items = _item_times(route, prediction)
    remarks = prediction.remarks
    if route.over_terrain:
        remarks = (*remarks, f"{_items(route.over_terrain)}: height over terrain taken as height over home")
    conditions = [visit.seq for visit in route.visits if visit.item.command in CONDITIONS]
    if conditions:
        remarks = (*remarks, f"{_items(conditions)}: what they put off is taken as done at once")
    if flying_already(route) is not None:
        remarks = (*remarks, "the mission has no take-off: counted from over home, as high as its first place")
    return Estimate(
        total_s=items[-1].done_s if items else 0.0,
        low_s=items[-1].low_s if items else 0.0,
        high_s=items[-1].high_s if items else 0.0,
        qgroundcontrol_s=qgroundcontrol_time(mission),
        route=route_time(route, prediction.done, prediction.track, mission.autopilot, mission.parameters),
        items=items,
        track=in_local_frame(prediction.track),
        remarks=tuple(dict.fromkeys(remarks)),
    )


def _items(seqs: Iterable[int]) -> str:
    """`item 3`, or `items 3, 5`."""
    once = dict.fromkeys(seqs)
    return f"item{'s' if len(once) > 1 else ''} {', '.join(map(str, once))}"


def predict(
    mission: Mission, wind: Wind = CALM, fast: bool | None = None, sure: bool = False
) -> tuple[Itinerary, Prediction]:
    """What the vehicle meets in flight, and what the model says of it.

    `sure`: the vehicle knows where it is, so that PX4 is flown once and not many times; else as in `estimate`.
    """
    if mission.other_vehicle:
        raise MissionError(f"the mission is for {mission.other_vehicle}, and only multicopters have a time model")
    route = itinerary(mission)
    return route, mission.autopilot.part(FlightModel).predicted(route, mission, wind, fast, sure)


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


def in_local_frame(track: Track) -> Track:
    """The same path with `up` over home's tangent plane, as obstacles and terrain have it."""
    sunk = track.points.copy()
    sunk[:, 2] -= (sunk[:, 0] ** 2 + sunk[:, 1] ** 2) / (2 * EARTH_RADIUS)
    return Track(track.times, sunk, track.speeds)
