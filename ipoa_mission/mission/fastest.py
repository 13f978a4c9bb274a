"""The quickest waypoints along a curve for the autopilot that will fly them.

The same curve may take 47 or 208 s, depending only on how it is cut into waypoints. Candidates of every density are
flown by the time model; what leaves the corridor or comes too close on the *predicted* path, corners cut and overshot,
is out. The best is then improved waypoint by waypoint.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely

from ipoa_mission.geometry import Points, leg_lengths
from ipoa_mission.mission.build import draft_mission, starts_over_home
from ipoa_mission.mission.items import FLOWN_TO
from ipoa_mission.mission.prove_route import prove_route
from ipoa_mission.mission.resample import corridor, deviation, every
from ipoa_mission.mission.route import Route, push_clear
from ipoa_mission.planning.proof import prove
from ipoa_mission.planning.spline import Spline
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.estimate import estimate
from ipoa_mission.vehicle import Autopilot

SHARES = (1.0, 0.6, 0.3, 0.1)  # of the tolerance, that straight legs may leave the curve by
ASIDE = 0.6  # of that, by which a waypoint may lie beside the curve
SPLINE_SPACINGS = (60.0, 40.0, 25.0, 18.0, 12.0)  # [m]
TRIALS = 80  # of leaving a waypoint out or moving it
STEPS = (0.5, 0.2)  # of the tolerance, that a waypoint is moved by
WORTH_IT = 0.02  # a change must save so much [s]
VISITED = 0.5  # a waypoint so near stands for a via point [m]
STRAY = 0.02  # how far the thinned path may be from the predicted one [m]


@dataclass(frozen=True, eq=False)
class Flown:
    """A route as the time model flies it from start to goal: time [s], path (n, 3), how far it leaves the curve [m]."""

    seconds: float
    path: Points
    deviation: float

    def keeps_limits(self, scenario: Scenario) -> bool:
        """Whether the predicted path keeps clearance, ground and bounds."""
        checks = prove(self.path, scenario).checks
        return all(c.slack >= -2 * STRAY for c in checks if c.limit in ("obstacles", "ground", "ceiling", "bounds"))


def fastest_route(curve: Spline, scenario: Scenario, fallback: Route) -> Route:
    """The quickest route found whose predicted path stays within `route.tolerance` of the curve and keeps every limit.

    `fallback` is returned when none is both.
    """
    best, best_s = fallback, np.inf
    for candidate in _candidates(curve, scenario):
        cleared = replace(candidate, points=push_clear(candidate.points, scenario))
        seconds = _judge(cleared, curve, scenario, best_s)
        if seconds < best_s:
            best, best_s = cleared, seconds
    if best.spline or not np.isfinite(best_s):
        return best
    return _improve(best, best_s, curve, scenario)


def fly(route: Route, curve: Spline, scenario: Scenario) -> Flown:
    """A route as the time model flies it, from over the start to the last waypoint."""
    mission = draft_mission(route, scenario)
    flown = estimate(mission, scenario.vehicle.autopilot_parameters(), fast=True)
    done = [item.done_s for item in flown.items if item.command in FLOWN_TO]
    begin, end = done[0], done[len(route.points) - 1 if starts_over_home(route) else len(route.points)]
    inside = (flown.track.times >= begin) & (flown.track.times <= end)
    path = thinned(flown.track.points[inside], STRAY)
    return Flown(end - begin, path, deviation(path, curve))


def thinned(path: Points, stray: float) -> Points:
    """The path (n, 3) with points left out where the legs that remain pass them within about `stray` [m]."""
    if len(path) < 3:
        return path
    return np.asarray(shapely.get_coordinates(shapely.simplify(shapely.linestrings(path), stray), include_z=True))


def _candidates(curve: Spline, scenario: Scenario) -> Iterator[Route]:
    tolerance = scenario.route.tolerance
    if scenario.vehicle.autopilot is Autopilot.ARDUPILOT:
        for spacing in sorted({*SPLINE_SPACINGS, scenario.route.spacing}, reverse=True):
            if spacing < curve.length / 2:
                yield Route(every(curve, spacing, scenario.via_points), spline=True)
    for share in SHARES:
        aside = ASIDE * share * tolerance
        yield Route(corridor(curve, share * tolerance, (-aside, 0.0, aside), scenario.via_points))


def _judge(route: Route, curve: Spline, scenario: Scenario, best_s: float) -> float:
    """The time of a route [s]; infinite if it is no quicker than the best, strays, misses a limit."""
    if leg_lengths(route.points).min() < 0.1:
        return np.inf
    flown = fly(route, curve, scenario)
    if flown.seconds > best_s - WORTH_IT or flown.deviation > scenario.route.tolerance:
        return np.inf
    if not prove_route(route, scenario).holds or not flown.keeps_limits(scenario):
        return np.inf
    return flown.seconds


def _improve(route: Route, seconds: float, curve: Spline, scenario: Scenario) -> Route:
    """Leave waypoints out and move them, as long as that saves time."""
    trials = TRIALS
    for step in STEPS:
        gained = True
        while gained and trials > 0:
            gained = False
            for changed in _changes(route.points, step * scenario.route.tolerance, scenario.via_points):
                trials -= 1
                candidate = replace(route, points=changed)
                quicker = _judge(candidate, curve, scenario, seconds)
                if quicker < seconds:
                    route, seconds, gained = candidate, quicker, True
                    break
                if trials <= 0:
                    break
    return route


def _changes(points: Points, step: float, via: Points) -> Iterator[Points]:
    """The waypoints with one left out, or one moved aside or along by `step` [m]; those at via points stay."""
    free = [i for i in range(1, len(points) - 1) if (np.linalg.norm(via - points[i], axis=1) > VISITED).all()]
    for i in free:
        yield np.delete(points, i, axis=0)
    for i in free:
        ahead = points[i + 1, :2] - points[i - 1, :2]
        ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
        for move in ((-ahead[1], ahead[0], 0.0), (ahead[1], -ahead[0], 0.0), (*ahead, 0.0), (*-ahead, 0.0)):
            moved = points.copy()
            moved[i] += step * np.array(move)
            yield moved
