"""A route flown by the time model, from over the start to its last waypoint: how long it takes, and where it leads."""

from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.items import Mission
from ipoa_mission.planning.proof import prove
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.build import draft_mission, starts_over_home
from ipoa_mission.routing.resample import deviation
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.estimate import in_local_frame, predict
from ipoa_mission.timing.prediction import Track
from ipoa_mission.timing.route import kinematics
from ipoa_mission.tube.course import course_of
from ipoa_mission.tube.promise import tube_holds
from ipoa_mission.tube.thin import STRAY, thinned
from ipoa_mission.vehicles.autopilot import Autopilot

_LAST_FLIGHT: WeakKeyDictionary[Route, "tuple[Spline, Scenario, Flown]"] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Flown:
    """A route along `curve` as the time model flies it: seconds, and its track until the vehicle could stand.

    `overrun`: how far beyond the goal it could stand, braking as it may from where the goal counts as reached [m].
    `late` are the seconds that nine flights in ten keep, and `missed` is how many waypoints a flight misses on average.
    """

    curve: Spline
    seconds: float
    track: Track
    autopilot: Autopilot
    overrun: float
    late: float
    missed: float

    @cached_property
    def path(self) -> Points:
        """Straight legs (n, 3) for the places."""
        return thinned(self.track.points, STRAY)

    @cached_property
    def deviation(self) -> float:
        """How far the path and the curve are apart [m]."""
        return deviation(self.path, self.curve)

    def slack(self, scenario: Scenario, spare: float = np.inf) -> float:
        """How much more than required the predicted path keeps, of clearance, ground and bounds the least [m].

        `spare` as for `prove`.
        """
        checks = prove(self.path, scenario, spare=spare).checks
        return min(c.slack for c in checks if c.limit in ("obstacles", "ground", "ceiling", "bounds"))

    def keeps_limits(self, scenario: Scenario) -> bool:
        """Whether the predicted path keeps clearance, ground and bounds, and the tube round it as often as it must."""
        return tube_holds(course_of(self.track), self.autopilot, scenario)


def fly(route: Route, curve: Spline, scenario: Scenario) -> Flown:
    """A route as `estimate` has its whole mission; the last flight of a route is kept as long as the route is."""
    if (kept := _LAST_FLIGHT.get(route)) is not None and kept[0] is curve and kept[1] is scenario:
        return kept[2]
    flown = _flown(draft_mission(route, scenario), route, curve, scenario, sure=False)
    _LAST_FLIGHT[route] = curve, scenario, flown
    return flown


def sketch(route: Route, curve: Spline, scenario: Scenario) -> Flown:
    """The same by a vehicle that knows where it is, and no farther than the goal: for PX4, whose flights are noisy,
    in a small part of the time. The path is the same; the noise adds some seconds.
    """
    mission = draft_mission(route, scenario)
    return _flown(replace(mission, items=mission.items[:-1]), route, curve, scenario, sure=True)


def flies_safely(route: Route, curve: Spline, scenario: Scenario) -> bool:
    """Whether the flights of a route keep every limit as often as the scenario asks."""
    return sketch(route, curve, scenario).keeps_limits(scenario)


def _flown(mission: Mission, route: Route, curve: Spline, scenario: Scenario, sure: bool) -> Flown:
    _, prediction = predict(mission, scenario.wind.air(), fast=True, sure=sure)
    first = 0 if starts_over_home(route) else 2  # the take-off, a change of speed, the start
    last = len(route.points) if first == 0 else len(route.points) + 1
    begin, end = float(prediction.done[first]), float(prediction.done[last])
    track = in_local_frame(prediction.track)
    during = (track.times >= begin) & (track.times <= end)
    path, times = track.points[during], track.times[during]
    motion = _motion(track, end)
    stand = path[-1] + motion * float(np.linalg.norm(motion)) / (
        2 * kinematics(mission.autopilot, mission.parameters).accel
    )
    ahead = motion / max(float(np.linalg.norm(motion)), 1e-9)
    overrun = float((stand - route.points[-1]) @ ahead)
    braking = 2 * float(np.linalg.norm(stand - path[-1])) / max(float(np.linalg.norm(motion)), 1e-3)
    until = Track(np.append(times, times[-1] + braking), np.vstack([path, stand]), np.append(track.speeds[during], 0.0))
    late, missed = (
        float(prediction.high[last]) - begin,
        sum(risk.share for risk in prediction.missed[first + 1 : last + 1]),
    )
    return Flown(curve, end - begin, until, mission.autopilot, overrun, late, missed)


def _motion(track: Track, end: float) -> Vector:
    """The velocity (3,) [m/s] with which a time is come to."""
    last = max(int(np.searchsorted(track.times, end, side="right")) - 1, 1)
    way = track.points[last] - track.points[last - 1]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9) * track.speeds[last])
