from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission import Airspace, Bounds, Limits, PathProblem, plan_path
from ipoa_mission.planning.lattice import DETAILS, LatticeStrategy, lift_to_slopes
from ipoa_mission.planning.problem import prepare
from ipoa_mission.world.terrain import Grid
from tests.quick_search import QUICK

CLIMB, DESCENT = np.radians(30), np.radians(11)
STEP = 5.0  # between levels of the lattice [m]


def behind_ridges() -> PathProblem:
    """A goal so close behind a crest that the descent needs a detour."""
    east, north = np.meshgrid(*[np.linspace(-300.0, 2100.0, 49)] * 2)
    wall = 200 * np.exp(-(((east - 400) / 60) ** 2))
    crest = (260 + 60 * np.sin(east / 150)) * np.exp(-(((0.3 * east + north - 1200) / 80) ** 2))
    ground = Grid(-300.0, -300.0, 50.0, 10 + np.maximum(wall, crest))
    airspace = Airspace(Bounds((-300.0, -300.0, 0.0), (2100.0, 2100.0, 600.0)), ground, ())
    limits = Limits(obstacle_distance=5.0, height_above_ground=10.0, climb_angle=CLIMB, descent_angle=DESCENT)
    return PathProblem(airspace, limits, np.array([[0.0, 0.0, 40.0], [1200.0, 1300.0, 40.0]]))


def test_every_seed_goes_the_same_detour_down_from_a_ridge() -> None:
    coarse = replace(QUICK, lattice=LatticeStrategy(nodes=10_000))
    plans = [plan_path(behind_ridges(), seed=seed, strategy=coarse) for seed in range(2)]
    costs = [plan.cost.total for plan in plans]
    assert max(costs) <= 1.005 * min(costs)
    for plan in plans:
        assert plan.proof.is_proved
        assert plan.cost.turning_deg < 180  # a loop has 360


def test_a_lifted_way_climbs_and_descends_as_it_may_and_is_no_lower() -> None:
    problem = prepare(behind_ridges())
    start, goal = problem.task.places
    path = np.array([start, (250.0, 250.0, 60.0), (250.0, 250.0, 290.0), (450.0, 450.0, 290.0), goal])
    path[-2:, :2] = (1900.0, 600.0), (1200.0, 1300.0)
    lifted, _ = lift_to_slopes(path, problem, STEP)
    np.testing.assert_array_equal(lifted[:, :2], path[:, :2])
    np.testing.assert_array_equal(lifted[[0, -1]], path[[0, -1]])
    assert (lifted[:, 2] >= path[:, 2]).all()
    step = np.diff(lifted[1:-1], axis=0)
    level = np.hypot(step[:, 0], step[:, 1])
    assert (step[:, 2] <= DETAILS.lift_slope_share * np.tan(CLIMB) * level + 1e-9).all()
    assert (-step[:, 2] <= DETAILS.lift_slope_share * np.tan(DESCENT) * level + 1e-9).all()
    assert lifted[1, 2] == pytest.approx(290.0)  # went straight up


@pytest.mark.parametrize(("distance", "long"), [(1100.0, False), (300.0, True)])
def test_a_descent_that_is_too_short_for_its_height_needs_a_detour(distance: float, long: bool) -> None:
    problem = prepare(behind_ridges())
    start, goal = problem.task.places
    height = 250.0
    crest = np.array([goal[0] - distance, goal[1], height])
    _, detour = lift_to_slopes(np.array([start, (0.0, 700.0, height), crest, goal]), problem, STEP)
    within = distance * DETAILS.lift_slope_share
    missing = (height - goal[2]) / np.tan(DESCENT) - within
    assert detour == pytest.approx(max(missing, 0.0) / distance if long else 0.0, abs=0.02)
