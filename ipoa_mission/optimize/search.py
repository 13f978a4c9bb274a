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
    """The space that is searched: a range for each of its D variables.

    Attributes:
        lower: least values, (D,).
        upper: greatest values, (D,).

    Example:
        >>> Box(np.zeros(3), np.ones(3)).clip(np.array([0.5, -2.0, 7.0]))
        array([0.5, 0. , 1. ])
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    @property
    def dimension(self) -> int:
        """Number of variables D."""
        return len(self.lower)

    def sample(self, n: int, rng: np.random.Generator) -> Candidates:
        """Candidates drawn uniformly: the paper's eq. (13).

        Args:
            n: how many.
            rng: where the random numbers come from.

        Returns:
            The candidates, (n, D).
        """
        return self.lower + rng.random((n, self.dimension)) * (self.upper - self.lower)

    def clip(self, x: Candidates) -> Candidates:
        """Out-of-range coordinates set to the bound, as the authors of POA do."""
        return np.clip(x, self.lower, self.upper)


class Optimizer(Protocol):
    """An algorithm with its settings: whatever has such a `search`.

    Example:
        >>> class Once:
        ...     def search(self, box, rng):
        ...         yield box.sample(100, rng)
        >>> box, rng = Box(-np.ones(2), np.ones(2)), np.random.default_rng(1)
        >>> found = minimize(lambda x: (x**2).sum(axis=1), box, Once(), rng)
        >>> len(found.x), int(found.evaluations[-1])
        (2, 100)
    """

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield candidates (n, D) and be sent their costs (n,), until the algorithm's own number of iterations is done.

        Args:
            box: the space that is searched.
            rng: where the random numbers come from.

        Returns:
            A generator.
        """
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
    *,
    budget: int | None = None,
    progress: Progress = silent,
) -> Optimum:
    """Run an optimizer on a cost; stop before the batch that would exceed the budget.

    Args:
        cost: takes many candidates at once, (n, D), and returns a cost for each, (n,).
        box: the space that is searched.
        optimizer: the algorithm with its settings.
        rng: where the random numbers come from.
        budget: how many evaluations there may be; left out, as many as the optimizer makes.
        progress: told the share done, a guess without a budget, and the best cost, after each batch.

    Returns:
        The best candidate `x` (D,), its `cost`, and the best cost known (`history`) after so many `evaluations`.

    Example:
        >>> from ipoa_mission import IPOA, Box, minimize
        >>> box = Box(np.full(4, -5.0), np.full(4, 5.0))
        >>> best = minimize(lambda x: (x**2).sum(axis=1), box, IPOA(iterations=50), np.random.default_rng(7))
        >>> bool(best.cost < 1e-3)
        True
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
