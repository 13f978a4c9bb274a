"""Build the items of a route's mission."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ipoa_mission.autopilot.guidance_profile import WaypointDefaults
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.itinerary.itinerary import MAX_TURN_DEG, turn_deg
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
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.repairs import raise_way_home, slow_landings
from ipoa_mission.routing.resample import NoRoute, Route
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
    """Build the mission without proving the ways from home and back; raise BadInput for a low start."""
    frame = scenario.frame
    home = frame.home
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
    cruise = scenario.vehicle.cruise_speed
    changes = route.speed_changes
    items: list[Item] = [
        takeoff(first[0] if over_home else home, first[1]),
        change_speed(cruise),
        *([] if over_home else [waypoint(*first, *defaults)]),
    ]
    for leg, item in enumerate(flown_to):
        if leg in changes:
            items.append(change_speed(route.slow_speed if leg in route.slow else cruise))
        items.append(item)
    items.append(return_to_launch() if scenario.route.ending == "rtl" else land(onward[-1][0]))
    return replace(scenario.cached(_without_items), items=tuple(items))


def _without_items(scenario: Scenario) -> Mission:
    vehicle = scenario.vehicle
    return Mission(
        home=scenario.frame.home,
        items=(),
        autopilot=vehicle.autopilot,
        cruise_speed=vehicle.cruise_speed,
        fence=tuple(_fences(scenario)),
        rally=_rally(scenario),
        parameters=vehicle.autopilot_parameters(),
        vehicle=vehicle.learned,
        firmware_version=vehicle.version,
        unmeasured_version=vehicle.unmeasured_version,
    )


def items_of_waypoints(route: Route) -> tuple[int, ...]:
    """Return the index of each waypoint's item in `draft_mission`, (k,)."""
    first = 0 if starts_over_home(route) else 2
    changes = np.array(route.speed_changes, dtype=int)
    second = max(first, 1) + 1
    return first, *(second + leg + int((changes <= leg).sum()) for leg in range(route.legs))


def starts_over_home(route: Route) -> bool:
    return bool(np.hypot(*route.points[0, :2]) < OVER_HOME)


def _item_at(
    route: Route, n: int, position: tuple[Geodetic, float], defaults: WaypointDefaults, scenario: Scenario
) -> Item:
    place, height = position
    if route.spline:
        if turn_deg(*route.points[n - 1 : n + 2]) > MAX_TURN_DEG - 5.0:  # as a spline its path is unknown
            return waypoint(place, height, 1.0, defaults.radius)
        return spline_waypoint(place, height)
    is_via = (np.linalg.norm(scenario.via_points - route.points[n], axis=1) <= VISITED).any()
    radius = float(np.broadcast_to(route.radius, len(route.points))[n])
    return waypoint(place, height, defaults.hold, defaults.radius if is_via or radius == 0.0 else radius)


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
    frame = scenario.frame
    places = map(frame.geodetic, scenario.rally_points)
    return tuple(replace(place, altitude=round(place.altitude - frame.home.altitude, 3)) for place in places)
