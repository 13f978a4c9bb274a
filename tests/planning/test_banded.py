import numpy as np
import pytest
from scipy.linalg import solveh_banded
from scipy.ndimage import minimum_filter

from ipoa_mission.planning.banded import solve_banded
from ipoa_mission.planning.lattice import _least_around


@pytest.mark.parametrize(("count", "reach"), [(1, 2), (2, 2), (9, 14), (40, 2), (150, 14)])
def test_banded_equations_are_solved_as_lapack_does(count: int, reach: int) -> None:
    chance = np.random.default_rng(count)
    band = chance.normal(size=(reach + 1, count))
    band[0] = 2.1 * reach * np.abs(band).max()
    right = chance.normal(size=count)
    x, solved = solve_banded(band, right)
    assert solved == 1
    fitting = np.where(np.arange(reach + 1)[:, None] + np.arange(count) < count, band, 0.0)[: min(reach + 1, count)]
    np.testing.assert_allclose(x, solveh_banded(fitting, right, lower=True), rtol=1e-12, atol=1e-14)


def test_a_matrix_that_is_not_positive_definite_is_told() -> None:
    assert solve_banded(np.array([[1.0, 1.0, 1.0], [0.1, 2.0, 0.0]]), np.ones(3))[1] == 0
    assert solve_banded(np.array([[np.nan, 1.0]]), np.ones(2))[1] == 0


@pytest.mark.parametrize("reach", [1, 2])
def test_the_least_around_a_node_is_scipy_s_filter(reach: int) -> None:
    values = np.random.default_rng(reach).normal(size=(7, 4, 9))
    wanted = minimum_filter(values, size=2 * reach + 1, mode="nearest")
    np.testing.assert_array_equal(_least_around(values, reach), wanted)
