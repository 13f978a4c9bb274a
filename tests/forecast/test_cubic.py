import numpy as np
import pytest
import scipy

from ipoa_mission.forecast.timing.bound import derivatives, values


@pytest.mark.parametrize("count", [3, 4, 5, 50, 3000])
def test_cubic_is_that_of_scipy(count: int) -> None:
    chance = np.random.default_rng(count)
    knots = np.cumsum(chance.uniform(0.05, 3.0, count))
    points = np.cumsum(chance.normal(size=(count, 3)), axis=0)
    at = np.concatenate([np.linspace(knots[0], knots[-1], 997), knots])
    curve = scipy.interpolate.CubicSpline(knots, points)
    first, second = derivatives(knots, points, at)
    np.testing.assert_allclose(values(knots, points, at), curve(at), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(first, curve(at, 1), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(second, curve(at, 2), rtol=1e-7, atol=1e-7)
