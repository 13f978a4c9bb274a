"""A route flown by the time model, from over the start to its last waypoint: how long it takes, and where it leads."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.route import kinematics
from ipoa_mission.forecast.timing.track import Track, thinned
from ipoa_mission.forecast.tube.pieces import pieces_of
from ipoa_mission.forecast.tube.promise import tube_holds
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.proof import prove
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.build import draft_mission, items_of_waypoints
from ipoa_mission.routing.resample import deviation
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario
from ipoa_mission.vehicles.autopilot import Autopilot


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
        return thinned(self.track.points)

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
        return tube_holds(pieces_of(self.track), self.autopilot, scenario)


def fly(route: Route, curve: Spline, scenario: Scenario) -> Flown:
    """A route as `estimate` has its whole mission."""
    return _flown(draft_mission(route, scenario), route, curve, scenario, sure=False)


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
    prediction = Forecast(mission, scenario).predicted(sure, fast=True)
    first, *_, last = items_of_waypoints(route)
    begin, end = float(prediction.done[first]), float(prediction.done[last])
    track = prediction.track.local()
    during = track.between(begin, end)
    path, times = during.points, during.times
    motion = _motion(track, end)
    stand = path[-1] + motion * float(np.linalg.norm(motion)) / (
        2 * kinematics(mission.autopilot, mission.parameters).accel
    )
    ahead = motion / max(float(np.linalg.norm(motion)), 1e-9)
    overrun = float((stand - route.points[-1]) @ ahead)
    braking = 2 * float(np.linalg.norm(stand - path[-1])) / max(float(np.linalg.norm(motion)), 1e-3)
    until = Track(np.append(times, times[-1] + braking), np.vstack([path, stand]), np.append(during.speeds, 0.0))
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
