import tomllib
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.optimize.search import Optimum
from ipoa_mission.paper.problems import INNER, MAPS, iterations_to_converge, map_scenario, measures_of
from ipoa_mission.planning.spline import Spline
from tools.generate.paper_maps import paper_map


@pytest.mark.parametrize("name", MAPS)
def test_the_maps_that_are_run_are_drawn_from_their_seeds(name: str, missions: Path) -> None:
    path = missions / "paper" / f"{name}.toml"
    assert tomllib.loads(path.read_text(encoding="utf-8")) == paper_map(name)
    scenario = map_scenario(name)
    assert len(scenario.airspace.obstacles) == int(name.split("-")[1])
    ends = np.vstack([scenario.start_point, scenario.goal_point])
    assert np.all(scenario.airspace.clearance(ends) > scenario.vehicle.radius)


@pytest.mark.parametrize("name", MAPS)
def test_no_map_lets_the_straight_way_pass(name: str) -> None:
    scenario = map_scenario(name)
    straight = np.linspace(scenario.start_point, scenario.goal_point, 400)
    assert scenario.airspace.clearance(straight).min() < scenario.vehicle.radius + scenario.safety_distance


def test_the_experiments_of_table_5_differ_in_their_weights() -> None:
    assert map_scenario("map-8-1") == map_scenario("map-8-1/1")
    assert map_scenario("map-8-1/3").cost.omega == (0.15, 0.15, 0.7)


def test_a_straight_climbless_path_has_no_turn_and_its_own_length() -> None:
    scenario = map_scenario("map-8-1")
    control = np.linspace([5.0, 5.0, 300.0], [95.0, 95.0, 300.0], INNER + 2)
    measures = measures_of(Spline(control), scenario)
    assert measures["distance"] == pytest.approx(90 * np.sqrt(2), abs=1e-3)
    assert measures["turn"] == pytest.approx(0, abs=1e-6)
    assert measures["feasible"] == 1
    nodes = Spline(control).points(np.linspace(0, 1, 100))
    assert measures["dis_obs"] == pytest.approx(scenario.airspace.obstacle_distance(nodes).mean() - 1, abs=1e-4)


def test_a_path_through_a_mast_is_not_collision_free() -> None:
    scenario = map_scenario("map-8-1")
    low = np.linspace([5.0, 5.0, 20.0], [95.0, 95.0, 20.0], INNER + 2)
    measures = measures_of(Spline(low), scenario)
    assert measures["feasible"] == 0
    assert isinstance(measures["clearance"], float)
    assert measures["clearance"] < 0


def test_convergence_is_when_the_cost_was_within_a_hundredth_of_its_last() -> None:
    optimum = Optimum(np.zeros(1), 100.0, np.array([30, 60, 90, 120]), np.array([500.0, 102.0, 100.5, 100.0]))
    assert iterations_to_converge(optimum) == 750
