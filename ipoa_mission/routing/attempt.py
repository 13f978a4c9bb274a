"""A route along a plan: its mission, forecast, proof and margins."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ipoa_mission.forecast.contingency.shortfalls import Shortfall
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, deviation_bound_holds
from ipoa_mission.forecast.deviation.kept_limits import clearance_task
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import join
from ipoa_mission.forecast.timing.flight_model import FlightModel, Prediction
from ipoa_mission.forecast.timing.track import Track, pieces_of, thinned
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.planner import Plan
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.routing.build import build_mission, draft_mission, items_of_waypoints
from ipoa_mission.routing.planned_returns import choose_returns
from ipoa_mission.routing.resample import Route, strays
from ipoa_mission.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Attempt:
    """States: the `draft`, the `built` mission, and the `forecast` with chosen returns."""

    plan: Plan
    route: Route
    scenario: Scenario

    def along(self, points: Points) -> "Attempt":
        return Attempt(self.plan, replace(self.route, points=points), self.scenario)

    @cached_property
    def draft(self) -> Forecast:
        return Forecast(draft_mission(self.route, self.scenario), self.scenario)

    @cached_property
    def built(self) -> Forecast:
        """Forecast the whole mission; raises NoRoute, Unsafe or BadInput, as `build_mission`."""
        built = build_mission(self.route, self.scenario)
        return self.draft if built == self.draft.mission else Forecast(built, self.scenario)

    @cached_property
    def _with_returns(self) -> tuple[Forecast, tuple[Shortfall, ...]]:
        if self.scenario.safety.returns != "planned" or not self.is_guaranteed:
            return self.built, ()
        return choose_returns(self.built)

    @property
    def forecast(self) -> Forecast:
        return self._with_returns[0]

    @property
    def short(self) -> tuple[Shortfall, ...]:
        return self._with_returns[1]

    @property
    def guarantee(self) -> ClearanceGuarantee:
        return self.forecast.guarantee

    @property
    def is_guaranteed(self) -> bool:
        return not self.built.guarantee.forbidding

    @property
    def is_acceptable(self) -> bool:
        return self.is_guaranteed and not self.short and not self.guarantee.forbidding

    @property
    def slack(self) -> float:
        """Return the least margin over all limits and planned contingencies [m]."""
        kept = min((kept.slack for kept in self.guarantee.limits if kept.in_cruise), default=0.0)
        return min([kept, *(-one.missing for one in self.short)])

    @property
    def merit(self) -> tuple[bool, float]:
        return self.is_acceptable, self.slack

    @cached_property
    def proof(self) -> Proof:
        if not self.route.spline:
            return prove(self.route.points, self.scenario, spare=0.0)
        between = {index + 1 for index in items_of_waypoints(self.route)[1:]}
        points, chord_error = join([leg for leg in self.draft.cruise if leg.seq in between])
        return prove(points, self.scenario, chord_error, spare=0.0)

    @cached_property
    def is_fit(self) -> bool:
        quick = self.quick_prediction
        max_overrun = 0.5  # [m]
        if quick.overrun > max_overrun or strays(quick.path, self.plan.curve, self.scenario.route.tolerance):
            return False
        return self.keeps_limits

    @property
    def keeps_limits(self) -> bool:
        if self.draft.unknown:
            return False
        return self.proof.is_proved and self.quick_prediction.keeps_limits

    @cached_property
    def prediction(self) -> "RoutePrediction":
        return _predict(self, self.draft, self.draft.expected)

    @cached_property
    def quick_prediction(self) -> "RoutePrediction":
        mission = self.draft.mission_as_read
        forecast = Forecast(replace(mission, items=mission.items[:-1]), self.scenario)
        return _predict(self, forecast, forecast.predicted(noise_free=True))


@dataclass(frozen=True, eq=False)
class RoutePrediction:
    """The flight of an attempt by the time model, from over the start to the last waypoint.

    It ends where the vehicle could stop, `overrun` [m] beyond the goal. `late`: 90 % quantile of the duration [s].
    `reached`: times of the waypoints (k,) [s].
    """

    attempt: Attempt
    seconds: float
    track: Track
    overrun: float
    late: float
    missed: float
    reached: Vector

    @cached_property
    def path(self) -> Points:
        return thinned(self.track.points)

    @property
    def slack(self) -> float:
        checks = prove(self.path, self.attempt.scenario).checks
        return min(c.slack for c in checks if c.limit in ("obstacles", "ground", "ceiling", "bounds"))

    @property
    def keeps_limits(self) -> bool:
        return deviation_bound_holds(pieces_of(self.track), clearance_task(self.attempt.scenario))


def _predict(attempt: Attempt, forecast: Forecast, prediction: Prediction) -> RoutePrediction:
    mission = forecast.mission_as_read
    first, *_, last = items = list(items_of_waypoints(attempt.route))
    begin, end = float(prediction.done[first]), float(prediction.done[last])
    track = prediction.track.local()
    during = track.between(begin, end)
    path, times = during.points, during.times
    motion = _motion(track, end)
    speed = float(np.linalg.norm(motion))
    limits = mission.autopilot.part(FlightModel).kinematics(mission.parameters)
    stop = path[-1] + motion * speed / (2 * limits.accel)
    overrun = float((stop - attempt.route.points[-1]) @ (motion / max(speed, 1e-9)))
    braking = 2 * float(np.linalg.norm(stop - path[-1])) / max(speed, 1e-3)
    until = Track(np.append(times, times[-1] + braking), np.vstack([path, stop]), np.append(during.speeds, 0.0))
    missed = sum(risk.share for risk in prediction.missed[first + 1 : last + 1])
    late = float(prediction.high[last]) - begin
    return RoutePrediction(attempt, end - begin, until, overrun, late, missed, prediction.done[items])


def _motion(track: Track, end: float) -> Vector:
    last = max(int(np.searchsorted(track.times, end, side="right")) - 1, 1)
    way = track.points[last] - track.points[last - 1]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9) * track.speeds[last])
