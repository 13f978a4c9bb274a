import numpy as np
import pytest
import scipy

from ipoa_mission.routing.resample import cubic_values


@pytest.mark.parametrize("count", [3, 4, 5, 50, 3000])
def test_cubic_is_that_of_scipy(count: int) -> None:
    chance = np.random.default_rng(count)
    knots = np.cumsum(chance.uniform(0.05, 3.0, count))
    points = np.cumsum(chance.normal(size=(count, 3)), axis=0)
    at = np.concatenate([np.linspace(knots[0], knots[-1], 997), knots])
    curve = scipy.interpolate.CubicSpline(knots, points)
    np.testing.assert_allclose(cubic_values(knots, points, at), curve(at), rtol=1e-9, atol=1e-9)
