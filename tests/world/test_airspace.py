from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.geometry import Place
from ipoa_mission.scenario.path_limits import Limits
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere
from ipoa_mission.world.polygon import Polygon
from ipoa_mission.world.terrain import Flat
from tests.refused import refuses

WIDE = Bounds((-50.0, -50.0, 0.0), (550.0, 550.0, 200.0))


def a_town(rng: np.random.Generator, count: int) -> tuple[Obstacle, ...]:
    town: list[Obstacle] = []
    for i in range(count):
        east, north = rng.uniform(0, 500, 2)
        if i % 3 == 0:
            town.append(Sphere(f"ball {i}", (east, north, rng.uniform(0, 100)), rng.uniform(2, 20)))
        elif i % 3 == 1:
            town.append(Cylinder(f"mast {i}", east, north, rng.uniform(2, 20), 0.0, rng.uniform(5, 100)))
        else:
            corners = ((east, north), (east + 20, north), (east + 20, north + 30), (east, north + 30))
            town.append(Prism(f"house {i}", corners, (), 0.0, rng.uniform(5, 100)))
    return tuple(town)


@pytest.mark.parametrize("count", [1, 10, pytest.param(300, marks=pytest.mark.long)])
def test_the_nearest_obstacle_is_found_as_if_all_were_asked(count: int) -> None:
    rng = np.random.default_rng(count)
    for _ in range(300 // count // 20 + 1):
        town = a_town(rng, count)
        space = Airspace(WIDE, Flat(0.0), town)
        points = rng.uniform((0, 0, 1), (500, 500, 150), (20, 3))
        points[5] = points[6]  # a stop
        points[8, :2] = points[7, :2]  # a climb
        all_distances = np.array([body.distance(points) for body in town])
        np.testing.assert_allclose(space.obstacle_distance(points), all_distances.min(axis=0), atol=1e-12)
        every = [
            (*body.leg_clearance(points[leg], points[leg + 1]), leg, body.name)
            for body in town
            for leg in range(len(points) - 1)
        ]
        nearest, expected = space.obstacle_clearance(points), min(every)
        assert nearest.distance == pytest.approx(expected[0], abs=1e-9)
        assert space.obstacle_clearance(points, within=nearest.distance + 5.0) == nearest
        assert space.obstacle_clearance(points, within=nearest.distance - 0.5).distance >= nearest.distance
        body = next(body for body in town if body.name == nearest.what)
        assert body.distance(np.array([nearest.place]))[0] == pytest.approx(nearest.distance, abs=1e-9)
        a, b = points[nearest.leg], points[nearest.leg + 1]
        assert body.leg_clearance(a, b)[0] == pytest.approx(nearest.distance, abs=1e-9)
        distance, share, name = min((*body.leg_clearance(a, b), body.name) for body in town)
        assert (name, distance) == (nearest.what, pytest.approx(nearest.distance, abs=1e-9))
        assert a + share * (b - a) == pytest.approx(nearest.place, abs=1e-6)


def test_the_ground_counts_as_an_obstacle_measured_vertically() -> None:
    space = Airspace(WIDE, Flat(10.0), (Sphere("ball", (100.0, 100.0, 50.0), 10.0),))
    low = space.leg_clearance(np.array([0.0, 0.0, 14.0]), np.array([20.0, 0.0, 13.0]))
    assert (low.what, low.distance, low.place) == ("terrain", 3.0, (20.0, 0.0, 13.0))
    near = space.leg_clearance(np.array([0.0, 100.0, 62.0]), np.array([200.0, 100.0, 62.0]))
    assert (near.what, near.place) == ("ball", (100.0, 100.0, 62.0))
    assert near.distance == pytest.approx(2.0)
    assert str(near) == "2.000 m to ball at east 100.00, north 100.00, up 62.00 m"
    np.testing.assert_allclose(space.clearance(np.array([[0.0, 0.0, 14.0], [100.0, 100.0, 65.0]])), [4.0, 5.0])
    highest = space.height_reached(np.array([[0.0, 0.0, 14.0], [20.0, 0.0, 13.0]]))
    assert (highest.what, highest.distance, highest.place) == ("the ground", 4.0, (0.0, 0.0, 14.0))


def test_an_airspace_without_obstacles_has_only_its_ground() -> None:
    space = Airspace(WIDE, Flat(0.0))
    assert space.obstacle_clearance(np.zeros((2, 3))).distance == np.inf
    assert space.polyline_clearance(np.array([[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]])).what == "terrain"
    assert space.beside(shapely.linestrings([[(0.0, 0.0), (1.0, 0.0)]]), np.array([1e6])).shape == (2, 0)


def test_leaving_the_bounds_names_the_side() -> None:
    space = Airspace(WIDE, Flat(0.0))
    legs = np.array([[0.0, 0.0, 100.0], [100.0, 0.0, 100.0], [100.0, 0.0, 207.0], [0.0, 0.0, 100.0]])
    out = space.bounds_margin(legs)
    assert (out.distance, out.what, out.leg) == (-7.0, "the upper bound", 1)


@pytest.mark.parametrize("area", [None, Polygon(((-40.0, -40.0), (60.0, -50.0), (10.0, 0.0), (-30.0, 70.0)))])
def test_the_margin_to_the_bounds_is_the_least_of_many_places(area: Polygon | None) -> None:
    rng = np.random.default_rng(8)
    bounds = Bounds((-80.0, -80.0, 0.0), (80.0, 80.0, 50.0), area)
    for _ in range(20):
        legs = rng.uniform((-90, -90, -5), (90, 90, 55), (6, 3))
        margin = Airspace(bounds, Flat(0.0)).bounds_margin(legs)
        shares = np.linspace(0, 1, 1501)[:, None]
        spots = np.array([a + shares * (b - a) for a, b in pairwise(legs)])
        margins = bounds.margin(spots.reshape(-1, 3)).reshape(5, -1)
        assert margin.distance == pytest.approx(margins.min(), abs=0.08)  # places are 0.15 m apart at most
        assert margin.distance <= margins.min() + 1e-9
        assert margins[margin.leg].min() == pytest.approx(margin.distance, abs=0.08)
        one_by_one = [bounds.leg_margin(a, b) for a, b in pairwise(legs)]
        assert min(leg.distance for leg in one_by_one) == pytest.approx(margin.distance, abs=1e-9)


def test_a_flight_area_is_kept_to_along_the_whole_leg() -> None:
    notch = Polygon(((0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (50.0, 20.0), (0.0, 100.0)))
    bounds = Bounds((-500.0, -500.0, 0.0), (500.0, 500.0, 100.0), notch)
    a, b = np.array([10.0, 50.0, 50.0]), np.array([90.0, 50.0, 50.0])
    across = bounds.leg_margin(a, b)
    assert across.what == "the edge of the flight area"
    sampled = bounds.margin(a + np.linspace(0, 1, 10_001)[:, None] * (b - a)).min()
    assert across.distance == pytest.approx(sampled, abs=1e-6)
    assert across.distance < -10


@pytest.mark.parametrize("upper", [(1.0, -1.0, 1.0), (1.0, 1.0, np.inf), (1.0, np.nan, 1.0)])
def test_bounds_inside_out_or_without_end_are_refused(upper: Place) -> None:
    with refuses("bad-input", "bounds"):
        Bounds((0.0, 0.0, 0.0), upper)


@pytest.mark.parametrize(
    "values",
    [(2.0, 30.0, 20.0), (-1.0, 5.0), (np.nan, 5.0), (2.0, np.nan), (2.0, 5.0, 20.0, 0.0), (2.0, 5.0, 9.0, 1.0, -1.0)],
)
def test_limits_that_no_path_can_keep_are_refused(values: Any) -> None:
    with refuses("bad-input", "limits"):
        Limits(*values)


def test_a_vertical_leg_beside_an_obstacle_is_as_near_as_its_points() -> None:
    tower = Cylinder("tower", 0.0, 0.0, 5.0, 0.0, 30.0)
    airspace = Airspace(Bounds((-50, -50, -10), (50, 50, 100)), Flat(0.0), (tower,))
    nearest = airspace.obstacle_clearance(np.array([[8.0, 0.0, 1.0], [8.0, 0.0, 60.0]]))
    assert (nearest.distance, nearest.what) == (pytest.approx(3.0), "tower")


def test_an_empty_airspace_is_near_to_nothing() -> None:
    space = Airspace(WIDE, Flat(), ())
    line = np.array([(0.0, 0.0, 10.0), (50.0, 0.0, 10.0)])
    assert list(space.near(line, 100.0)) == []
    assert space.obstacle_distance(line).tolist() == [np.inf, np.inf]
    assert [*space.near(line, 1000.0)] == []
    assert space.obstacle_clearance(line).distance == np.inf
    assert space.clearance(line).tolist() == [10.0, 10.0]


def test_near_tells_which_points_and_how_far() -> None:
    space = Airspace(WIDE, Flat(), (Cylinder("tower", 0.0, 0.0, 5.0, 0.0, 30.0),))
    points = np.array([(15.0, 0.0, 10.0), (100.0, 0.0, 10.0), (0.0, 8.0, 10.0)])
    ((body, which, distances),) = space.near(points, 12.0)
    assert (body.name, which.tolist()) == ("tower", [0, 2])
    assert distances == pytest.approx([10.0, 3.0])


def test_few_points_and_single_legs_find_what_many_find() -> None:
    rng = np.random.default_rng(5)
    space = Airspace(WIDE, Flat(0.0), a_town(rng, 40))
    points = rng.uniform((0, 0, 1), (500, 500, 150), (60, 3))
    few = np.concatenate([space.obstacle_distance(points[n : n + 3]) for n in range(0, 60, 3)])
    np.testing.assert_array_equal(few, space.obstacle_distance(points))
    for leg in pairwise(points):
        twice = np.array([leg[0], leg[1], leg[1] + (0.0, 0.0, 1e-9)])
        for within in (5.0, 30.0, np.inf):
            one, other = (space.obstacle_clearance(legs, within).distance for legs in (np.array(leg), twice))
            assert min(one, within) == pytest.approx(min(other, within), abs=1e-6)
    assert not len(Airspace(WIDE, Flat(0.0)).beside_leg(points[0], points[1], 5.0))
