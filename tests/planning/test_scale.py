import numpy as np
import pytest

from ipoa_mission import Airspace, Bounds, Limits, PathProblem, plan_path
from ipoa_mission.planning.lattice import LatticeStrategy
from ipoa_mission.planning.planner import SearchStrategy
from ipoa_mission.planning.problem import curve_cost
from ipoa_mission.planning.spline import Spline
from ipoa_mission.world.obstacles import Cylinder, Prism
from ipoa_mission.world.terrain import Flat

REQUIRED = 0.23
STICKS = ((0.36, 0.29), (0.48, 0.88), (0.73, -0.17), (1.52, 1.13), (1.36, 0.22), (3.1, -0.6), (3.6, 0.4), (4.0, -0.9))


def room() -> PathProblem:
    """A wall with a gap five centimeters wider than required, among sticks."""
    low, high = -0.47 - REQUIRED - 0.025, -0.47 + REQUIRED + 0.025
    walls = tuple(
        Prism(name, ((2.34, a), (2.44, a), (2.44, b), (2.34, b)), (), 0.0, 4.0)
        for name, a, b in (("right", -8.0, low), ("left", high, 8.0))
    )
    sticks = tuple(Cylinder(f"stick {k}", *place, 0.08, 0.0, 3.0) for k, place in enumerate(STICKS))
    airspace = Airspace(Bounds((-2.0, -2.5, 0.0), (6.8, 2.5, 2.5)), Flat(), (*walls, *sticks))
    limits = Limits(obstacle_distance=REQUIRED, height_above_ground=0.3)
    return PathProblem(airspace, limits, np.array([[0.0, 0.0, 1.0], [4.8, 0.0, 1.2]]), radius=0.1)


@pytest.mark.long
def test_every_seed_finds_the_same_way_through_a_room() -> None:
    thin = SearchStrategy(lattice=LatticeStrategy(nodes=20_000))
    costs = [plan_path(room(), seed=seed, strategy=thin).cost.total for seed in range(2)]
    assert max(costs) <= 1.005 * min(costs)


def test_a_loop_of_millimeters_is_counted() -> None:
    around = np.linspace(0.0, 2 * np.pi, 13)
    loop = np.column_stack([50 + 0.002 * np.sin(around), 0.002 * (1 - np.cos(around)), np.full(13, 30.0)])
    before, after = ([[x, 0.0, 30.0] for x in xs] for xs in ((0.0, 20.0, 40.0), (60.0, 80.0, 100.0)))
    airspace = Airspace(Bounds((-10.0, -50.0, 0.0), (110.0, 50.0, 60.0)), Flat(), ())
    places = np.array([[0.0, 0.0, 30.0], [100.0, 0.0, 30.0]])
    problem = PathProblem(airspace, Limits(obstacle_distance=1.0, height_above_ground=5.0), places)
    looped = curve_cost(Spline(np.array([*before, *loop, *after])), problem)
    assert looped.turning_deg == pytest.approx(360.0, abs=30.0)
    assert curve_cost(Spline(np.array([*before, *after])), problem).turning_deg == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("turns", "pulled_to"), [(1, 36.749), (1, 36.72), (1, 34.0), (0, 37.0)])
def test_reversal_of_a_curve_is_counted_once(turns: int, pulled_to: float) -> None:
    ahead = np.array([0.0, 10.0, 20.0, 30.0, 39.0, pulled_to, 42.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0])
    straight = np.column_stack([ahead, 0.0 * ahead, np.full(13, 30.0)])
    airspace = Airspace(Bounds((-10.0, -50.0, 0.0), (110.0, 50.0, 60.0)), Flat(), ())
    problem = PathProblem(airspace, Limits(obstacle_distance=1.0, height_above_ground=5.0), straight[[0, -1]])
    back = Spline(straight).points(np.linspace(0.0, 1.0, 20001), order=1)[:, 0] < 0
    assert back.any() == turns
    assert curve_cost(Spline(straight), problem).turning_deg == pytest.approx(360.0 * turns)
