from itertools import pairwise

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.planning.spline import Spline, basis


def a_spline(seed: int, n: int = 9) -> Spline:
    return Spline(np.random.default_rng(seed).uniform(0, 100, (n, 3)))


def scipys(spline: Spline) -> "scipy.interpolate.BSpline":
    spans = len(spline.control) - 3
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, spans + 1), np.ones(3)])
    return scipy.interpolate.BSpline(knots, spline.control, 3)


@pytest.mark.parametrize("n", [4, 5, 10, 40])
@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_points_and_derivatives_are_those_of_scipy(n: int, order: int) -> None:
    spline, u = a_spline(n, n), np.linspace(0, 1, 101)
    if order == 3:
        u = (u[:-1] + u[1:]) / 2 + 1e-4  # it jumps at the knots
    expected = scipys(spline).derivative(order)(u) if order else scipys(spline)(u)
    np.testing.assert_allclose(spline.points(u, order), expected, rtol=1e-9, atol=1e-7)


def test_the_curve_begins_and_ends_in_its_end_points() -> None:
    spline = a_spline(1)
    np.testing.assert_array_equal(spline.points(np.array([0.0, 1.0])), spline.control[[0, -1]])


def test_the_length_is_the_integral_of_the_speed() -> None:
    spline = a_spline(2)
    velocity = scipys(spline).derivative()
    knots = np.linspace(0, 1, spline.spans + 1)
    pieces = [scipy.integrate.quad(lambda u: np.linalg.norm(velocity(u)), a, b)[0] for a, b in pairwise(knots)]
    assert spline.length == pytest.approx(sum(pieces), rel=1e-7)


def test_samples_are_equally_far_apart_along_the_curve() -> None:
    spline = a_spline(3)
    u, velocity = spline.parameters(11), scipys(spline).derivative()
    arcs = [scipy.integrate.quad(lambda v: np.linalg.norm(velocity(v)), a, b, limit=200)[0] for a, b in pairwise(u)]
    assert np.ptp(arcs) < 2e-3 * np.mean(arcs)
    np.testing.assert_allclose(spline.sample(11), spline.points(u))


@given(st.integers(0, 10_000), st.integers(4, 12), st.sampled_from([0.001, 0.1, 5.0]))
def test_the_curve_never_leaves_its_chords_by_more_than_the_tolerance(seed: int, n: int, tolerance: float) -> None:
    spline = a_spline(seed, n)
    u = spline.chords(tolerance)
    ends, t = spline.points(u), np.linspace(0, 1, 9)[1:-1, None, None]
    inner = spline.points((u[:-1] + t[..., 0] * np.diff(u)).ravel()).reshape(7, -1, 3)
    away = np.linalg.norm(inner - (ends[:-1] + t * np.diff(ends, axis=0)), axis=2)
    assert away.max() <= tolerance + 1e-9
    assert away.max() > tolerance / 20 or len(u) <= spline.spans + 1  # and does not waste chords


@given(st.integers(4, 30), st.integers(0, 10_000))
def test_refining_leaves_the_curve_as_it_was(n: int, seed: int) -> None:
    spline, u = a_spline(seed, n), np.linspace(0, 1, 300)
    finer = spline.refined()
    assert finer.spans == 2 * spline.spans
    np.testing.assert_allclose(finer.points(u), spline.points(u), atol=1e-8)


def test_basis_functions_sum_to_one() -> None:
    np.testing.assert_allclose(basis(12, np.linspace(0, 1, 77)).sum(axis=1), 1.0)
