import numpy as np
import pytest

from ipoa_mission.planning.polish import shifts_along
from ipoa_mission.planning.problem import follow, null_space, pin_to_via, prepare, refine, surround, via_indices
from tests.plain_python import as_plain_python
from tests.planning.conftest import Make, Place

ENCODINGS = ("absolute", "chord", "sine")
STRAIGHT = np.array([(0.0, 0.0, 20.0), (100.0, 0.0, 20.0)])


def test_a_straight_guide_becomes_a_straight_even_curve(scenario: Make) -> None:
    curve = follow(STRAIGHT, 8, scenario()).curve
    u = np.linspace(0, 1, 21)
    expected = np.column_stack([100 * u, 0 * u, np.full(21, 20.0)])
    np.testing.assert_allclose(curve.points(u), expected, atol=1e-9)


@pytest.mark.parametrize("name", ["chord", "sine"])
def test_the_origin_of_the_space_is_the_guide(scenario: Make, name: str) -> None:
    encoding = surround(name, follow(STRAIGHT, 8, scenario()), 30.0, scenario())
    assert encoding.box.dimension == 16
    np.testing.assert_allclose(encoding.curve(np.zeros(16)).control, follow(STRAIGHT, 8, scenario()).curve.control)


def test_absolute_coordinates_are_the_inner_control_points(scenario: Make) -> None:
    encoding = surround("absolute", follow(STRAIGHT, 3, scenario()), 0.0, scenario())
    x = np.arange(9.0)
    control = encoding.curve(x).control
    np.testing.assert_array_equal(control[1:-1].ravel(), x)
    np.testing.assert_array_equal(control[[0, -1]], STRAIGHT)
    np.testing.assert_array_equal(encoding.box.lower, np.tile((-50.0, -100.0, 0.0), 3))
    np.testing.assert_array_equal(encoding.box.upper, np.tile((150.0, 100.0, 100.0), 3))


def test_chord_offsets_go_aside_and_upwards(scenario: Make) -> None:
    encoding = surround("chord", follow(STRAIGHT, 4, scenario()), 30.0, scenario())
    straight = encoding.origin
    aside, up = encoding.curve(np.eye(8)[2]).control, encoding.curve(np.eye(8)[3]).control
    np.testing.assert_allclose(aside - straight, [[0, 0, 0], [0, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]])
    np.testing.assert_allclose(up - straight, [[0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0], [0, 0, 0], [0, 0, 0]])


def test_sine_modes_are_waves_that_get_smaller(scenario: Make) -> None:
    encoding = surround("sine", follow(STRAIGHT, 8, scenario()), 30.0, scenario())
    for mode in range(1, 4):
        offset = (encoding.curve(np.eye(16)[2 * (mode - 1)]).control - encoding.origin)[:, 1]
        progress = encoding.origin[:, 0] / 100
        np.testing.assert_allclose(offset, np.sin(mode * np.pi * progress) / mode, atol=1e-9)


@pytest.mark.parametrize("name", ENCODINGS)
def test_every_candidate_passes_the_via_points_in_order(scenario: Make, name: str) -> None:
    job = scenario(via=[(30, 40, 25), (60, -30, 30)])
    around = follow(job.places, 15, job)
    encoding = surround(name, around, 30.0, job)
    rng = np.random.default_rng(1)
    for x in encoding.box.sample(20, rng):
        curve = encoding.curve(x)
        np.testing.assert_allclose(curve.points(around.via_at), job.via_points, atol=1e-9)
        np.testing.assert_allclose(curve.control[[0, -1]], [job.start_point, job.goal_point])
    assert (np.diff(around.via_at) > 0).all()


def test_freedom_moves_everything_but_ends_and_via_points(scenario: Make) -> None:
    job = scenario(via=[(30, 40, 25), (60, -30, 30)])
    candidate = follow(job.places, 15, job)
    free = null_space(candidate, job)
    assert np.linalg.matrix_rank(free) == free.shape[1] == 13
    np.testing.assert_array_equal(free[[0, -1]], 0.0)
    moved = candidate.curve.control + free @ np.random.default_rng(2).normal(size=(13, 3))
    assert np.abs(moved - candidate.curve.control)[1:-1].min() > 0
    again = pin_to_via(type(candidate)(type(candidate.curve)(moved), candidate.via_at), job)
    np.testing.assert_allclose(again.curve.control, moved, atol=1e-9)


@pytest.mark.parametrize("via", [[(30, 40, 25), (60, -30, 30)], []])
def test_a_band_by_what_is_free_is_that_of_the_whole_matrix(scenario: Make, via: list[Place]) -> None:
    job, plain = scenario(via=via), as_plain_python("ipoa_mission.planning._path_model")
    free = null_space(follow(job.places, 15, job), job)
    size, reach = 3 * len(free), 7
    rng = np.random.default_rng(3)
    band, gradient = rng.normal(size=(reach + 1, size)), rng.normal(size=size)
    whole = np.zeros((size, size))
    for k in range(reach + 1):
        whole += np.diag(band[k, : size - k], -k) + (np.diag(band[k, : size - k], k) if k else 0.0)
    ways = np.kron(free, np.eye(3))
    expected = ways.T @ whole @ ways
    slope, reduced = plain.reduced(gradient, band, shifts_along(free, reach))
    np.testing.assert_allclose(slope, ways.T @ gradient, atol=1e-12)
    for k in range(len(expected)):
        reduced_band = reduced[k, : len(expected) - k] if k < len(reduced) else 0.0
        np.testing.assert_allclose(reduced_band, np.diag(expected, -k), atol=1e-12)


def test_a_part_is_varied_and_the_rest_stays(scenario: Make) -> None:
    around = refine(follow(STRAIGHT, 8, scenario()))
    encoding = surround("sine", around, 10.0, scenario(), slice(4, 9))
    change = encoding.curve(np.ones(10)).control - around.curve.control
    assert (np.abs(change[5:10]).max(axis=1) > 0.1).all()
    np.testing.assert_array_equal(np.delete(change, range(5, 10), axis=0), 0.0)


@pytest.mark.parametrize("goal", [(0, 0, 90), (0, 5, 20)])
def test_a_way_straight_up_has_axes_too(scenario: Make, goal: Place) -> None:
    job = scenario(goal=goal)
    encoding = surround("sine", follow(job.places, 8, job), 10.0, job)
    assert np.linalg.matrix_rank(encoding.matrix.reshape(16, -1)) == 16
    assert np.isfinite(prepare(job).costs(encoding)(encoding.box.sample(10, np.random.default_rng(0)))).all()


def test_the_search_looks_closely_enough_not_to_jump_over_what_is_near(scenario: Make) -> None:
    long_way = scenario(start=(-45, -95, 20), goal=(145, 95, 20), safety_distance=0.5, vehicle={"radius": 0.5})
    assert prepare(long_way).nodes >= np.linalg.norm(long_way.goal_point - long_way.start_point) / 2.0 - 1
    assert prepare(scenario(planning={"planner": "paper"})).nodes == 100


def test_via_points_have_samples_where_a_path_returns_to_the_first() -> None:
    """One after the other, the first took the last inner sample, and the second had none."""
    path = np.array([(0, 0, 0), (9, 0, 0), (9, 1, 0), (0, 1, 0), (1, 9, 0)], dtype=float)
    assert via_indices(path, np.array([(1, 1, 0), (0, 2, 0)], dtype=float)) == [2, 3]
