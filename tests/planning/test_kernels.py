import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ipoa_mission.geometry import climb_angles, turning_angles
from ipoa_mission.planning.obstacle_grid import Nodes, Smoothing, obstacle_grid_of
from ipoa_mission.planning.polish import _node_basis
from ipoa_mission.planning.problem import PreparedProblem, prepare
from ipoa_mission.planning.spline import even_basis
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.polygon import Polygon
from tests.examples import some
from tests.planning import twins
from tests.planning.conftest import Make

Town = Callable[[int], Scenario]
SMOOTHING = Smoothing(
    bend=0.02, reach=0.4, barrier=0.1, stiffness=10.0, evenness=0.05, aside=0.1, above=0.2, flatter=0.01
)
LIMITLESS: dict[str, Any] = {"ceiling": 1e9, "climb_slope": 1e9, "descent_slope": 1e9}


def curves(seed: int, count: int, control: int = 9) -> np.ndarray:
    """Rough ways across the town, (count, control, 3); some leave the bounds."""
    rng = np.random.default_rng(seed)
    line = np.linspace((0.0, 0.0, 4.0), (100.0, 0.0, 30.0), control)
    bulge = np.sin(np.linspace(0, np.pi, control))[:, None]
    offsets = rng.normal(size=(count, control, 3)) * (4, 6, 3) + rng.uniform((0, -40, 10), (1, 40, 40), (count, 1, 3))
    return line + bulge * offsets * rng.uniform(0, 1.5, (count, 1, 1))


def fenced(problem: PreparedProblem) -> tuple[Airspace, PreparedProblem]:
    """The same problem inside a flight area with a bay."""
    area = Polygon(((-45.0, -95.0), (145.0, -80.0), (140.0, 90.0), (60.0, 30.0), (-40.0, 95.0)))
    airspace = problem.task.airspace
    airspace = Airspace(replace(airspace.bounds, footprint=area), airspace.terrain, airspace.obstacles)
    return airspace, replace(problem, grid=obstacle_grid_of(airspace, problem.limits, problem.grid.reach))


@pytest.mark.parametrize("per_node", [False, True])
@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("fence", some(1, [True, False]))
def test_path_costs_are_those_of_the_twin(town: Town, per_node: bool, limited: bool, fence: bool) -> None:
    from ipoa_mission.planning._kernels import path_costs

    feasible = 0
    for seed in range(8):
        problem = prepare(town(seed))
        airspace, problem = fenced(problem) if fence else (problem.task.airspace, problem)
        rules = problem.rules._replace(per_node=per_node)
        rules = rules if limited else rules._replace(clearance=0.1, height=0.1, **LIMITLESS)
        limits = problem.limits if limited else replace(problem.limits, height_above_ground=0.1, low_zones=())
        grid = obstacle_grid_of(airspace, limits, problem.grid.reach)
        paths = np.ascontiguousarray((even_basis(9, 100) @ curves(seed, 30)).transpose(0, 2, 1))
        costs, expected = path_costs(paths, grid, rules), twins.path_costs(paths, airspace, rules, limits)
        np.testing.assert_allclose(costs, expected, rtol=1e-7)
        feasible += (expected < rules.collision).sum()
    assert (feasible > 20) != limited  # with limits next to nothing keeps them


def model(
    problem: PreparedProblem, control: np.ndarray, smoothing: Smoothing = SMOOTHING, mean_leg: float | None = None
) -> tuple[float, np.ndarray, np.ndarray]:
    from ipoa_mission.planning._path_model import gradient_and_hessian, path_model

    n = len(control)
    nodes = even_basis(n, 60) @ control
    mean_leg = float(np.linalg.norm(np.diff(nodes, axis=0), axis=1).mean()) if mean_leg is None else mean_leg
    signs = np.random.default_rng(0).uniform(-1, 1, (60, 2))
    at_nodes = path_model(nodes, problem.grid, problem.rules, smoothing, mean_leg, signs)
    gradient, band = gradient_and_hessian(at_nodes, _node_basis(n, 60), n)
    turns = np.column_stack([turning_angles(nodes), np.abs(np.diff(climb_angles(nodes)))])
    np.testing.assert_allclose(np.abs(at_nodes.bends.angles[1:-1]), turns, atol=1e-7)
    lower = sum(np.diag(row[: len(row) - k], -k) for k, row in enumerate(band))
    return at_nodes.value, gradient, lower + np.tril(lower, -1).T


def value(problem: PreparedProblem, airspace: Airspace, control: np.ndarray, mean_leg: float) -> float:
    spots = even_basis(len(control), 60) @ control
    return twins.path_model(spots, airspace, problem.rules, problem.limits, SMOOTHING, mean_leg)


@pytest.mark.parametrize("per_node", [False, True])
@pytest.mark.parametrize("fence", some(1, [True, False]))
def test_the_model_has_the_value_of_the_twin_and_its_derivative(town: Town, fence: bool, per_node: bool) -> None:
    for seed in range(2):
        problem = prepare(town(seed))
        airspace, problem = fenced(problem) if fence else (problem.task.airspace, problem)
        problem = replace(problem, rules=problem.rules._replace(per_node=per_node))
        for control in curves(seed, 2):
            spots = even_basis(9, 60) @ control
            mean_leg = float(np.linalg.norm(np.diff(spots, axis=0), axis=1).mean())
            cost, gradient, hessian = model(problem, control)
            assert cost == pytest.approx(value(problem, airspace, control, mean_leg), rel=1e-7)
            nudges = 1e-6 * np.eye(27).reshape(27, 9, 3)
            ahead, behind = (
                np.array([value(problem, airspace, control + sign * nudge, mean_leg) for nudge in nudges])
                for sign in (1, -1)
            )
            slope = (ahead - behind) / 2e-6
            np.testing.assert_allclose(gradient, slope, atol=2e-4 * np.abs(slope).max())
            assert np.linalg.eigvalsh(hessian).min() > -1e-8 * np.abs(hessian).max()


def in_the_open(problem: PreparedProblem, **rules: Any) -> PreparedProblem:
    """The same without obstacles, ground and limits; only the bounds stay."""
    airspace = Airspace(problem.task.airspace.bounds, problem.task.airspace.terrain, ())
    limits = replace(problem.limits, height_above_ground=-100.0, low_zones=())
    free = problem.rules._replace(height=-100.0, **LIMITLESS, **rules)
    return replace(problem, rules=free, grid=obstacle_grid_of(airspace, limits, 1.0))


@pytest.mark.parametrize(
    ("length", "smoothing"),
    [(1.0, SMOOTHING._replace(evenness=0.0)), (0.0, SMOOTHING._replace(evenness=0.0, reach=80.0))],
)
def test_the_models_curvature_is_exact_where_it_leaves_nothing_out(
    town: Town, length: float, smoothing: Smoothing
) -> None:
    """Length alone, or bounds alone: the Hessian is the derivative of the gradient."""
    problem = in_the_open(prepare(town(1)), length=length, turning=0.0, climbing=0.0)
    rng = np.random.default_rng(2)
    control = np.linspace((0.0, 0.0, 40.0), (100.0, 0.0, 50.0), 9) + rng.normal(size=(9, 3))
    hessian = model(problem, control, smoothing, mean_leg=1.5)[2]
    steps = 1e-5 * np.eye(27).reshape(27, 9, 3)
    change = [
        model(problem, control + h, smoothing, 1.5)[1] - model(problem, control - h, smoothing, 1.5)[1] for h in steps
    ]
    assert np.abs(hessian).max() > 1e-4
    np.testing.assert_allclose(hessian, np.array(change) / 2e-5, atol=1e-7)


def test_the_models_curvature_of_bends_is_that_of_weighted_squares(town: Town) -> None:
    """Each angle's derivatives, by differences, times themselves (Gauss-Newton)."""
    problem, smoothing = in_the_open(prepare(town(1)), length=0.0), SMOOTHING._replace(evenness=0.0)
    control = np.linspace((0.0, 0.0, 40.0), (100.0, 0.0, 50.0), 9) + np.random.default_rng(2).normal(size=(9, 3))
    signs = np.random.default_rng(0).uniform(-1, 1, (60, 2))[1:-1]  # as in `model`

    def angles(control: np.ndarray) -> np.ndarray:
        nodes = even_basis(9, 60) @ control
        return np.column_stack([twins.signed_turns(nodes), np.diff(climb_angles(nodes))])

    steps = 1e-5 * np.eye(27).reshape(27, 9, 3)
    slopes = np.array([(angles(control + h) - angles(control - h)) / 2e-5 for h in steps])
    smooth = np.sqrt(angles(control) ** 2 + smoothing.bend**2)
    rates = np.array([problem.rules.turning, problem.rules.climbing])
    weights = rates * (1 - signs * angles(control) / smooth) / smooth
    hessian, expected = model(problem, control, smoothing)[2], np.einsum("aik,ik,bik->ab", slopes, weights, slopes)
    np.testing.assert_allclose(hessian, expected, atol=1e-7 * np.abs(expected).max())


def test_slack_and_threat_are_those_of_the_twin(town: Town) -> None:
    from ipoa_mission.planning._kernels import slack_and_threat

    for seed in range(4):
        problem = prepare(town(seed))
        for airspace, posed in ((problem.task.airspace, problem), fenced(problem)):
            points = np.random.default_rng(seed).uniform((-60, -110, -5), (160, 110, 110), (3000, 3))
            slack, threat = slack_and_threat(points, posed.grid, posed.rules)
            expected, danger = twins.slack_and_threat(points, airspace, posed.rules, posed.limits, posed.grid.reach)
            np.testing.assert_allclose(slack, expected, atol=1e-9)
            np.testing.assert_allclose(threat, danger, rtol=1e-9)


def test_costs_spread_over_a_lattice_as_in_the_twin(scenario: Make) -> None:
    from ipoa_mission.planning._kernels import lattice_costs

    anywhere = prepare(scenario())
    rng = np.random.default_rng(5)
    every = np.array([step for step in np.ndindex(3, 3, 3) if step != (1, 1, 1)]) - 1
    for _ in range(10):
        price = rng.uniform(1, 3, rng.integers(2, 9, 3))
        price[rng.random(price.shape) < 0.3] = np.inf
        source = int(rng.choice(np.nonzero(np.isfinite(price.ravel()))[0]))
        steps = every[rng.random(26) < 0.7]
        lengths = np.linalg.norm(steps * rng.uniform(1, 3, 3), axis=1)
        nodes = Nodes(price, np.zeros(price.shape), np.zeros((price.size, 3)), np.ones(3))
        cost, before = lattice_costs(nodes, (steps, lengths), False, (source, 0, np.inf), anywhere.grid, anywhere.rules)
        np.testing.assert_allclose(cost, twins.lattice_costs(price, steps, lengths, source), rtol=1e-12)
        reached = np.isfinite(cost)
        reached[source] = False
        assert (before[reached] >= 0).all()
        assert (cost[before[reached]] < cost[reached]).all()
        assert (before[~reached] == -1).all()


def test_no_step_leads_through_what_is_between_two_nodes(scenario: Make) -> None:
    """Two nodes on either side of a wall, and one beside each by which it can be passed."""
    from ipoa_mission.planning._kernels import lattice_costs

    wall = {"kind": "box", "east": 50, "north": 0, "width": 0.2, "depth": 20, "height": 99, "base": 0.0}
    problem = prepare(scenario(obstacles=[wall], vehicle={"radius": 0.1}, safety_distance=0.1))
    places = np.array([(40.0, north, 20.0) for north in (0.0, 15.0)] + [(60.0, north, 20.0) for north in (0.0, 15.0)])
    price, steps = np.ones((2, 2, 1)), np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    lengths = np.array([20.0, 20.0, 15.0, 15.0])
    for check_legs, through in ((False, 20.0), (True, 50.0)):
        nodes = Nodes(price, np.zeros((2, 2, 1)), places, np.array([20.0, 15.0, 1.0]))
        assert (
            lattice_costs(nodes, (steps, lengths), check_legs, (0, 2, np.inf), problem.grid, problem.rules)[0][2]
            == through
        )


def test_nodes_on_cheap_routes_cost_the_same_within_a_ratio(scenario: Make) -> None:
    from ipoa_mission.planning._kernels import lattice_costs

    anywhere, rng = prepare(scenario()), np.random.default_rng(3)
    for _ in range(10):
        shape, spacing = rng.integers(3, 9, 3), rng.uniform(1, 3, 3)
        price = anywhere.rules.length * rng.uniform(1, 2, shape)
        steps = np.array([step for step in np.ndindex(3, 3, 3) if step != (1, 1, 1)]) - 1
        nodes = Nodes(price, np.zeros(shape), np.zeros((price.size, 3)), spacing)
        fixed = ((steps, np.linalg.norm(steps * spacing, axis=1)), False)
        source, target = rng.choice(price.size, 2, replace=False).tolist()
        there, back = (
            [lattice_costs(nodes, *fixed, (*ends, ratio), anywhere.grid, anywhere.rules)[0] for ratio in (1.3, np.inf)]
            for ends in ((source, target), (target, source))
        )
        cheap = there[1] + back[1] < 1.3 * there[1][target]
        np.testing.assert_allclose(there[0][cheap], there[1][cheap], rtol=1e-12)
        np.testing.assert_allclose(back[0][cheap], back[1][cheap], rtol=1e-12)
        assert (there[0] >= there[1] * (1 - 1e-12)).all()


@pytest.mark.parametrize("spot", [(np.nan, 0.0), (0.0, np.nan), (np.inf, -np.inf), (1e300, -1e300)])
def test_no_place_is_looked_up_outside_the_chart(town: Town, spot: tuple[float, float]) -> None:
    from ipoa_mission.planning._places import _cell, _on_map

    grid = prepare(town(0)).grid
    assert 0 <= _cell(grid.cells, *spot) < grid.cells.rows * grid.cells.columns
    column, row = _on_map(grid.ground, *spot)
    assert 0 <= column <= grid.ground.columns - 1
    assert 0 <= row <= grid.ground.rows - 1


def test_kernels_are_not_compiled_before_a_path_is_planned() -> None:
    lines = "import ipoa_mission.planning.planner, sys; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", lines], check=False).returncode == 0
