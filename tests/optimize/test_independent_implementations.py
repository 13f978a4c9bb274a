"""Two-sample tests over many short runs against independent implementations.

POA against mealpy's; HHO, DBO and SSA against their authors' rules. mealpy has no DBO; its HHO accepts greedily and
takes a hundredth of the Levy step, its SSA multiplies by exp(+i / ...) where the paper has exp(-i / ...).
"""

from collections.abc import Callable

import numpy as np
import pytest
import scipy

from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.search import Box, Optimizer, minimize
from ipoa_mission.paper.rivals.dbo import DBO
from ipoa_mission.paper.rivals.hho import HHO
from ipoa_mission.paper.rivals.ssa import SSA
from tests.examples import some
from tests.optimize.authors_rules import dbo, hho, ssa

D = 5
BOX = Box(np.full(D, -10.0), np.full(D, 20.0))
SHIFT = np.array([3.0, -4.0, 7.0, 1.0, 12.0])
RUNS = 80


def sphere(x: np.ndarray) -> np.ndarray:
    return np.sum((x - SHIFT) ** 2, axis=-1)


def rosenbrock(x: np.ndarray) -> np.ndarray:
    z = x - SHIFT + 1
    return np.sum(100 * (z[..., 1:] - z[..., :-1] ** 2) ** 2 + (1 - z[..., :-1]) ** 2, axis=-1)


def rastrigin(x: np.ndarray) -> np.ndarray:
    z = x - SHIFT
    return np.sum(z**2 - 10 * np.cos(2 * np.pi * z) + 10, axis=-1)


FUNCTIONS = [sphere, *(pytest.param(function, marks=pytest.mark.long) for function in (rosenbrock, rastrigin))]


def ours(optimizer: Optimizer, function: Callable[[np.ndarray], np.ndarray]) -> list[float]:
    return [minimize(function, BOX, optimizer, np.random.default_rng([1, run])).cost for run in range(RUNS)]


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(("kind", "rule"), some(1, [(DBO, dbo), (HHO, hho), (SSA, ssa)]))
def test_rivals_are_distributed_as_by_their_authors_rules(
    kind: type, rule: Callable[..., float], function: Callable[[np.ndarray], np.ndarray]
) -> None:
    theirs = [
        rule(lambda x: float(function(x)), BOX.lower, BOX.upper, 30, 12, np.random.default_rng([2, run]))
        for run in range(RUNS)
    ]
    assert scipy.stats.ks_2samp(ours(kind(population=30, iterations=12), function), theirs).pvalue > 0.01


@pytest.mark.parametrize("function", FUNCTIONS)
def test_poa_is_distributed_as_mealpy_has_it(function: Callable[[np.ndarray], np.ndarray]) -> None:
    mealpy = pytest.importorskip("mealpy")
    problem = {
        "bounds": mealpy.FloatVar(lb=BOX.lower, ub=BOX.upper),
        "minmax": "min",
        "obj_func": function,
        "log_to": None,
    }
    theirs = [
        mealpy.POA.OriginalPOA(epoch=25, pop_size=10).solve(problem, seed=run).target.fitness for run in range(RUNS)
    ]
    assert scipy.stats.ks_2samp(ours(POA(population=10, iterations=25), function), theirs).pvalue > 0.01


def test_so_many_runs_tell_a_reading_from_its_neighbor() -> None:
    """The finest difference is what `rand` of eq. (14) is drawn for."""
    each = ours(POA(population=10, iterations=25, rand="dimension"), rosenbrock)
    assert scipy.stats.ks_2samp(ours(POA(population=10, iterations=25), rosenbrock), each).pvalue < 0.001
