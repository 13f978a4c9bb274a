import sys

import numpy as np
import pytest

from ipoa_mission.paper.problems import FUNCTIONS, cec2022
from tests.refused import refuses


@pytest.mark.parametrize("dimension", [10, 20])
@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_batch_costs_what_its_candidates_cost_one_by_one(function: str, dimension: int) -> None:
    pytest.importorskip("minionpy")
    problem = cec2022(function, dimension)
    x = problem.box.sample(7, np.random.default_rng(1))
    together = problem.cost(x)
    assert together.shape == (7,)
    assert np.array_equal(together, np.concatenate([problem.cost(row[None]) for row in x]))
    assert np.all(together > 0)


@pytest.mark.parametrize("function", ["f1", "f3", "f5"])
def test_the_error_at_the_optimum_is_zero(function: str) -> None:
    """Found by restarted CMA-ES."""
    algorithms = pytest.importorskip("minionpy").algorithms
    problem = cec2022(function, 10)
    bounds = list(zip(problem.box.lower.tolist(), problem.box.upper.tolist(), strict=True))
    optimizer = algorithms.RCMAES(
        lambda x: problem.cost(np.asarray(x)).tolist(), bounds, maxevals=30_000, seed=1, options={}
    ).optimize()
    assert optimizer.fun == pytest.approx(0, abs=1e-4)
    near = problem.cost(np.asarray(optimizer.x) + np.random.default_rng(1).normal(0, 0.5, (500, 10)))
    assert near.min() > -1e-9


def test_missing_minionpy_is_an_error_that_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "minionpy.cec", None)
    with refuses("package-missing") as caught:
        cec2022("f1", 10)
    assert caught.value.hint == "pip install 'ipoa-mission[paper]'"
