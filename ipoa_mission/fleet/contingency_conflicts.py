"""Find where an RTL, a landing or a hold of one vehicle, at any second, may meet the planned flight of another.

The paths are those over open, level ground at the height of home: no scenario is known.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ipoa_mission import Forecast, MissionError, Scenario
from ipoa_mission.fleet.fleet import Fleet, FleetVehicle
from ipoa_mission.fleet.timed_flight import STEP_S, TimedFlight, within_pad
from ipoa_mission.fleet.traffic import PlannedDeparture
from ipoa_mission.forecast.contingency.contingencies import Contingencies, contingencies_of
from ipoa_mission.forecast.contingency.contingency_samples import ContingencySamples
from ipoa_mission.forecast.timing.flight_model import FlightModel, Prediction
from ipoa_mission.forecast.timing.track import interpolate
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Matrix, Points, Vector, arc_lengths

SPACING = 4.0  # of the points of a path [m]
ORDERED_EVERY_S = 0.5  # at the most; orders are up to 1 s apart
TIMED_EVERY_S = 20.0  # between orders whose progress is predicted
UNTIMED = {"smart_rtl": "the way back along the flown path is not timed"}
RETURN = "rtl"
HOLD = "hold"


class ContingencyConflict(NamedTuple):
    """A contingency of `pair[0]`, ordered from `from_s` to `to_s` after the start of all, may meet `pair[1]`."""

    pair: tuple[str, str]
    contingency: str
    from_s: float
    to_s: float
    place: Vector  # (3,) east, north, up [m]
    distance: float


class UnknownContingency(NamedTuple):
    """A contingency whose path is unknown, and why."""

    vehicle: str
    contingency: str
    why: str


@dataclass(frozen=True, eq=False)
class ContingencyPoints:
    """Points (n, 3) on the paths of one contingency in the frame of all [m].

    `order_s` (n,): when it is ordered. The vehicle may be at a point from `earliest` to `latest` (n,), which is
    infinite where it stays. All [s after the departure].
    """

    contingency: str
    places: Points
    order_s: Vector
    earliest: Vector
    latest: Vector


def contingency_conflicts(
    fleet: Fleet, departures: Sequence[PlannedDeparture], separation: float
) -> tuple[list[ContingencyConflict], list[UnknownContingency]]:
    """Return the contingencies that may meet a planned flight, and those of unknown path."""
    found = list[ContingencyConflict]()
    unknown = list[UnknownContingency]()
    for vehicle, departure in zip(fleet.vehicles, departures, strict=True):
        for points in contingency_points(vehicle, fleet.frame):
            if isinstance(points, UnknownContingency):
                unknown.append(points)
                continue
            for other in departures:
                if other is not departure:
                    found += _conflicts(points, departure, other, separation)
    return found, unknown


def contingency_points(vehicle: FleetVehicle, frame: LocalFrame) -> Iterator[ContingencyPoints | UnknownContingency]:
    """Yield the contingencies that the vehicle's failsafes order, sampled in space and time."""
    forecast = open_air(vehicle)
    model = forecast.mission.autopilot.part(FlightModel)
    for contingency in contingencies_of(forecast):
        why = UNTIMED.get(contingency)
        predict = partial(model.predict_contingency, forecast.itinerary, forecast.wind, contingency)
        try:
            contingencies = forecast.cached(Contingencies)
            why = contingencies.paths.why_unknown() if contingency == RETURN else why
            samples = contingencies.samples(contingency) if why is None else None
        except MissionError as error:
            why = str(error)
        if why is not None or samples is None:
            yield UnknownContingency(vehicle.name, contingency, str(why))
        else:
            points = _points(contingency, samples, None if contingency == HOLD else predict)
            latitude, longitude, altitude = forecast.frame.to_geodetic(points.places)
            yield replace(points, places=frame.to_local(latitude, longitude, altitude))


def open_air(vehicle: FleetVehicle) -> Forecast:
    """Return the forecast in a world without obstacles, over ground at the height of home."""
    home = vehicle.mission.home
    start = {"east": 0.0, "north": 0.0, "up": 10.0}
    place = {"latitude_deg": home.latitude_deg, "longitude_deg": home.longitude_deg, "altitude_amsl": home.altitude}
    scenario = Scenario.from_dict({"home": place, "start": start, "goal": start | {"east": 10.0}})
    return Forecast(vehicle.mission, scenario)


def _points(
    contingency: str, samples: ContingencySamples, predict: Callable[[float], Prediction] | None
) -> ContingencyPoints:
    """Return the points of all possible paths in their own frame; `predict`: the flight from an order on [s]."""
    kept = np.flatnonzero(np.diff(np.floor(samples.times / ORDERED_EVERY_S), prepend=-1.0))
    paths = [(float(samples.times[n]), _along(path)) for n in kept for path in samples.paths[n][samples.possible[n]]]
    order_s = np.concatenate([np.full(len(shares), second) for second, (_, shares) in paths])
    shares = np.concatenate([shares for _, (_, shares) in paths])
    earliest, latest = _window(None if predict is None else _progress(predict, order_s), order_s, shares)
    if contingency != RETURN:
        latest = np.where(shares == 1.0, np.inf, latest)
    return ContingencyPoints(
        contingency, np.concatenate([points for _, (points, _) in paths]), order_s, earliest, latest
    )


def _along(path: Points) -> tuple[Points, Vector]:
    """Return evenly spaced points (n, 3) of a path, and their shares of its length (n,)."""
    along = arc_lengths(path)
    shares = np.linspace(0.0, 1.0, 2 + int(along[-1] / SPACING))
    return interpolate(shares * along[-1], along, path), shares


def _window(progress: tuple[Vector, Matrix] | None, order_s: Vector, shares: Vector) -> tuple[Vector, Vector]:
    """Return from when to when the vehicle may be at `shares` (n,) of its path, ordered at `order_s` (n,) [s]."""
    if progress is None:
        return order_s, np.full(len(order_s), np.inf)
    timed_s, seconds = progress
    nearest = np.abs(timed_s[:, None] - order_s).argmin(axis=0)
    after = seconds[nearest, np.rint(shares * (seconds.shape[1] - 1)).astype(int)]
    doubt = 3.0 + 0.15 * after  # [s]
    return order_s + np.maximum(after - doubt, 0.0), order_s + after + doubt


def _progress(predict: Callable[[float], Prediction], order_s: Vector) -> tuple[Vector, Matrix] | None:
    """Return orders (m,) and when each reaches even shares of its path (m, k) [s after it]; None: not modeled."""
    even = np.linspace(0.0, 1.0, 101)
    timed_s = np.linspace(order_s[0], order_s[-1], 2 + int((order_s[-1] - order_s[0]) / TIMED_EVERY_S))
    seconds = list[Vector]()
    for second in timed_s.tolist():
        try:
            track = predict(second).track.between(second, np.inf)
        except MissionError:
            return None
        along = arc_lengths(track.points)
        seconds.append(np.interp(even, along / max(along[-1], 1e-9), track.times - second))
    return timed_s, np.array(seconds)


def _conflicts(
    points: ContingencyPoints, of: PlannedDeparture, other: PlannedDeparture, separation: float
) -> Iterator[ContingencyConflict]:
    """Yield the runs of orders after which the vehicle may come within the separation of the other's planned flight."""
    flight = other.flight
    speed = of.flight.longest_step / STEP_S
    reach = separation + SPACING / 2 + 0.5 * speed  # of orders between the sampled ones
    distances, _ = flight.tree.query(points.places, distance_upper_bound=reach)
    near = np.flatnonzero(np.isfinite(distances))
    samples = flight.tree.query_ball_point(points.places[near], reach) if len(near) else []
    begins, ends = _presence(flight, of.flight)
    later = other.second - of.second
    doubt = 2.0 * float(np.hypot(of.flight.time_deviations.max(), flight.time_deviations.max()) + 1.0)
    meets = [
        bool(np.any((begins[at] + later - doubt <= latest) & (ends[at] + later + doubt >= earliest)))
        for at, earliest, latest in zip(samples, points.earliest[near], points.latest[near], strict=True)
    ]
    met = near[np.array(meets, dtype=bool)]
    orders, of_points = np.unique(points.order_s, return_inverse=True)
    ordered = of_points[met]
    numbers = np.unique(ordered)
    for run in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1):
        if len(run) > 0:
            of_run = met[np.isin(ordered, run)]
            nearest = of_run[np.argmin(distances[of_run])]
            begin, end = (float(orders[n]) + of.second for n in (run[0], run[-1]))
            pair = (of.flight.name, flight.name)
            place = points.places[nearest]
            yield ContingencyConflict(pair, points.contingency, begin, end, place, float(distances[nearest]))


def _presence(flight: TimedFlight, by: TimedFlight) -> tuple[Vector, Vector]:
    """Return from when to when a vehicle is at each sample (n,) [s]: on its own pads before and after the flight."""
    begins = STEP_S * np.arange(-1.0, len(flight.places) - 1)
    ends = begins + 2 * STEP_S
    pads = by.places[[0, -1]]
    if not within_pad(pads - flight.places[0]).any():
        begins[0] = -np.inf
    if not within_pad(pads - flight.places[-1]).any():
        ends[-1] = np.inf
    return np.asarray(begins), np.asarray(ends)
