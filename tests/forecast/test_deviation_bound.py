import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.forecast.deviation import kept_limits
from ipoa_mission.forecast.deviation.clearance_guarantee import KeptLimit
from ipoa_mission.forecast.deviation.kept_limits import (
    NO_DEVIATION,
    Stretch,
    clearance_task,
    deviation_bound_of,
    limits_kept,
    with_margins,
)
from ipoa_mission.forecast.deviation.law import law_of, not_measured
from ipoa_mission.forecast.deviation.proximity import proximity_risks
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.track import Pieces
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.planner import Plan
from ipoa_mission.progress import silent
from ipoa_mission.routing.seek import plan_with_margins
from ipoa_mission.scenario import Scenario
from ipoa_mission.vehicles.px4_multicopter.flight_model import LAW as PX4
from ipoa_mission.wind import Wind
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere
from ipoa_mission.world.terrain import Flat
from tests.quick_search import search_quickly
from tests.refused import refuses

PASSES = list(csv.DictReader((Path(__file__).parents[1] / "data" / "passes.csv").read_text().splitlines()))
SIDES = ("east", "north", "west", "south")
AIR = Bounds((-500.0, -500.0, -10.0), (500.0, 500.0, 200.0))


def beside(autopilot: Autopilot, later: str) -> np.ndarray:
    """Return how far each recorded pass was to each side, as if straight [m]."""
    rows = [r for r in PASSES if r["autopilot"] == autopilot.name and r["on_the_way"] == "1" and r["later"] in later]
    across = np.array([float(row["across"]) for row in rows])
    sides = np.array([[float(row[side]) for side in SIDES] for row in rows])
    return np.asarray((sides / law_of(autopilot).widening(across)[:, None]).ravel())


def straight(*obstacles: Obstacle, seconds: float = 3.9, height: float = 20.0) -> tuple[Pieces, Airspace]:
    """A course east at 5 m/s, a piece every half a meter."""
    times = np.arange(0.0, seconds, 0.1)
    points = np.column_stack([5 * times, np.zeros(len(times)), np.full(len(times), height)])
    still, unbent = np.zeros(len(times)), np.zeros(len(times) - 1)
    return Pieces(times, points, still, unbent, np.zeros((len(unbent), 3))), Airspace(AIR, Flat(), obstacles)


def wall(distance: float, length: float = 100.0) -> Obstacle:
    corners = ((-length, distance), (length, distance), (length, distance + 5.0), (-length, distance + 5.0))
    return Prism("wall", corners, (), 0.0, 60.0)


@pytest.mark.parametrize("autopilot", list(registered()))
@pytest.mark.parametrize("chance", [0.1, 0.05, 0.01, 0.002])
def test_recorded_passes_go_beyond_a_quantile_no_oftener_than_it_says(autopilot: Autopilot, chance: float) -> None:
    """Four seconds have a moment's chance and one more for each decorrelation time."""
    distances, law = beside(autopilot, "01"), law_of(autopilot)
    assert len(distances) >= 600
    assert (distances > law.lateral.distance(chance)).mean() <= (1 + 4.0 / law.decorrelation_s) * chance


@pytest.mark.parametrize("autopilot", list(registered()))
def test_deviation_law_of_a_forecast_counts_gusts_as_its_clearance_does(autopilot: Autopilot) -> None:
    gusty = Wind(3.0, from_deg=270.0, spread=2.0)
    mission = Mission(Geodetic(47.4, 8.5, 488.0), (), autopilot)
    assert Forecast(mission, wind=gusty).deviation_law == law_of(autopilot, 5.0)
    assert Forecast(mission, wind=gusty).deviation_law != law_of(autopilot, 3.0)


@pytest.mark.parametrize("side", ["down", "up"])
def test_heights_of_whole_flights_keep_to_their_quantiles(side: str) -> None:
    most: dict[str, float] = {}
    for row in PASSES:
        if row["autopilot"] == "px4" and row["on_the_way"] == "1":
            most[row["flight"]] = max(most.get(row["flight"], 0.0), float(row[side]))
    quantiles = PX4.lowest if side == "down" else PX4.highest
    for chance in (0.1, 0.05, 0.01):
        assert np.mean(np.array(list(most.values())) > quantiles.distance(chance)) <= chance


def test_beside_a_wall_the_chance_is_that_of_one_side_of_a_pass() -> None:
    course, world = straight(wall(5.0))
    near = proximity_risks(course, world, PX4, 4.0)
    for kept in (3.5, 4.0, 4.5):
        assert near.chance(kept) == pytest.approx(float(PX4.lateral.chance(np.array([5.0 - kept]))[0]), rel=1e-6)
    assert near.clearance_at(0.01) == pytest.approx(5.0 - PX4.lateral.distance(0.01), abs=0.002)


@pytest.mark.parametrize(("seconds", "across", "kept"), [(3.9, 0.0, 2.83), (11.9, 0.0, 2.59), (3.9, 4.0, 2.24)])
def test_clearance_of_the_example_in_safety_md(seconds: float, across: float, kept: float) -> None:
    course, world = straight(wall(4.0), seconds=seconds)
    course = replace(course, lateral_accel=np.full(len(course.lateral_accel), across))
    assert proximity_risks(course, world, PX4, 4.0).clearance_at(0.01) == pytest.approx(kept, abs=0.006)
    assert f"{kept:.2f} m" in (Path(__file__).parents[2] / "docs" / "safety.md").read_text(encoding="utf-8")


def test_two_walls_add_up_and_two_passes_are_two_draws() -> None:
    course, world = straight(wall(5.0))
    once = proximity_risks(course, world, PX4, 4.0).chance(3.5)
    both = straight(wall(5.0), wall(-10.0))[1]
    assert proximity_risks(course, both, PX4, 4.0).chance(3.5) == pytest.approx(2 * once, rel=1e-6)
    longer = straight(seconds=7.9)[0]
    assert proximity_risks(longer, world, PX4, 4.0).chance(3.5) == pytest.approx(1 - (1 - once) ** 2, rel=1e-6)


def test_height_errors_over_a_roof_last_a_whole_flight() -> None:
    roof = Prism("hall", ((-100.0, -50.0), (5000.0, -50.0), (5000.0, 50.0), (-100.0, 50.0)), (), 0.0, 15.0)
    course, world = straight(roof)
    moment, flight = (5.0 - quantiles.distance(0.01) for quantiles in (PX4.down, PX4.lowest))
    assert proximity_risks(course, world, PX4, 3.0).clearance_at(0.01) == pytest.approx(moment, abs=0.002)
    for seconds in (399.9, 799.9):
        course = straight(seconds=seconds)[0]
        assert proximity_risks(course, world, PX4, 3.0).clearance_at(0.01) == pytest.approx(flight, abs=0.002)


def test_a_bend_widens_the_deviation_bound() -> None:
    course, world = straight(wall(5.0))
    bent = replace(course, lateral_accel=np.full(len(course.lateral_accel), PX4.doubling_acceleration))
    assert proximity_risks(bent, world, PX4, 4.0).clearance_at(0.01) == pytest.approx(
        5.0 - 2 * PX4.lateral.distance(0.01), abs=0.002
    )


@pytest.mark.parametrize("obstacle", [wall(4.0), Sphere("balloon", (8.0, 9.0, 26.0), 5.0)])
def test_kept_clearance_agrees_with_flights_drawn_from_the_law(obstacle: Obstacle) -> None:
    """Drawn flights move to one side as a whole."""
    course, world = straight(obstacle)
    rng = np.random.default_rng(7)
    size = np.array([PX4.lateral.distance(chance) for chance in rng.uniform(1e-6, 1.0, 400)])
    ends = course.points[[0, -1]]  # of a straight course
    flown = [world.obstacle_clearance(ends + np.array([0.0, moved, 0.0])).distance for moved in size]
    for chance in (0.05, 0.2):
        kept = proximity_risks(course, world, PX4, 3.0).clearance_at(chance)
        assert np.mean(np.array(flown) < kept) <= chance + 2 * np.sqrt(chance / 400)


def test_limits_lose_the_rim(scenario_of: Callable[[], Scenario]) -> None:
    scenario = scenario_of()
    path = np.array([[0.0, 0.0, 20.0], [100.0, 0.0, 20.0]])
    deviation_bound = deviation_bound_of(PX4, 0.01)
    nominal = {check.limit: check.nearest.distance for check in limits_kept(path, scenario, NO_DEVIATION)}
    kept = {check.limit: check.nearest.distance for check in limits_kept(path, scenario, deviation_bound)}
    assert kept["ground"] == pytest.approx(nominal["ground"] - deviation_bound.down)
    assert kept["ceiling"] == pytest.approx(nominal["ceiling"] + deviation_bound.up)


@pytest.mark.parametrize("name", ["mountains", "oldtown", "sitl"])
def test_limits_of_stretches_that_are_not_computed_are_no_worse(
    monkeypatch: pytest.MonkeyPatch, missions: Path, name: str
) -> None:
    scenario = read_scenario(missions / f"{name}.toml")
    planning = scenario.planning.model_copy(update={"max_height_above_ground": 60.0})
    limited = scenario.model_copy(update={"planning": planning})
    mission = read_mission(missions / f"{name}.plan")
    limits = Forecast(mission, limited).guarantee.limits
    assert {"ground", "ceiling", "bounds"} <= {kept.limit for kept in limits}

    def unknown(stretches: list[Stretch], task: PathTask) -> dict[str, np.ndarray]:
        return {"any": np.full(len(stretches), -np.inf)}

    monkeypatch.setattr(kept_limits, "least_slacks", unknown)
    assert set(Forecast(mission, limited).guarantee.limits) == set(limits)


def test_room_grows_what_is_near_but_never_over_a_given_place(scenario_of: Callable[[], Scenario]) -> None:
    scenario = scenario_of()
    enlarged = with_margins(clearance_task(scenario), 1.0)
    by = PX4.lateral.distance(0.01)
    far, near = enlarged.airspace.obstacles
    assert isinstance(far, Cylinder)
    assert isinstance(near, Cylinder)
    assert far.radius == pytest.approx(5.0 + by)
    assert near.radius < 5.0 + 1.0
    safety = scenario.safety.model_copy(update={"confidence": "nominal"})
    nominal = scenario.model_copy(update={"safety": safety})
    assert with_margins(clearance_task(nominal), 1.0) is nominal


def test_height_over_steep_ground_is_limited_by_the_given_places() -> None:
    slope = {"kind": "grid", "east": -50.0, "north": -50.0, "spacing": 200.0, "heights": [[0.0, 800.0], [0.0, 800.0]]}
    table = {
        "home": {"latitude_deg": 47.0, "longitude_deg": 8.0},
        "start": {"east": 0.0, "north": 0.0, "height_above_ground": 12.0},
        "goal": {"east": 100.0, "north": 0.0, "height_above_ground": 20.0},
        "vehicle": {"autopilot": "px4", "radius": 0.5},
        "terrain": slope,
    }
    scenario = Scenario.model_validate(table)
    least, deviation_bound = scenario.limits.height_above_ground, deviation_bound_of(PX4, 0.01)
    wanted = least + deviation_bound.down + 4.0 * deviation_bound.lateral
    assert with_margins(clearance_task(scenario), 1.0).limits.height_above_ground == pytest.approx(wanted)
    assert with_margins(clearance_task(scenario), 1.0, height_factor=0.5).limits.height_above_ground == pytest.approx(
        (least + 12.0) / 2
    )
    assert with_margins(clearance_task(scenario), 1.0, height_factor=0.1).limits.height_above_ground == pytest.approx(
        least + deviation_bound.down
    )


def test_missing_path_ends_the_search_for_more_room(
    scenario_of: Callable[[], Scenario], monkeypatch: pytest.MonkeyPatch
) -> None:
    """These poles leave no gap: the path without room is left, to name the reason."""
    sought = []

    def nowhere(task: Scenario, **_: object) -> Plan:
        sought.append(task)
        raise NoPath("closed")

    monkeypatch.setattr("ipoa_mission.routing.seek.plan_path", nowhere)
    with refuses("no-path", "", "closed"):
        plan_with_margins(scenario := scenario_of(), 0, silent)
    assert len(sought) == 2
    assert sought[-1] is scenario


@pytest.fixture
def scenario_of() -> Callable[[], Scenario]:
    def make() -> Scenario:
        pole = {"kind": "cylinder", "name": "pole", "radius": 5.0, "height": 60.0}
        return Scenario.model_validate(
            {
                "home": {"latitude_deg": 47.0, "longitude_deg": 8.0},
                "start": {"east": 0.0, "north": 0.0, "up": 20.0},
                "goal": {"east": 100.0, "north": 0.0, "up": 20.0},
                "planning": {"max_height_above_ground": 60.0},
                "vehicle": {"autopilot": "px4", "radius": 0.5},
                "obstacles": [pole | {"east": 50.0, "north": 30.0}, pole | {"east": 100.0, "north": 7.0}],
            }
        )

    return make


def test_a_spread_is_turned_round() -> None:
    for distance in (0.1, 0.7, 1.9, 4.0):
        assert PX4.lateral.distance(float(PX4.lateral.chance(np.array([distance]))[0])) == pytest.approx(distance)


def test_wind_widens_the_deviation_bound_and_chooses_the_route(
    scenario_of: Callable[[], Scenario], monkeypatch: pytest.MonkeyPatch
) -> None:
    search_quickly(monkeypatch.setattr)
    calm, windy = law_of(Autopilot.ARDUPILOT), law_of(Autopilot.ARDUPILOT, 8.0)
    assert windy.lateral.distance(0.01) == pytest.approx(calm.lateral.distance(0.01) + 0.48)
    assert (windy.down.distance(0.01), windy.up.distance(0.01)) > (calm.down.distance(0.01), calm.up.distance(0.01))
    scenario = scenario_of().model_copy(update={"obstacles": ()})
    flights = [plan_flight(scenario, wind=wind) for wind in (None, Wind(5.0, 270.0), Wind(5.0, 90.0))]
    times = [flight.estimate.route_s for flight in flights]
    assert times[1] < times[0] < times[2]  # eastwards with a west wind, and against one
    for autopilot, strongest in ((Autopilot.ARDUPILOT, 8), (Autopilot.PX4, 6)):
        assert not_measured(autopilot, strongest) is None
        words = f"up to {strongest} m/s: the clearance in 9 m/s is extrapolated"
        assert words in str(not_measured(autopilot, 9.0))
    assert plan_flight(scenario.in_wind(Wind(5.0, 270.0))).estimate.total_s == flights[1].estimate.total_s


def test_unsupported_waypoints_are_refused_before_the_deviation_bound(scenario_of: Callable[[], Scenario]) -> None:
    scenario = scenario_of()
    route = scenario.route.model_copy(update={"mode": "spline"})
    with refuses("bad-input", "route.mode"):
        plan_flight(scenario.model_copy(update={"route": route}))


@pytest.mark.parametrize(("limit", "nominal", "guaranteed"), [("ceiling", 130.0, 131.0), ("obstacles", 3.0, 2.5)])
def test_a_tight_place_forbids_what_is_predicted_beyond_its_limit(
    limit: str, nominal: float, guaranteed: float
) -> None:
    required = 120.0 if limit == "ceiling" else 4.0
    kept = KeptLimit(limit, required, nominal, guaranteed, "the ground", 3, (0.0, 0.0, 130.0), "via[2]")
    assert kept.forbids
    assert not kept._replace(nominal=required).forbids
