from itertools import combinations

import numpy as np
import pytest
import shapely
from scipy.optimize import lsq_linear

from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing._corridor import fewest_legs
from ipoa_mission.routing.fastest import _least_squares, relaxed
from ipoa_mission.routing.resample import NO_PLACES, corridor, evenly_spaced, every, is_far, strays

RNG = np.random.default_rng(4)
CURVES = [Spline(np.cumsum(RNG.normal((12, 5, 0.5), (6, 9, 2), (n, 3)), axis=0)) for n in (4, 7, 10, 14, 20)]


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.control)} control points")
@pytest.mark.parametrize("tolerance", [0.3, 1.0, 3.0])
def test_legs_of_a_corridor_stay_within_the_tolerance_of_the_curve(curve: Spline, tolerance: float) -> None:
    waypoints, _ = corridor(curve, tolerance)
    level, legs = curve.sample(3000) * (1, 1, 0), shapely.LineString(waypoints[:, :2])
    assert shapely.distance(legs, shapely.points(level[:, :2])).max() <= tolerance * 1.02
    np.testing.assert_allclose(waypoints[[0, -1]], curve.control[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.control)} control points")
@pytest.mark.parametrize("tolerance", [0.3, 1.0, 3.0])
def test_a_corridor_needs_no_more_waypoints_than_douglas_and_peucker(curve: Spline, tolerance: float) -> None:
    flat = Spline(curve.control * (1, 1, 0))
    simplified = shapely.simplify(shapely.LineString(flat.sample(400)[:, :2]), tolerance)
    assert len(corridor(flat, tolerance)[0]) <= len(simplified.coords)


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.control)} control points")
def test_fewest_legs_that_stay_nearest_are_taken(curve: Spline) -> None:
    samples = curve.sample(40)
    spots, tolerance = samples[:, None], 2.0
    before = fewest_legs(samples, spots, np.full(40, 39), tolerance)[:, 0, 0]
    best = [(0, 0.0), *[(40, np.inf)] * 39]
    for i, j in combinations(range(40), 2):
        away = [_away(samples[k], samples[i], samples[j]) for k in range(i + 1, j + 1)]
        if max(away) <= tolerance:
            best[j] = min(best[j], (best[i][0] + 1, best[i][1] + max(away) ** 2))
    legs, strain, end = 0, 0.0, 39
    while end > 0:
        start = int(before[end])
        away = [_away(samples[k], samples[start], samples[end]) for k in range(start + 1, end + 1)]
        legs, strain, end = legs + 1, strain + max(away) ** 2, start
    assert (legs, strain) == (best[-1][0], pytest.approx(best[-1][1], abs=1e-9))


def _away(place: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    leg = end - start
    share = np.clip((place - start) @ leg / (leg @ leg), 0.0, 1.0)
    return float(np.linalg.norm(place - start - share * leg))


@pytest.mark.parametrize("tolerance", [0.4, 4.0])
def test_a_long_curve_with_short_bends_is_kept_to_as_closely(tolerance: float) -> None:
    """Six kilometers with a swerve of 12 m every kilometer."""
    east = np.linspace(0.0, 6000.0, 400)
    curve = Spline(np.column_stack([east, 12.0 * np.exp(-(((east + 500) % 1000 - 500) ** 2) / 900.0), 0 * east + 30]))
    beside = (-0.6 * tolerance, 0.0, 0.6 * tolerance)
    for waypoints, _ in (corridor(curve, tolerance), corridor(curve, tolerance, beside)):
        legs = shapely.LineString(waypoints[:, :2])
        assert shapely.distance(legs, shapely.points(curve.sample(9000)[:, :2])).max() <= 1.15 * tolerance
        assert len(waypoints) < 60


def test_a_straight_curve_is_two_waypoints() -> None:
    assert len(corridor(Spline(np.linspace((0, 0, 10), (200, 100, 30), 8)), 0.5)[0]) == 2


def test_a_quarter_circle_takes_as_many_legs_as_geometry_says() -> None:
    angle = np.linspace(0, np.pi / 2, 40)
    circle = Spline(100 * np.column_stack([np.sin(angle), 1 - np.cos(angle), 0 * angle]))
    widest = 2 * np.arccos(1 - 1.0 / 100)  # its chord is a meter from the arc
    assert len(corridor(circle, 1.0)[0]) - 1 == int(np.ceil(np.pi / 2 / widest))


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.control)} control points")
def test_even_waypoints_are_equally_far_apart_and_no_farther_than_asked(curve: Spline) -> None:
    waypoints = every(curve, 5.0)
    arcs = curve.length / (len(waypoints) - 1)
    assert arcs <= 5.0
    assert np.linalg.norm(np.diff(waypoints, axis=0), axis=1).max() <= arcs * 1.001


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"{len(c.control)} control points")
def test_waypoints_outside_the_bends_are_fewer_and_as_near(curve: Spline) -> None:
    (on, _), (beside, _) = corridor(curve, 2.0), corridor(curve, 2.0, (-1.5, 0.0, 1.5))
    assert len(beside) <= len(on)
    legs = shapely.LineString(beside[:, :2])
    assert shapely.distance(legs, shapely.points(curve.sample(3000)[:, :2])).max() <= 2.0 * 1.02


def test_the_deviation_of_a_leg_is_found_in_its_middle() -> None:
    angle = np.linspace(0, np.pi, 60)
    bow = Spline(50 * np.column_stack([-np.cos(angle), np.sin(angle), 0 * angle]))
    assert strays(bow.control[[0, -1]], bow, 49.5)
    assert not strays(bow.control[[0, -1]], bow, 50.5)
    assert not strays(bow.sample(2000), bow, 0.02)


def test_relaxed_line_is_straight_at_a_weave_and_wide_round_a_corner() -> None:
    along = np.linspace(0.0, 300.0, 30)
    aside = 1.5 * np.sin(along / 24)
    aside[[0, -1]] = 0.0
    weave = Spline(np.column_stack([along, aside, np.full(30, 40.0)]))
    line = relaxed(weave, 3.0, NO_PLACES)
    assert np.abs(line[:, 1]).max() < 0.05  # of 1.5
    leg = np.linspace(0.0, 150.0, 20)[:, None]
    corner = Spline(np.vstack([leg * (1, 0, 0), (150, 0, 0) + leg[1:] * (0, 1, 0)]))
    for room in (0.0, 2.0, 5.0):
        line = relaxed(corner, room, NO_PLACES)
        apart = shapely.distance(shapely.LineString(corner.sample(3000)[:, :2]), shapely.points(line[:, :2]))
        assert apart.max() == pytest.approx(room, abs=0.05)
        np.testing.assert_allclose(line[[0, -1]], corner.control[[0, -1]], atol=1e-9)
    via = corner.points(np.array([0.5]))
    assert np.linalg.norm(relaxed(corner, 5.0, via) - via, axis=1).min() < 1e-9
    waypoints = evenly_spaced(line, 12.0, 40.0, NO_PLACES)
    steps = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    assert steps[:-1].max() <= 12.0
    assert steps[-1] == pytest.approx(40.0, abs=0.1)


def test_points_far_from_a_line_are_those_of_all_pairs() -> None:
    chance = np.random.default_rng(7)
    for count, others in ((1, 2), (40, 2), (300, 200)):
        points = np.cumsum(chance.normal(size=(count, 3)), axis=0)
        line = np.cumsum(chance.normal(size=(others, 3)), axis=0)
        away = shapely.distance(shapely.points(points[:, :2]), shapely.LineString(line[:, :2]))
        most = float(np.median(away)) + 1e-6
        np.testing.assert_array_equal(is_far(points, line, most), away > most)


@pytest.mark.parametrize("room", [0.05, 0.5, 5.0])
def test_least_squares_in_bounds_are_no_worse_than_scipy_s(room: float) -> None:
    bend = np.diff(np.eye(42), 2, axis=0)[:, 1:-1]
    wanted = np.random.default_rng(3).normal(size=len(bend))
    ours = _least_squares(bend, wanted, room)
    theirs = lsq_linear(bend, wanted, bounds=(-room, room), tol=1e-12, method="bvls").x
    assert np.abs(ours).max() <= room
    assert np.linalg.norm(bend @ ours - wanted) <= np.linalg.norm(bend @ theirs - wanted) * (1 + 1e-9)
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
