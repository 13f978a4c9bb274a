"""One try of a flight: a route along a plan, and all that is known of it, each worked out when it is first asked."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ipoa_mission.forecast.deviation.pieces import pieces_of
from ipoa_mission.forecast.deviation.promise import Promise, deviation_bound_holds
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import join
from ipoa_mission.forecast.shortfalls import Shortfall
from ipoa_mission.forecast.timing.route_time import kinematics
from ipoa_mission.forecast.timing.track import Track, thinned
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.routing.build import build_mission, draft_mission, items_of_waypoints
from ipoa_mission.routing.planned_returns import settled
from ipoa_mission.routing.resample import deviation
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Attempt:
    """A route along the curve of a plan, flown in the world of a scenario."""

    plan: Plan
    route: Route
    scenario: Scenario

    def along(self, points: Points) -> "Attempt":
        """The same through other waypoints (k, 3)."""
        return replace(self, route=replace(self.route, points=points))

    @cached_property
    def draft(self) -> Forecast:
        """The flight of its mission before anybody looked at the ways from home to the start and back."""
        return Forecast(draft_mission(self.route, self.scenario), self.scenario)

    @cached_property
    def whole(self) -> Forecast:
        """That of its whole mission, where it can be one: where the draft promises what it must.

        Raises:
            NoRoute, Unsafe, BadInput: as `build_mission`, of a route that may be flown otherwise.
        """
        if self.draft.promise.forbidding:
            return self.draft
        built = build_mission(self.route, self.scenario)
        return self.draft if built == self.draft.mission else Forecast(built, self.scenario)

    @cached_property
    def _settled(self) -> tuple[Forecast, tuple[Shortfall, ...]]:
        if self.scenario.safety.returns != "planned" or not self.is_promised:
            return self.whole, ()
        return settled(self.whole)

    @property
    def forecast(self) -> Forecast:
        """The same with what its endings need of the vehicle and of rally points, where they are planned."""
        return self._settled[0]

    @property
    def short(self) -> tuple[Shortfall, ...]:
        """What its endings lack all the same, where they are planned."""
        return self._settled[1]

    @property
    def promise(self) -> Promise:
        """What its flights keep."""
        return self.forecast.promise

    @property
    def is_promised(self) -> bool:
        """Whether enough flights keep every limit on the way; of its endings nothing is asked."""
        return not self.whole.promise.forbidding

    @property
    def holds(self) -> bool:
        """Whether enough flights keep every limit on the way, and every ending that is planned is clear."""
        return self.is_promised and not self.short and not self.promise.forbidding

    @property
    def slack(self) -> float:
        """How much more than required is kept on the way and by its endings, of all limits the least [m]."""
        kept = min((kept.slack for kept in self.promise.limits if kept.on_the_way), default=0.0)
        return min([kept, *(-one.missing for one in self.short)])

    @property
    def merit(self) -> tuple[bool, float]:
        """What of two attempts the better one has more of."""
        return self.holds, self.slack

    @cached_property
    def proof(self) -> Proof:
        """Whether the way between its waypoints keeps the limits, in straight legs or along its curves."""
        if not self.route.spline:
            return prove(self.route.points, self.scenario, spare=0.0)
        between = {index + 1 for index in items_of_waypoints(self.route)[1:]}
        points, stray = join([leg for leg in self.draft.cruise if leg.seq in between])
        return prove(points, self.scenario, stray, spare=0.0)

    @cached_property
    def flown(self) -> "Flown":
        """It as `estimate` has its whole mission."""
        return _flown(self, self.draft, sure=False)

    @cached_property
    def sketched(self) -> "Flown":
        """The same by a vehicle that knows where it is, and no farther than the goal: for PX4, whose flights are noisy,
        in a small part of the time. The path is the same; the noise adds some seconds.
        """
        mission = self.draft.given
        return _flown(self, Forecast(replace(mission, items=mission.items[:-1]), self.scenario), sure=True)


@dataclass(frozen=True, eq=False)
class Flown:
    """An attempt as the time model flies it, from over the start to the last waypoint: seconds, and its track until the
    vehicle could stand.

    `overrun`: how far beyond the goal it could stand, braking as it may from where the goal counts as reached [m].
    `late` are the seconds that nine flights in ten keep, and `missed` is how many waypoints a flight misses on average.
    """

    attempt: Attempt
    seconds: float
    track: Track
    overrun: float
    late: float
    missed: float

    @cached_property
    def path(self) -> Points:
        """Straight legs (n, 3) for the places."""
        return thinned(self.track.points)

    @cached_property
    def deviation(self) -> float:
        """How far the path and the planned curve are apart [m]."""
        return deviation(self.path, self.attempt.plan.curve)

    @property
    def slack(self) -> float:
        """How much more than required the predicted path keeps, of clearance, ground and bounds the least [m]."""
        checks = prove(self.path, self.attempt.scenario).checks
        return min(c.slack for c in checks if c.limit in ("obstacles", "ground", "ceiling", "bounds"))

    @property
    def keeps_limits(self) -> bool:
        """Whether the predicted path keeps clearance, ground and bounds, and the tube round it as often as it must."""
        scenario = self.attempt.scenario
        return deviation_bound_holds(pieces_of(self.track), scenario.vehicle.autopilot, scenario)


def _flown(attempt: Attempt, forecast: Forecast, sure: bool) -> Flown:
    prediction, mission = forecast.predicted(sure, fast=True), forecast.given
    first, *_, last = items_of_waypoints(attempt.route)
    begin, end = float(prediction.done[first]), float(prediction.done[last])
    track = prediction.track.local()
    during = track.between(begin, end)
    path, times = during.points, during.times
    motion = _motion(track, end)
    speed = float(np.linalg.norm(motion))
    stand = path[-1] + motion * speed / (2 * kinematics(mission.autopilot, mission.parameters).accel)
    overrun = float((stand - attempt.route.points[-1]) @ (motion / max(speed, 1e-9)))
    braking = 2 * float(np.linalg.norm(stand - path[-1])) / max(speed, 1e-3)
    until = Track(np.append(times, times[-1] + braking), np.vstack([path, stand]), np.append(during.speeds, 0.0))
    missed = sum(risk.share for risk in prediction.missed[first + 1 : last + 1])
    return Flown(attempt, end - begin, until, overrun, float(prediction.high[last]) - begin, missed)


def _motion(track: Track, end: float) -> Vector:
    """The velocity (3,) [m/s] with which a time is come to."""
    last = max(int(np.searchsorted(track.times, end, side="right")) - 1, 1)
    way = track.points[last] - track.points[last - 1]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9) * track.speeds[last])
