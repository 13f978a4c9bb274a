"""Contingencies of one flight, over open, level ground, after which the vehicle may meet another's planned flight."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ipoa_mission import Contingency, Forecast, Mission, MissionError, Scenario, contingency_paths
from ipoa_mission.fleet.encounters import PlannedDeparture
from ipoa_mission.fleet.fleet import STEP_S
from ipoa_mission.fleet.repairs import TimetableSlot
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.wind import Wind

SPACING = 4.0  # of the points of a path [m]


class ContingencyConflict(NamedTuple):
    pair: tuple[str, str]  # the vehicle of the contingency, and the other
    contingency: str
    from_s: float  # of the order, after the start of all
    to_s: float
    place: Vector  # (3,) east, north, up [m]
    distance_m: float


class ContingencyPoints(NamedTuple):
    """Points on the paths of a contingency: order, and earliest and latest presence, infinite where it stays.

    All (n,) [s after the departure].
    """

    contingency: str
    places: Points
    order_s: Vector
    earliest: Vector
    latest: Vector


def contingency_conflicts(
    slots: Sequence[TimetableSlot], frame: LocalFrame, separation: float
) -> tuple[list[ContingencyConflict], list[dict[str, str]]]:
    """Return the conflicts, and rows of unknown paths: vehicle, contingency and why."""
    found = list[ContingencyConflict]()
    unknown = list[dict[str, str]]()
    for slot in slots:
        forecast = open_air(slot.vehicle.mission, slot.vehicle.forecast.wind)
        for contingency, orders in contingency_paths(forecast).items():
            if isinstance(orders, str):
                unknown.append({"vehicle": slot.vehicle.flight.name, "contingency": contingency, "why": orders})
                continue
            points = contingency_points(forecast, contingency, orders, frame)
            for other in (each for each in slots if each is not slot):
                found += _conflicts(points, slot.departure, other.departure, separation)
    return found, unknown


def open_air(mission: Mission, wind: Wind | None = None) -> Forecast:
    home = mission.home
    start = {"east": 0.0, "north": 0.0, "up": 10.0}
    place = {"latitude_deg": home.latitude_deg, "longitude_deg": home.longitude_deg, "altitude_amsl": home.altitude}
    scenario = Scenario.from_dict({"home": place, "start": start, "goal": start | {"east": 10.0}})
    return Forecast(mission, scenario, wind)


def contingency_points(
    forecast: Forecast, contingency: Contingency, orders: Sequence[tuple[float, Points]], frame: LocalFrame
) -> ContingencyPoints:
    kept = [(second, _along(path)) for second, path in _thinned(orders)]
    shares = np.concatenate([shares for _, (_, shares) in kept])
    order_s = np.concatenate([np.full(len(shares), second) for second, (_, shares) in kept])
    earliest, latest = _presence(forecast, contingency, order_s, shares)
    places = frame.moved(np.concatenate([points for _, (points, _) in kept]), forecast.frame)
    return ContingencyPoints(contingency, places, order_s, earliest, latest)


def _thinned(orders: Sequence[tuple[float, Points]]) -> Iterator[tuple[float, Points]]:
    """Yield all orders of the first moment in each half second."""
    step_s = 0.5
    last_step = -1.0
    for second, of_moment in groupby(orders, key=itemgetter(0)):
        if second // step_s != last_step:
            last_step = second // step_s
            yield from of_moment


def _along(path: Points) -> tuple[Points, Vector]:
    """Return even points (n, 3) of a path, and their shares of its length."""
    along = arc_lengths(path)
    shares = np.linspace(0.0, 1.0, 2 + int(along[-1] / SPACING))
    return np.column_stack([np.interp(shares * along[-1], along, axis) for axis in path.T]), shares


def _presence(forecast: Forecast, contingency: Contingency, order_s: Vector, shares: Vector) -> tuple[Vector, Vector]:
    """Return from when to when the vehicle may be at `shares` (n,) of its paths [s]."""
    every_s = 20.0  # interval of the orders whose progress is predicted
    timed_s = np.linspace(order_s[0], order_s[-1], 2 + int((order_s[-1] - order_s[0]) / every_s))
    even = np.linspace(0.0, 1.0, 101)
    seconds = list[Vector]()
    try:
        for second in timed_s.tolist():
            track = forecast.predicted_with(contingency, second).track.between(second, np.inf)
            along = arc_lengths(track.points)
            seconds.append(np.interp(even, along / max(along[-1], 1e-9), track.times - second))
    except MissionError:  # as of a hold
        return order_s, np.full(len(order_s), np.inf)
    nearest = np.abs(timed_s[:, None] - order_s).argmin(axis=0)
    after = np.array(seconds)[nearest, np.rint(shares * (len(even) - 1)).astype(int)]
    doubt = 3.0 + 0.15 * after  # [s]
    stays = (shares == 1.0) & (contingency is not Contingency.RTL)
    return order_s + np.maximum(after - doubt, 0.0), np.where(stays, np.inf, order_s + after + doubt)


def _conflicts(
    points: ContingencyPoints, of: PlannedDeparture, other: PlannedDeparture, separation: float
) -> Iterator[ContingencyConflict]:
    flight = other.flight
    reach = separation + SPACING / 2 + 0.5 * of.flight.longest_step / STEP_S  # of orders between the sampled ones
    tree = cKDTree(flight.places)
    distances, _ = tree.query(points.places, distance_upper_bound=reach)
    near = np.flatnonzero(np.isfinite(distances))
    samples = tree.query_ball_point(points.places[near], reach) if len(near) else []
    later = other.second - of.second
    doubt = 2.0 * float(np.hypot(of.flight.time_deviations.max(), flight.time_deviations.max()) + 1.0)
    seconds = later + STEP_S * np.arange(len(flight.places))
    begins = seconds - STEP_S - doubt
    ends = seconds + STEP_S + doubt
    if not of.flight.uses_pad(flight.places[0]):
        begins[0] = -np.inf  # it waits there
    if not of.flight.uses_pad(flight.places[-1]):
        ends[-1] = np.inf  # it remains there
    is_met = [
        bool(np.any((begins[at] <= latest) & (ends[at] >= earliest)))
        for at, earliest, latest in zip(samples, points.earliest[near], points.latest[near], strict=True)
    ]
    met = near[np.array(is_met, dtype=bool)]
    orders, number = np.unique(points.order_s, return_inverse=True)
    numbers = np.unique(number[met])
    for run in filter(len, np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)):
        of_run = met[np.isin(number[met], run)]
        nearest = of_run[np.argmin(distances[of_run])]
        yield ContingencyConflict(
            pair=(of.flight.name, flight.name),
            contingency=points.contingency,
            from_s=float(orders[run[0]]) + of.second,
            to_s=float(orders[run[-1]]) + of.second,
            place=points.places[nearest],
            distance_m=float(distances[nearest]),
        )
