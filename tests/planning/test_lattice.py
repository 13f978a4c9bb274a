import numpy as np
import pytest

from ipoa_mission.planning.lattice import LatticeStrategy, _mend, find_routes, guesses, lay_lattice
from ipoa_mission.planning.problem import prepare
from tests.examples import some
from tests.planning.conftest import Make

PILLAR = {"kind": "cylinder", "name": "pillar", "east": 50, "north": 0, "radius": 15, "height": 99, "base": 0.0}
FULL = {"kind": "box", "east": 50, "north": 0, "width": 6, "height": 120, "base": 0.0}


def test_a_pillar_is_passed_on_both_sides(scenario: Make) -> None:
    problem = prepare(scenario(obstacles=[PILLAR]))
    paths = find_routes(lay_lattice(problem), problem, 8)
    sides = [np.sign(path[np.argmin(np.abs(path[:, 0] - 50)), 1]) for path in paths]
    assert {-1.0, 1.0} <= set(sides)
    for path in paths:
        np.testing.assert_array_equal(path[[0, -1]], [problem.task.places[0], problem.task.places[-1]])
        assert problem.task.airspace.obstacle_distance(path[1:-1]).min() >= problem.limits.obstacle_distance


def test_the_cheapest_way_comes_first(scenario: Make) -> None:
    problem = prepare(scenario(obstacles=[PILLAR | {"north": 8}], cost={"omega": (1, 0, 0)}))
    paths = find_routes(lay_lattice(problem), problem, 8)
    lengths = [np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in paths]
    assert np.argmin(lengths) == 0
    assert paths[0][np.argmin(np.abs(paths[0][:, 0] - 50)), 1] < 0


def test_every_way_passes_all_via_points(scenario: Make) -> None:
    problem = prepare(scenario(obstacles=[PILLAR], via=[(50, 60, 30), (80, -40, 30)]))
    paths = find_routes(lay_lattice(problem), problem, 8)
    assert len(paths) > 1
    for path in paths:
        for place in problem.task.places[1:-1]:
            assert np.linalg.norm(path - place, axis=1).min() == 0


def test_a_wall_from_bound_to_bound_leaves_no_way(scenario: Make) -> None:
    problem = prepare(scenario(obstacles=[FULL | {"name": "wall", "depth": 300}]))
    thin = LatticeStrategy(nodes=20_000)
    assert find_routes(lay_lattice(problem, strategy=thin), problem, 8) == []
    assert len(guesses(problem, 0, thin)) == 1  # the straight one


@pytest.mark.parametrize("aside", some(3, [0.0, 1.3, 2.9, 0.7, 2.1, 3.6]))
def test_a_door_between_two_nodes_is_found(scenario: Make, aside: float) -> None:
    """The nodes are 4 m apart; a door of 1.75 m leaves 0.15 m."""
    walls = [
        FULL | {"name": "left", "north": aside + 60.875, "depth": 120},
        FULL | {"name": "right", "north": aside - 60.875, "depth": 120},
    ]
    problem = prepare(scenario(obstacles=walls, vehicle={"radius": 0.3}, safety_distance=0.5))
    path = find_routes(lay_lattice(problem), problem, 8)[0]
    door = path[np.argmin(np.abs(path[:, 0] - 50))]
    assert door[1] == pytest.approx(aside, abs=0.075)


def test_lattice_finds_paths_around_a_too_narrow_gap(scenario: Make) -> None:
    pillars = [PILLAR | {"name": f"{side}", "radius": 12, "north": 12.95 * side} for side in (-1, 1)]  # 0.1 m short
    problem = prepare(scenario(obstacles=pillars, vehicle={"radius": 0.5}, safety_distance=0.5))
    lattice, (start, goal) = lay_lattice(problem), problem.task.places
    before, after = (lattice.places[np.argmin(((lattice.places - (e, 0, 20)) ** 2).sum(axis=1))] for e in (44, 56))
    first, *others = _mend([np.array([start, before, after, goal])], lattice, problem)
    assert first.shape[0] > 4  # it was tried
    assert others
    for path in others:
        assert problem.task.airspace.obstacle_clearance(path).distance > -0.5
        assert not (path == before).all(axis=1).any()


@pytest.mark.parametrize("fineness", [1.0, 2.0])
def test_a_lattice_covers_the_bounds_in_even_steps(scenario: Make, fineness: float) -> None:
    lattice = lay_lattice(prepare(scenario(obstacles=[PILLAR])), fineness)
    far = lattice.places[0] + lattice.spacing * (np.array(lattice.slack.shape) - 1)
    np.testing.assert_allclose(lattice.places[0, :2], (-50, -100))
    np.testing.assert_allclose(far[:2], (150, 100))
    assert 20_000 * fineness**3 < lattice.slack.size < 150_000 * fineness**3
