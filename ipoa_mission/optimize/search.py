"""The one loop that all optimizers share: an optimizer yields candidates and is sent their costs.

An optimizer never calls the cost function, so it cannot miscount its budget, and several phases an iteration
need no flag: each phase is a `yield`.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.progress import Progress, silent

Candidates: TypeAlias = NDArray[np.float64]  # (n, D)
Costs: TypeAlias = NDArray[np.float64]  # (n,)
Search: TypeAlias = Generator[Candidates, Costs, None]

SEARCH_EVALUATIONS = 30_000  # about as many as the paper gives a search


@dataclass(frozen=True)
class Box:
    """The search space: lower and upper bound of each variable, (D,) each."""

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    @property
    def dimension(self) -> int:
        """Number of variables D."""
        return len(self.lower)

    def sample(self, n: int, rng: np.random.Generator) -> Candidates:
        """`n` candidates drawn uniformly, (n, D): the paper's eq. (13)."""
        return self.lower + rng.random((n, self.dimension)) * (self.upper - self.lower)

    def clip(self, x: Candidates) -> Candidates:
        """Out-of-range coordinates set to the bound, as the authors of POA do."""
        return np.clip(x, self.lower, self.upper)


class Optimizer(Protocol):
    """An algorithm with its settings. `search` is a generator: it yields candidates (n, D) and is sent costs (n,)."""

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield batches until the algorithm's own number of iterations is done."""
        ...


@dataclass(frozen=True)
class Optimum:
    """What a search found: the best candidate (D,), its cost, and how it came there.

    `evaluations[i]` evaluations had been spent when the best cost known was `history[i]`; one entry a batch.
    """

    x: NDArray[np.float64]
    cost: float
    evaluations: NDArray[np.int64]
    history: NDArray[np.float64]


def minimize(
    cost: Callable[[Candidates], Costs],
    box: Box,
    optimizer: Optimizer,
    rng: np.random.Generator,
    budget: int | None = None,
    progress: Progress = silent,
) -> Optimum:
    """Run `optimizer` on `cost` inside `box`; stop before the batch that would exceed `budget` evaluations.

    `progress` is told the evaluations and the best cost after each batch; without a budget its share is a guess.
    """
    search = optimizer.search(box, rng)
    best_x, best = np.full(box.dimension, np.nan), np.inf
    spent, evaluations, history = 0, [], []
    candidates = next(search)
    while budget is None or spent + len(candidates) <= budget:
        costs = cost(candidates)
        spent += len(candidates)
        winner = int(np.argmin(costs))
        if costs[winner] < best:
            best_x, best = candidates[winner].copy(), float(costs[winner])
        evaluations.append(spent)
        history.append(best)
        progress(spent / (budget or spent + SEARCH_EVALUATIONS), f"{spent} evaluations, cost {best:.1f}")
        try:
            candidates = search.send(costs)
        except StopIteration:
            break
    search.close()
    return Optimum(best_x, best, np.array(evaluations), np.array(history))


def keep_better(x: Candidates, f: Costs, trial: Candidates, g: Costs) -> tuple[Candidates, Costs]:
    """Greedy acceptance, the paper's eqs. (15) and (17): a trial replaces its parent when it costs less."""
    won = g < f
    return np.where(won[:, None], trial, x), np.where(won, g, f)
