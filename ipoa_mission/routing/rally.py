"""Place as few rally points as possible."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.forecast.contingency.contingency_paths import SAMPLING, ContingencyPaths
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.world.frame import Geodetic


@dataclass(frozen=True)
class RallySearch:
    """Candidate places of rally points."""

    max_points: int = 4
    place_step: float = 25.0  # along the path [m]
    lateral_distances: tuple[float, ...] = (0.0, 15.0, 30.0)  # from the path [m]
    landing_clearance: float = 2.0  # around a landing place [m]
    sample_count: int = 60
    least_separation: float = 12.0  # of home and rally points [m]: PX4 ignores those within 10 m of home


SEARCH = RallySearch()


def rally_sets(ways: ContingencyPaths) -> Iterator[tuple[Geodetic, ...]]:
    """Yield growing sets of rally points, not proved."""
    forecast = ways.forecast
    places = _with_room(ways, _places(forecast))
    if not len(places):
        return
    begin, end = ways.in_air
    times = np.linspace(begin, end, SEARCH.sample_count)
    stopped = ways.stops().at(times)[1]
    height = ways.at(Contingency.RTL, times).paths[:, 0, 3, 2]
    home = np.zeros(3)
    goals = np.vstack([home, places])
    clear = _clear(ways, stopped, height, goals)
    if forecast.mission.items[-1].command == Command.NAV_RETURN_TO_LAUNCH:
        own = int(np.searchsorted(times, forecast.promise.flight.cruise_span[1]))
        keep = clear[min(own, len(times) - 1)]
        keep[0] = True
        goals, clear = goals[keep], clear[:, keep]
    away = np.linalg.norm(stopped[:, None, :2] - goals[None, :, :2], axis=2)
    chosen = [0]
    while len(goals) > 1 and len(chosen) <= SEARCH.max_points:
        gains = [_served(clear, away, [*chosen, n]) for n in range(1, len(goals))]
        best = int(np.argmax(gains)) + 1
        if gains[best - 1] <= _served(clear, away, chosen):
            return
        chosen.append(best)
        yield tuple(_rally_point(forecast, goals[n]) for n in chosen[1:])


def _served(clear: NDArray[np.bool_], away: NDArray[np.float64], chosen: list[int]) -> int:
    """Count the instants at which all possible goals are clear."""
    near = away[:, chosen] <= away[:, chosen].min(axis=1, keepdims=True) + 2 * SAMPLING.position_error
    return int((clear[:, chosen] | ~near).all(axis=1).sum())


def _clear(ways: ContingencyPaths, stopped: Points, height: NDArray[np.float64], goals: Points) -> NDArray[np.bool_]:
    """Return whether level legs from places (n, 3) to goals (m, 3) are clear, (n, m)."""
    starts = np.repeat(np.column_stack([stopped[:, :2], height]), len(goals), axis=0)
    ends = np.column_stack([np.tile(goals[:, :2], (len(stopped), 1)), starts[:, 2]])
    near, _ = ways.roomy.airspace.legs_clearance(starts, ends, ways.required + SAMPLING.max_slack)
    return np.asarray(near >= ways.required).reshape(len(stopped), len(goals))


def _places(forecast: Forecast) -> Points:
    """Return ground places along the path (n, 3)."""
    track = forecast.promise.flight.pieces.points
    steps = np.hypot(*np.diff(track[:, :2], axis=0).T)
    traveled = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.arange(0.0, traveled[-1] + SEARCH.place_step, SEARCH.place_step)
    spots = np.column_stack([np.interp(at, traveled, track[:, k]) for k in range(2)])
    ahead = np.gradient(spots, axis=0) if len(spots) > 1 else np.zeros_like(spots)
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]]) / np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
    kept: list[np.ndarray] = [np.zeros(2)]
    for distance in SEARCH.lateral_distances:
        for sign in (1.0, -1.0) if distance else (1.0,):
            for spot in spots + sign * distance * aside:
                if min(float(np.hypot(*(spot - other))) for other in kept) >= SEARCH.least_separation:
                    kept.append(spot)
    level = np.array(kept[1:]).reshape(-1, 2)
    return np.column_stack([level, forecast.world.airspace.ground(level)])


def _with_room(ways: ContingencyPaths, places: Points) -> Points:
    if not len(places):
        return places
    air = ways.roomy.airspace
    top = np.column_stack([places[:, :2], np.full(len(places), air.bounds.upper[2])])
    near, _ = air.legs_clearance(top, places, ways.required + SEARCH.landing_clearance)
    middle = (air.bounds.lower[2] + air.bounds.upper[2]) / 2
    inside = air.bounds.margin(np.column_stack([places[:, :2], np.full(len(places), middle)]))
    return places[(near >= ways.required + SEARCH.landing_clearance) & (inside > 0.0)]


def _rally_point(forecast: Forecast, place: np.ndarray) -> Geodetic:
    there = forecast.frame.geodetic(place)
    above = round(there.altitude - forecast.mission.home.altitude, 3)
    return Geodetic(round(there.latitude_deg, 7), round(there.longitude_deg, 7), above)
