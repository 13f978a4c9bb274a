"""Run other libraries' optimizers as rivals."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ipoa_mission.errors import imported
from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimum


class Counted:
    """Counts the candidates, and keeps the best of the first `budget`."""

    def __init__(self, cost: Callable[[Candidates], Costs], box: Box, budget: int) -> None:
        self._cost, self._budget = cost, budget
        self.spent, self.best = 0, np.inf
        self.best_x = np.full(box.dimension, np.nan)
        self._evaluations: list[int] = []
        self._history: list[float] = []

    def __call__(self, candidates: Candidates) -> Costs:
        """Return the costs (n,) of `candidates` (n, D); infinite beyond the budget."""
        costs = np.full(len(candidates), np.inf)
        counted = max(min(len(candidates), self._budget - self.spent), 0)
        if counted:
            costs[:counted] = self._cost(np.ascontiguousarray(candidates[:counted]))
            self.spent += counted
            winner = int(np.argmin(costs))
            if costs[winner] < self.best:
                self.best, self.best_x = float(costs[winner]), np.array(candidates[winner])
            self._evaluations.append(self.spent)
            self._history.append(self.best)
        return costs

    def optimum(self) -> Optimum:
        return Optimum(self.best_x, self.best, np.array(self._evaluations), np.array(self._history))


Rival = Callable[[Callable[[Candidates], Costs], Box, int, np.random.Generator], Optimum]


def _by_minionpy(
    name: str, cost: Callable[[Candidates], Costs], box: Box, budget: int, rng: np.random.Generator
) -> Optimum:
    algorithms = imported("minionpy.algorithms", f"{name} needs minionpy, which is not installed", "paper")
    counted = Counted(cost, box, budget)

    def call(candidates: Any) -> list[float]:
        costs = counted(np.asarray(candidates, dtype=np.float64))
        return list(np.where(np.isfinite(costs), costs, 1e300))

    bounds = list(zip(box.lower.tolist(), box.upper.tolist(), strict=True))
    kind = getattr(algorithms, name)
    kind(call, bounds, maxevals=budget, seed=int(rng.integers(2**31)), options={}).optimize()
    return counted.optimum()


def _by_scipy(cost: Callable[[Candidates], Costs], box: Box, budget: int, rng: np.random.Generator) -> Optimum:
    """Minimize with scipy's defaults, a population of 5 D, and no polish."""
    from scipy.optimize import differential_evolution

    counted = Counted(cost, box, budget)
    population = 5 * box.dimension
    differential_evolution(
        lambda x: counted(x.T),
        list(zip(box.lower, box.upper, strict=True)),
        popsize=5,
        maxiter=budget // population + 1,
        tol=0,
        atol=0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=rng,
    )
    return counted.optimum()


RIVALS: dict[str, Rival] = {
    "rcmaes": partial(_by_minionpy, "RCMAES"),  # CMA-ES with restarts
    "lshade": partial(_by_minionpy, "LSHADE"),
    "de": _by_scipy,
}
