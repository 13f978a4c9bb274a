"""A route along a plan: its mission, forecast, proof and margins."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ipoa_mission.autopilot.guidance_profile import WaypointDefaults
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.contingency.shortfalls import Shortfall
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, deviation_bound_holds
from ipoa_mission.forecast.deviation.kept_limits import clearance_task
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import join
from ipoa_mission.forecast.itinerary.itinerary import MAX_TURN_DEG, turn_deg
from ipoa_mission.forecast.timing.estimate import kinematics
from ipoa_mission.forecast.timing.track import Track, pieces_of, thinned
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import (
    FenceCircle,
    FencePolygon,
    Item,
    Mission,
    change_speed,
    land,
    return_to_launch,
    spline_waypoint,
    takeoff,
    waypoint,
)
from ipoa_mission.mission.landing_ground import landing_over
from ipoa_mission.planning.planner import Plan
from ipoa_mission.planning.proof import Proof, prove
from ipoa_mission.routing.planned_returns import choose_returns
from ipoa_mission.routing.repairs import raise_way_home, slow_landings
from ipoa_mission.routing.resample import NoRoute, Route, strays
from ipoa_mission.scenario import Scenario

LEAST_TAKEOFF_HEIGHT = 2.5  # MIS_TAKEOFF_ALT of PX4 [m]
VISITED = 0.5  # [m]
OVER_HOME = 0.5  # begins with the take-off [m]


def build_mission(route: Route, scenario: Scenario) -> Mission:
    """Build the mission of a route, with the scenario's speed, ending, fence and rally points.

    It climbs over the goal if the straight way home is not clear, and slows down in time for high ground.

    Raises:
        BadInput: the start is too low for a take-off to end there.
        NoRoute: the straight way from over home to the start is not clear.
        Unsafe: it would touch down fast, and nothing helps.
    """
    _prove_departure(route.points[0], scenario)
    mission = slow_landings(raise_way_home(draft_mission(route, scenario), scenario), scenario)
    return landing_over(mission, scenario.ground)


def draft_mission(route: Route, scenario: Scenario) -> Mission:
    """Build the mission without a check of the ways from home and back.

    Raises:
        BadInput: the start is too low for a take-off to end there.
    """
    frame, home = scenario.frame, scenario.frame.home
    first, *onward = [(place, round(place.altitude - home.altitude, 3)) for place in _geodetic(route.points, frame)]
    if first[1] < LEAST_TAKEOFF_HEIGHT:
        words = f"expected {LEAST_TAKEOFF_HEIGHT} m above home or more, for the take-off, not {first[1]:.1f} m"
        raise BadInput(words, place="start")
    over_home = starts_over_home(route)
    defaults = scenario.vehicle.autopilot.waypoint_defaults(scenario.vehicle.version)
    flown_to = [
        *(_item_at(route, n, place, defaults, scenario) for n, place in enumerate(onward[:-1], 1)),
        spline_waypoint(*onward[-1]) if route.spline and route.brakes_on_curve else waypoint(*onward[-1], *defaults),
    ]
    cruise, changes = scenario.vehicle.cruise_speed, route.speed_changes
    items: list[Item] = [
        takeoff(first[0] if over_home else home, first[1]),
        change_speed(cruise),
        *([] if over_home else [waypoint(*first, *defaults)]),
    ]
    for leg, item in enumerate(flown_to):
        items += [change_speed(route.slow_speed if leg in route.slow else cruise)] if leg in changes else []
        items.append(item)
    items.append(return_to_launch() if scenario.route.ending == "rtl" else land(onward[-1][0]))
    return Mission(
        home=home,
        items=tuple(items),
        autopilot=scenario.vehicle.autopilot,
        cruise_speed=scenario.vehicle.cruise_speed,
        fence=tuple(_fences(scenario)),
        rally=_rally(scenario),
        parameters=scenario.vehicle.autopilot_parameters(),
        vehicle=scenario.vehicle.learned,
        firmware_version=scenario.vehicle.version,
        unmeasured_version=scenario.vehicle.unmeasured_version,
    )


def items_of_waypoints(route: Route) -> tuple[int, ...]:
    first = 0 if starts_over_home(route) else 2
    changes, at = np.array(route.speed_changes, dtype=int), max(first, 1) + 1
    return first, *(at + leg + int((changes <= leg).sum()) for leg in range(route.legs))


def starts_over_home(route: Route) -> bool:
    return bool(np.hypot(*route.points[0, :2]) < OVER_HOME)


def _item_at(route: Route, n: int, at: tuple[Geodetic, float], defaults: WaypointDefaults, scenario: Scenario) -> Item:
    place, height = at
    if route.spline:
        if turn_deg(*route.points[n - 1 : n + 2]) > MAX_TURN_DEG - 5.0:  # as a spline its path is unknown
            return waypoint(place, height, 1.0, defaults.radius)
        return spline_waypoint(place, height)
    via = np.linalg.norm(scenario.via_points - route.points[n], axis=1) <= VISITED
    radius = float(np.broadcast_to(route.radius, len(route.points))[n])
    return waypoint(place, height, defaults.hold, defaults.radius if via.any() or radius == 0.0 else radius)


def _prove_departure(start: Vector, scenario: Scenario) -> None:
    proof = prove(np.array([[0.0, 0.0, start[2]], start]), scenario)
    if not proof.is_proved:
        hint = "begin over home and name this place under via: then the way to it is planned too"
        words = f"the straight way from over home to it: {proof.words()}"
        raise NoRoute(words, hint=hint, code="start-not-reached", place="start")


def _geodetic(points: Points, frame: LocalFrame) -> list[Geodetic]:
    """Round to MAVLink's resolution: 1e-7 degrees and 1 mm."""
    return [
        Geodetic(round(float(lat), 7), round(float(lon), 7), round(float(alt), 3))
        for lat, lon, alt in zip(*frame.to_geodetic(points), strict=True)
    ]


def _fences(scenario: Scenario) -> Iterator[FencePolygon | FenceCircle]:
    frame = scenario.frame
    for fence in scenario.geofence:
        if fence.center is not None:
            assert fence.radius is not None
            center = _geodetic(np.array([[*fence.center.east_north(frame), 0.0]]), frame)[0]
            yield FenceCircle((center.latitude_deg, center.longitude_deg), fence.radius, fence.inclusion)
        elif fence.polygon_geodetic is not None:
            yield FencePolygon(tuple(fence.polygon_geodetic), fence.inclusion)
        else:
            places = _geodetic(np.array([(east, north, 0.0) for east, north in fence.polygon or ()]), frame)
            yield FencePolygon(tuple((place.latitude_deg, place.longitude_deg) for place in places), fence.inclusion)


def _rally(scenario: Scenario) -> tuple[Geodetic, ...]:
    frame, home = scenario.frame, scenario.frame.home
    places = map(frame.geodetic, scenario.rally_points)
    return tuple(Geodetic(p.latitude_deg, p.longitude_deg, round(p.altitude - home.altitude, 3)) for p in places)


@dataclass(frozen=True, eq=False)
class Attempt:
    """States: the `draft`, the `whole` mission, and the `forecast` with chosen returns."""

    plan: Plan
    route: Route
    scenario: Scenario

    def along(self, points: Points) -> "Attempt":
        return Attempt(self.plan, replace(self.route, points=points), self.scenario)

    @cached_property
    def draft(self) -> Forecast:
        """Forecast without the legs from and to home."""
        return Forecast(draft_mission(self.route, self.scenario), self.scenario)

    @cached_property
    def whole(self) -> Forecast:
        """Forecast the whole mission if the draft keeps its limits, else return the draft.

        Raises:
            NoRoute, Unsafe, BadInput: as `build_mission`.
        """
        if self.draft.guarantee.forbidding:
            return self.draft
        built = build_mission(self.route, self.scenario)
        return self.draft if built == self.draft.mission else Forecast(built, self.scenario)

    @cached_property
    def _with_returns(self) -> tuple[Forecast, tuple[Shortfall, ...]]:
        if self.scenario.safety.returns != "planned" or not self.is_guaranteed:
            return self.whole, ()
        return choose_returns(self.whole)

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
        return not self.whole.guarantee.forbidding

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
        points, stray = join([leg for leg in self.draft.cruise if leg.seq in between])
        return prove(points, self.scenario, stray, spare=0.0)

    @cached_property
    def is_fit(self) -> bool:
        quick = self.quick_prediction
        most_overrun = 0.5  # beyond the goal [m]
        if quick.overrun > most_overrun or strays(quick.path, self.plan.curve, self.scenario.route.tolerance):
            return False
        return self.proof.is_proved and quick.keeps_limits

    @cached_property
    def prediction(self) -> "RoutePrediction":
        return _predict(self, self.draft, noise_free=False)

    @cached_property
    def quick_prediction(self) -> "RoutePrediction":
        """Fly without noise, only to the goal."""
        mission = self.draft.mission_as_read
        return _predict(self, Forecast(replace(mission, items=mission.items[:-1]), self.scenario), noise_free=True)


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


def _predict(attempt: Attempt, forecast: Forecast, noise_free: bool) -> RoutePrediction:
    prediction, mission = forecast.predicted(noise_free, fast=True), forecast.mission_as_read
    first, *_, last = items = list(items_of_waypoints(attempt.route))
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
    late = float(prediction.high[last]) - begin
    return RoutePrediction(attempt, end - begin, until, overrun, late, missed, prediction.done[items])


def _motion(track: Track, end: float) -> Vector:
    last = max(int(np.searchsorted(track.times, end, side="right")) - 1, 1)
    way = track.points[last] - track.points[last - 1]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9) * track.speeds[last])
