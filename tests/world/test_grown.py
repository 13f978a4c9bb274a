from collections.abc import Sequence

import numpy as np
import pytest
import shapely

from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere
from ipoa_mission.world.obstacles.kinds import RoundZone, Zone
from tests.world.test_new_kind import CABLE

SQUARE = ((0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0))
COURT = ((10.0, 10.0), (10.0, 30.0), (30.0, 30.0), (30.0, 10.0))
HOUSE = Prism("house", SQUARE, (COURT,), 0.0, 20.0)
BALL = Sphere("ball", (5.0, -7.0, 30.0), 6.0)
MAST = Cylinder("mast", 5.0, -7.0, 1.0, 0.0, 30.0)


@pytest.mark.parametrize("body", [HOUSE, BALL, MAST])
def test_a_grown_body_is_nearer_by_so_much(body: Prism | Sphere | Cylinder) -> None:
    """A grown plan's corners have few edges, inside the true round ones."""
    aside = 3.0
    grown = body.grown(aside, aside, aside)
    (west, south, low), (east, north, high) = body.bounds
    middle = 0.5 * (south + north)
    beside = np.array([(east + 20.0, middle, 0.5 * (low + high)), (0.5 * (west + east), north + 11.0, low + 1.0)])
    before, after = body.distance(beside), grown.distance(beside)
    assert np.all(after >= before - aside - 1e-9)
    assert after[0] == pytest.approx(before[0] - aside, abs=0.01)
    assert np.all(after < before - 0.5 * aside)


@pytest.mark.parametrize("body", [RoundZone("fair", 5.0, -7.0, 9.0, 0.0, 30.0), Zone("park", SQUARE, (), 0.0, 20.0)])
def test_a_grown_zone_stays_air(body: RoundZone | Zone) -> None:
    assert type(body.grown(1.0, 2.0, 3.0)) is type(body)


def test_a_court_shrinks_and_vanishes() -> None:
    inside = np.array([[20.0, 20.0, 10.0]])
    assert HOUSE.distance(inside)[0] == pytest.approx(10.0)
    assert HOUSE.grown(4.0, 0.0, 0.0).distance(inside)[0] == pytest.approx(6.0)
    assert HOUSE.grown(11.0, 0.0, 0.0).distance(inside)[0] < 0


def test_horizontal_shapes_have_their_areas() -> None:
    assert BALL.horizontal_shape.area == pytest.approx(np.pi * 36.0, rel=0.01)
    assert MAST.horizontal_shape.area == pytest.approx(np.pi, rel=0.01)
    assert HOUSE.horizontal_shape.area == pytest.approx(1600.0 - 400.0)


@pytest.mark.parametrize("body", [HOUSE, BALL, MAST, CABLE])
def test_a_grown_body_has_its_room_on_each_side(body: Obstacle) -> None:
    lower, upper = body.bounds
    points = lower + (upper - lower) * np.random.default_rng(3).random((4000, 3))
    inside = points[body.distance(points) <= 0.0]
    grown = body.grown(1.0, 2.0, 3.0)
    assert len(inside) > 5
    for step in ((0.9, 0.0, 0.0), (0.0, -0.9, 0.0), (0.0, 0.0, -2.0), (0.0, 0.0, 3.0)):
        assert grown.distance(inside + step).max() <= 1e-9


def test_a_kind_without_a_column_is_passed_at_its_parts() -> None:
    (west, south, _), (east, north, high) = CABLE.bounds
    assert CABLE.horizontal_shape.equals(shapely.box(west, south, east, north))
    assert CABLE.column is None
    over = np.array([[-20.0, 60.0, high + 5.0]]), np.array([[200.0, 60.0, high + 5.0]])
    assert 4.5 < CABLE.leg_distances(*over)[0] <= CABLE.leg_clearance(over[0][0], over[1][0])[0]


def test_a_level_leg_is_exactly_as_far_from_an_upright_body() -> None:
    beside = np.array([[-20.0, 0.0, 10.0]]), np.array([[30.0, 0.0, 10.0]])
    assert MAST.leg_distances(*beside)[0] == pytest.approx(6.0)
    over = np.array([[-20.0, 20.0, 24.0]]), np.array([[60.0, 20.0, 24.0]])
    assert HOUSE.leg_distances(*over)[0] == pytest.approx(4.0)


@pytest.mark.parametrize(("leg", "sides"), [(((20.0, -50.0), (20.0, 90.0)), 2.0), (((-50.0, -9.0), (90.0, -9.0)), 1.0)])
def test_flight_over_a_court_has_walls_on_two_sides(leg: Sequence[tuple[float, float]], sides: float) -> None:
    a, b = (np.array([[*end, 35.0]]) for end in leg)
    assert HOUSE.passing(a, b).sides[0] == sides


def test_a_degree_of_latitude_is_some_111_kilometers() -> None:
    assert apart(Geodetic(47.0, 8.0), Geodetic(48.0, 8.0)) == pytest.approx(111_200.0, rel=0.001)
