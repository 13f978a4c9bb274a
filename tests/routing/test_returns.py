from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely

from ipoa_mission import Forecast, plan_flight, read_mission
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.flight.flight import Flight
from ipoa_mission.forecast.contingency.contingencies import Contingencies
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import ReturnLeg
from ipoa_mission.scenario import Scenario, parse_scenario, read_scenario
from tests.examples import vehicles
from tests.quick_search import search_quickly
from tests.refused import refuses

MISSIONS = Path(__file__).parents[2] / "missions"
PLANNED = (Contingency.RTL, Contingency.HOLD, Contingency.SMART_RTL)
SLAB = 'kind = "box"\nname = "roof"\neast = 80.0\nnorth = 0.0\nbase = 40.0\nwidth = 40.0\ndepth = 40.0\nheight = 20.0'
BALLOON = 'kind = "sphere"\nname = "balloon"\neast = 50.0\nnorth = 1.0\nup = 30.0\nradius = 8.0'
WALL = 'kind = "box"\nname = "wall"\neast = 45.0\nnorth = 0.0\nwidth = 4.0\ndepth = 60.0\nheight = 90.0'


@pytest.fixture(autouse=True)
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    search_quickly(monkeypatch.setattr)


def scene(
    autopilot: Autopilot,
    *obstacles: str,
    parameters: str = "",
    top: float = 60.0,
    returns: str = "planned",
    ending: str = "land",
) -> Scenario:
    text = f"""
    safety_distance = 2.0
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 15.0 }}
    goal = {{ east = 95.0, north = 0.0, up = 15.0 }}
    bounds = {{ east = [-50.0, 150.0], north = [-80.0, 80.0], up = [-5.0, {top}] }}
    vehicle = {{ radius = 0.5, autopilot = "{autopilot}", parameters = {{ {parameters} }} }}
    route = {{ ending = "{ending}" }}
    safety = {{ returns = "{returns}" }}
    {"".join(f"[[obstacles]]{chr(10)}{body}{chr(10)}" for body in obstacles)}
    """
    return parse_scenario(text, Path("scene.toml"))


def towers(autopilot: Autopilot, seed: int) -> Scenario:
    rng = np.random.default_rng(seed)
    bodies = [
        f'kind = "box"\nname = "tower {n}"\neast = {rng.uniform(15, 80):.1f}\nnorth = {rng.uniform(-25, 25):.1f}\n'
        f"width = {rng.uniform(6, 14):.1f}\ndepth = {rng.uniform(6, 14):.1f}\nheight = {rng.uniform(10, 40):.1f}"
        for n in range(7)
    ]
    return scene(autopilot, *bodies)


def kept_by_dense_sampling(flight: Flight) -> float:
    """Return the least clearance of returns from many seconds, every few centimeters."""
    paths = Contingencies(flight.forecast).paths
    begin, end = paths.in_air
    samples = paths.at(Contingency.RTL, np.sort(np.random.default_rng(1).uniform(begin, end, 40)))
    legs = [
        np.linspace(a, b, 150) for n, k in np.argwhere(samples.possible) for a, b in pairwise(samples.paths[n, k, :5])
    ]
    return float(flight.scenario.airspace.obstacle_distance(np.vstack(legs)).min())


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.long)])
def test_among_towers_every_return_keeps_its_distance_by_another_geometry(autopilot: Autopilot, seed: int) -> None:
    flight = plan_flight(towers(autopilot, seed), seed=0)
    assert all(
        row.clear for contingency in PLANNED for row in Contingencies(flight.forecast).rows(contingency, timed=False)
    )
    assert kept_by_dense_sampling(flight) >= flight.scenario.limits.obstacle_distance
    lands = [row for row in Contingencies(flight.forecast).rows(Contingency.LAND, timed=False) if not row.clear]
    remarks = [remark for remark in flight.remarks if remark.startswith("LAND in place may")]
    assert len(remarks) == bool(lands)
    assert all(row.to in remarks[0] or "more" in remarks[0] for row in lands)


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.PX4))
def test_a_path_is_not_laid_under_what_hangs_over_it(autopilot: Autopilot) -> None:
    """Under a balloon the path is laid aside, or a low return is chosen."""
    flight = plan_flight(scene(autopilot, BALLOON), seed=0)
    assert all(row.clear for row in Contingencies(flight.forecast).rows(Contingency.RTL, timed=False))
    assert kept_by_dense_sampling(flight) >= flight.scenario.limits.obstacle_distance


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.PX4))
def test_rally_points_are_planned_where_no_altitude_in_the_bounds_helps(autopilot: Autopilot) -> None:
    flight = plan_flight(scene(autopilot, WALL, top=70.0), seed=0)
    assert 1 <= len(flight.mission.rally) <= 2
    assert any("rally points" in remark for remark in flight.remarks)
    assert all(row.clear for row in Contingencies(flight.forecast).rows(Contingency.RTL, timed=False))


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_landing_at_high_rally_points_slows_down_in_time(autopilot: Autopilot) -> None:
    table = scene(autopilot, top=90.0, ending="rtl").model_dump(mode="json", exclude_unset=True)
    table["goal"]["up"], table["via"] = 45.0, [{"east": 45.0, "north": 58.0, "up": 35.0}]
    table["fence"] = [{"inclusion": False, "polygon": [[20, 12], [20, 40], [55, 40], [55, 12]]}]
    table["terrain"] = {"kind": "grid", "east": -50.0, "north": -80.0, "spacing": 200.0, "heights": [[-12.0, 36.0]] * 2}
    flight = plan_flight(Scenario.from_dict(table), seed=0)
    assert flight.mission.rally
    assert not [finding for finding in flight.findings if finding.code == "fast-touchdown"]


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_a_way_home_that_no_altitude_clears_is_planned_as_the_way_out_is(autopilot: Autopilot) -> None:
    highest = {"px4": "RTL_RETURN_ALT = 30", "ardupilot": "RTL_ALT = 3000"}[str(autopilot)]
    flight = plan_flight(scene(autopilot, WALL, parameters=highest, top=70.0, ending="rtl"), seed=0)
    assert any("way home is planned" in remark for remark in flight.remarks)
    assert all(row.clear for row in Contingencies(flight.forecast).rows(Contingency.RTL, timed=False))
    assert flight.proof.is_proved


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.PX4))
def test_a_return_leads_round_a_fence_that_has_no_top(autopilot: Autopilot) -> None:
    """ArduPilot: "fences have no top"; its own ceiling, FENCE_ALT_MAX, is 100 m. The bounds end at 70 m."""
    text = scene(autopilot, top=70.0).model_dump(mode="json", exclude_unset=True)
    fence = {"inclusion": False, "polygon": [[40, -30], [40, 8], [75, 8], [75, -30]]}
    scenario = Scenario.from_dict(text | {"fence": [fence]})
    flight = plan_flight(scenario, seed=0)
    samples = ContingencyPaths(flight.forecast).samples(Contingency.RTL)
    keep_out = shapely.Polygon(fence["polygon"])
    for n, k in np.argwhere(samples.possible):
        path = samples.paths[n, k]
        assert not shapely.LineString(path[:, :2]).intersects(keep_out)
        assert path[:, 2].max() <= 70.0
    assert not [finding for finding in flight.findings if finding.code == "return-too-near"]


def test_no_return_is_planned_above_the_vehicle_s_own_fence() -> None:
    ceiling = "FENCE_ENABLE = 1, FENCE_ALT_MAX = 40"
    body = WALL.replace("height = 90.0", "height = 36.0")
    free, fenced = (
        plan_flight(scene(Autopilot.ARDUPILOT, body, parameters=parameters), seed=0) for parameters in ("", ceiling)
    )
    assert free.mission.parameters["RTL_ALT"] == 4000.0
    assert fenced.mission.parameters.get("RTL_ALT", 1500.0) < 3800.0  # FENCE_MARGIN is 2 m
    assert fenced.mission.rally


def test_an_unchecked_return_is_refused_where_returns_are_planned() -> None:
    with refuses("unsafe") as refused:
        plan_flight(scene(Autopilot.PX4, parameters="RTL_TYPE = 3"), seed=0)
    assert 'returns = "warn"' in str(refused.value.hint)


def test_a_return_altitude_of_the_scenario_s_own_stays() -> None:
    flight = plan_flight(scene(Autopilot.PX4, WALL, parameters="RTL_RETURN_ALT = 30", top=200.0), seed=0)
    assert flight.mission.parameters["RTL_RETURN_ALT"] == 30.0
    assert flight.mission.rally


@pytest.mark.long
def test_a_corner_with_an_obstacle_in_its_braking_path_is_moved_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    scenario = read_scenario(MISSIONS / "sitl.toml")
    vehicle = scenario.vehicle.model_copy(update={"cruise_speed": 9.0})
    fast = scenario.model_copy(update={"vehicle": vehicle, "safety_distance": 1.5})
    warned, planned = (plan_flight(replaced(fast, returns), seed=7) for returns in ("warn", "planned"))
    brakes, stays = (
        np.where(samples.possible[..., None], samples.near, np.inf)[:, :, : ReturnLeg.RETURNS].min()
        for samples in (ContingencyPaths(flight.forecast).samples(Contingency.RTL) for flight in (warned, planned))
    )
    assert brakes < warned.scenario.limits.obstacle_distance <= stays
    assert planned.estimate.total_s < 1.06 * warned.estimate.total_s


def test_machines_read_the_severity_of_a_way_home_that_is_not_clear() -> None:
    flight = plan_flight(scene(Autopilot.PX4, WALL, returns="warn"), seed=0)
    assert ("return-too-near", "warning") in [(each["code"], each["severity"]) for each in flight.summary()["findings"]]  # type: ignore[attr-defined]


def replaced(scenario: Scenario, returns: str) -> Scenario:
    return scenario.model_copy(update={"safety": scenario.safety.model_copy(update={"returns": returns})})


def test_a_refusal_names_the_return_its_obstacle_and_the_way_out() -> None:
    with refuses("no-path", "", "RTL", "of roof") as refused:
        plan_flight(scene(Autopilot.PX4, SLAB, parameters="RTL_RETURN_ALT = 55", top=200.0), seed=0)
    assert 'returns = "warn"' in str(refused.value.hint)


def test_another_return_altitude_has_the_same_flight() -> None:
    scenario, mission = read_scenario(MISSIONS / "sitl.toml"), read_mission(MISSIONS / "sitl.plan")
    raised = mission.with_parameters({"RTL_RETURN_ALT": 60.0})
    shared, alone = (Forecast(raised, scenario) for _ in range(2))
    paths = Forecast(mission, scenario).cached(ContingencyPaths).returning(shared).samples(Contingency.RTL)
    own = alone.cached(ContingencyPaths).samples(Contingency.RTL)
    assert "guarantee" in alone.__dict__
    assert "guarantee" not in shared.__dict__
    for name in ("times", "paths", "possible", "near", "which", "slack"):
        assert np.array_equal(getattr(paths, name), getattr(own, name))
