"""The quickest waypoints on a curve that real autopilots flew, cut in ten ways (tests/data/flights/ways_*)."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.forecast.timing.track import thinned
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.planning.planner import Plan, plan_path
from ipoa_mission.planning.problem import curve_cost
from ipoa_mission.planning.proof import prove, prove_curve
from ipoa_mission.planning.spline import Spline, basis
from ipoa_mission.routing.assemble import choose_route
from ipoa_mission.routing.build import build_mission, draft_mission
from ipoa_mission.routing.resample import Route, strays
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.simulator.fly import fly_built_in as fly_here
from tests.examples import some, vehicles
from tests.least_time import PathLimits, least_time
from tests.quick_search import QUICK

FLIGHTS = Path(__file__).parent.parent / "data" / "flights"
#: Best flown on this curve, from take-off done to the last waypoint [s], and its distance [m].
BEST_FLOWN = {Autopilot.ARDUPILOT: 46.8, Autopilot.PX4: 55.7}
WITHIN = 4.0
#: Greatest ratio to the least time on the curve.
#: Greatest acceleration across the path over that along it.
ACROSS = {Autopilot.ARDUPILOT: 2.0, Autopilot.PX4: 1.0}
RATIO = {Autopilot.ARDUPILOT: 1.25, Autopilot.PX4: 1.35}


@cache
def curve_of_the_ways(autopilot: Autopilot) -> tuple[Spline, Scenario]:
    """The curve behind waypoints every five meters, and a scenario with nothing in the way."""
    mission = read_mission(FLIGHTS / f"ways_even5-{autopilot}" / "mission.waypoints", autopilot)
    flown = [item for item in mission.items if item.command == Command.NAV_WAYPOINT]
    latitude, longitude, height = (
        np.array([getattr(item, name) for item in flown]) for name in ("latitude_deg", "longitude_deg", "altitude")
    )
    points = LocalFrame(mission.home).to_local(latitude, longitude, mission.home.altitude + height)
    traveled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    control = np.linalg.lstsq(basis(36, traveled / traveled[-1]), points, rcond=None)[0]
    control[[0, -1]] = points[[0, -1]]
    speed = next(item.params[1] for item in mission.items if item.command == Command.DO_CHANGE_SPEED)
    start, goal = (f"{{ east = {p[0]}, north = {p[1]}, up = {p[2]} }}" for p in points[[0, -1]])
    at, flown_on = mission.home, ', firmware_version = "1.17"' if autopilot is Autopilot.PX4 else ""
    text = f"""
    home = {{ latitude_deg = {at.latitude_deg}, longitude_deg = {at.longitude_deg}, altitude_amsl = {at.altitude} }}
    start = {start}
    goal = {goal}
    bounds = {{ margin = 300 }}
    vehicle = {{ autopilot = "{autopilot}", cruise_speed = {speed}{flown_on} }}
    route = {{ tolerance = {WITHIN} }}
    """
    curve = Spline(np.asarray(control, float))
    assert np.abs(curve.points(traveled / traveled[-1]) - points).max() < 0.02
    return curve, parse_scenario(text, Path("ways.toml"))


def as_plan(curve: Spline, scenario: Scenario) -> Plan:
    nothing = np.zeros(1)
    return Plan(
        curve, curve_cost(curve, scenario), prove_curve(curve, scenario), "none", 0, nothing.astype(int), nothing
    )


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.PX4))
def test_fastest_mode_is_listed_first_and_no_slower_than_flown(autopilot: Autopilot) -> None:
    curve, scenario = curve_of_the_ways(autopilot)
    plan = as_plan(curve, scenario)
    modes = ["even", "corridor", "fastest", *(["spline"] if autopilot is Autopilot.ARDUPILOT else [])]
    chosen = {mode: choose_route(plan, scenario, mode) for mode in modes}
    flown = chosen["fastest"].prediction
    assert flown.seconds == min(attempt.prediction.seconds for attempt in chosen.values())
    motion = autopilot.part(FlightModel).kinematics(
        scenario.vehicle.autopilot_parameters(), scenario.vehicle.cruise_speed
    )
    limits = PathLimits(*motion, across=ACROSS[autopilot] * motion.accel)
    assert 1.0 <= flown.seconds / least_time(curve.sample(500), limits).seconds <= RATIO[autopilot]
    assert chosen["even"].prediction.seconds > 1.5 * flown.seconds  # dense straight waypoints make the vehicle crawl
    assert flown.seconds <= BEST_FLOWN[autopilot]
    assert not strays(flown.path, curve, WITHIN)
    assert flown.keeps_limits
    assert prove(chosen["fastest"].route.points, scenario).is_proved


@pytest.mark.parametrize(
    ("autopilot", "seed"), some(1, [(Autopilot.PX4, 3), (Autopilot.ARDUPILOT, 1), (Autopilot.ARDUPILOT, 2)])
)
def test_among_random_towers_the_predicted_path_keeps_its_distance(autopilot: Autopilot, seed: int) -> None:
    """Measured here, from every place of the predicted path."""
    rng = np.random.default_rng(seed)
    curve, free = curve_of_the_ways(autopilot)
    at = np.sort(rng.uniform(0.1, 0.9, 5))
    along = curve.points(at, order=1)[:, :2]
    aside = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    centers = curve.points(at)[:, :2] + aside * rng.choice([-1, 1], 5)[:, None] * rng.uniform(6.5, 9.0, 5)[:, None]
    away = np.linalg.norm(centers[:, None] - curve.sample(500)[None, :, :2], axis=2).min(axis=1)
    centers = centers[away > 6.0]  # the curve itself must be clear
    towers = tuple(
        {"kind": "cylinder", "name": f"tower {n}", "east": e, "north": north, "radius": 2.0, "height": 90.0}
        for n, (e, north) in enumerate(centers)
    )
    scenario = Scenario.model_validate(free.model_dump(exclude_unset=True) | {"obstacles": towers})
    flown = choose_route(as_plan(curve, scenario), scenario, "fastest").prediction
    required = scenario.vehicle.radius + scenario.safety_distance
    legs = np.linspace(flown.path[:-1], flown.path[1:], 8).reshape(-1, 3)[:, None, :2]
    assert np.linalg.norm(legs - centers[None], axis=2).min() - 2.0 > required - 0.05
    assert not strays(flown.path, curve, WITHIN)


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_fastest_route_is_flown_clear_to_its_goal(autopilot: Autopilot) -> None:
    """It has another model of the vehicle."""
    curve, free = curve_of_the_ways(autopilot)
    inside = curve.points(np.array([0.5, 0.75]), order=2)[:, :2]
    at = curve.points(np.array([0.5, 0.75]))[:, :2] + 6.0 * inside / np.linalg.norm(inside, axis=1)[:, None]
    towers = tuple(
        {"kind": "cylinder", "name": f"tower {n}", "east": e, "north": north, "radius": 2.0, "height": 90.0}
        for n, (e, north) in enumerate(at)
    )
    scenario = Scenario.model_validate(free.model_dump(exclude_unset=True) | {"obstacles": towers})
    chosen = choose_route(as_plan(curve, scenario), scenario, "fastest")
    route, predicted = chosen.route, chosen.prediction
    assert prove(route.points, scenario).is_proved
    assert prove(route.points, scenario).clearance.what in {"tower 0", "tower 1"}
    assert predicted.keeps_limits
    flight = fly_here(build_mission(route, scenario))
    names = ("latitude_deg", "longitude_deg", "altitude")
    path = scenario.frame.to_local(*(np.array([getattr(sample, name) for sample in flight.path]) for name in names))
    times = np.array([sample.time_s for sample in flight.path])
    begun, ended = flight.item_reached_s[0], flight.item_reached_s[len(route.points)]
    assert ended - begun == pytest.approx(predicted.seconds, rel=0.03)
    between, after = path[(times >= begun) & (times <= ended)], path[(times > ended - 5) & (times < ended + 5)]
    assert cKDTree(curve.sample(2000)).query(between)[0].max() <= WITHIN
    assert scenario.airspace.obstacle_distance(path[times < ended + 5]).min() >= (
        scenario.vehicle.radius + scenario.safety_distance
    )
    arriving = curve.points(np.array([1.0]), order=1)[0, :2]
    assert ((after - route.points[-1])[:, :2] @ arriving).max() / np.linalg.norm(arriving) < 1.0


def test_a_thinned_path_keeps_its_bends_from_above_and_from_the_side() -> None:
    along = np.linspace(0.0, 200.0, 900)
    path = np.column_stack([along, 6.0 * np.sin(along / 20) * (along > 100), 30.0 + 8.0 * np.sin(along / 9)])
    few = thinned(path, 0.05)
    assert len(few) < 200
    ends, ways = few[:-1, None], np.diff(few, axis=0)[:, None]
    share = np.clip(((path - ends) * ways).sum(axis=2) / (ways**2).sum(axis=2), 0, 1)[..., None]
    assert np.linalg.norm(ends + share * ways - path, axis=2).min(axis=0).max() < 0.08


@pytest.mark.parametrize("legs", [1, 2, 3, 4, 5])
def test_a_thinned_path_that_climbs_to_and_fro_over_itself_is_not_folded(legs: int) -> None:
    along = np.linspace(0.0, legs, 100 * legs + 1)
    path = np.column_stack([50.0 * np.abs((along + 1.0) % 2.0 - 1.0), np.zeros(len(along)), 10.0 * along])
    few = thinned(path)
    ends, ways = few[:-1, None], np.diff(few, axis=0)[:, None]
    share = np.clip(((path - ends) * ways).sum(axis=2) / (ways**2).sum(axis=2), 0, 1)[..., None]
    assert np.linalg.norm(ends + share * ways - path, axis=2).min(axis=0).max() < 0.04


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.PX4))
def test_a_way_to_a_via_point_and_back_is_flown(autopilot: Autopilot) -> None:
    """Out 60 m and back to 3 m beside the start."""
    text = f"""
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 20.0 }}
    via = [{{ east = 60.0, north = 0.0, up = 20.0 }}]
    goal = {{ east = 0.0, north = 3.0, up = 20.0 }}
    vehicle = {{ autopilot = "{autopilot}" }}
    """
    scenario = parse_scenario(text, Path("spur.toml"))
    plan = plan_path(scenario, strategy=QUICK)
    modes = ["even", "corridor", "fastest", *(["spline"] if autopilot is Autopilot.ARDUPILOT else [])]
    chosen = {mode: choose_route(plan, scenario, mode) for mode in modes}
    for attempt in chosen.values():
        assert np.linalg.norm(attempt.route.points - (60.0, 0.0, 20.0), axis=1).min() < 0.1
        assert np.linalg.norm(attempt.prediction.path - (60.0, 0.0, 20.0), axis=1).min() < 3.0
    assert chosen["fastest"].prediction.seconds == min(attempt.prediction.seconds for attempt in chosen.values())


def test_over_a_hill_no_waypoint_every_few_meters_is_needed() -> None:
    """A curve just above the deviation bound over a round hill."""
    along = np.arange(-60.0, 361.0, 20.0)
    hill = np.round(40 * np.exp(-(((along - 150) / 60) ** 2)), 2)
    text = f"""
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, height_above_ground = 14.0 }}
    goal = {{ east = 300.0, north = 0.0, height_above_ground = 14.0 }}
    terrain = {{ kind = "grid", east = -60, north = -60, spacing = 20, heights = {[hill.tolist()] * 7} }}
    bounds = {{ east = [-50, 350], north = [-50, 50], up = [-5, 120] }}
    planning = {{ min_height_above_ground = 12.0 }}
    vehicle = {{ autopilot = "ardupilot" }}
    """
    scenario = parse_scenario(text, Path("hill.toml"))
    over = np.interp(np.linspace(0, 300, 1500), along, hill)
    at = np.linspace(0.0, 1.0, 1500)
    points = np.column_stack([300 * at, 0 * at, 12.7 + over])
    curve = Spline(np.asarray(np.linalg.lstsq(basis(60, at), points, rcond=None)[0], float))
    chosen = choose_route(as_plan(curve, scenario), scenario, "fastest")
    assert len(chosen.route.points) <= 8
    assert chosen.prediction.keeps_limits


def test_a_spline_route_stops_at_a_waypoint_at_a_hairpin() -> None:
    """ArduCopter 4.8.0-dev: 0.1 m off the forecast there, 1.4 to 1.8 m at a held spline."""
    _, scenario = curve_of_the_ways(Autopilot.ARDUPILOT)
    begin = scenario.start_point
    points = begin + np.array([(0, 0, 0), (20, 0, 0), (40, 0, 0), (20, 1, 0), (0, 2, 0), (-20, 2, 0)], dtype=float)
    mission = draft_mission(Route(points, spline=True), scenario)
    ways = [(item.command, item.params[0]) for item in mission.items if item.command in WAYPOINTS][-5:]
    spline, plain = (Command.NAV_SPLINE_WAYPOINT, 0.0), (Command.NAV_WAYPOINT, 0.0)
    assert ways == [spline, (Command.NAV_WAYPOINT, 1.0), spline, spline, plain]


def test_a_route_of_unknown_path_is_never_chosen() -> None:
    """The quickest route stopped on too short a spline, and the plan was refused for its unknown clearance."""
    text = """
    home = { latitude_deg = 46.9232, longitude_deg = 10.5127, altitude_amsl = 1050.0 }
    safety_distance = 2.0
    start = { east = 0.0, north = 0.0, up = 9.0 }
    goal = { east = 175.4, north = 15.8, up = 9.0 }
    bounds = { margin = 100 }
    vehicle = { autopilot = "ardupilot", radius = 0.5, cruise_speed = 8.8 }
    [[obstacles]]
    kind = "box"
    name = "west"
    east = 53.8
    north = -2.1
    width = 10.7
    depth = 7.5
    height = 6.8
    heading_deg = 79
    [[obstacles]]
    kind = "box"
    name = "east"
    east = 149.4
    north = 13.9
    width = 10.2
    depth = 10.4
    height = 7.3
    heading_deg = 58.7
    """
    scenario = parse_scenario(text, Path("two-houses.toml"))
    assert plan_flight(scenario).forecast.unknown == ()
