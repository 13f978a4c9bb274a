"""The loop shared by all optimizers, and their settings."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Annotated, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ipoa_mission.errors import BadInput
from ipoa_mission.progress import Progress, silent

Candidates: TypeAlias = NDArray[np.float64]  # (n, D)
Costs: TypeAlias = NDArray[np.float64]  # (n,)
Search: TypeAlias = Generator[Candidates, Costs, None]


@dataclass(frozen=True)
class Box:
    """The search space.

    Attributes:
        lower: least values, finite, (D,).
        upper: greatest values, (D,); BadInput if below.

    Example:
        >>> Box(np.zeros(3), np.ones(3)).clip(np.array([0.5, -2.0, 7.0]))
        array([0.5, 0. , 1. ])
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    def __post_init__(self) -> None:
        is_box = np.shape(self.lower) == np.shape(self.upper) and np.less_equal(self.lower, self.upper).all()
        if not is_box or not np.isfinite([self.lower, self.upper]).all():
            raise BadInput(f"expected finite lower values up to the upper ones, not {self.lower} and {self.upper}")

    @property
    def dimension(self) -> int:
        return len(self.lower)

    def sample(self, n: int, rng: np.random.Generator) -> Candidates:
        """Draw `n` uniform candidates (n, D) by `rng`: the paper's eq. (13)."""
        return self.lower + rng.random((n, self.dimension)) * (self.upper - self.lower)

    def clip(self, x: Candidates) -> Candidates:
        """Clip to the bounds, as the authors of POA do."""
        return np.clip(x, self.lower, self.upper)


class Optimizer(Protocol):
    """Any object with such a `search`.

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
        """Yield candidates (n, D) in `box` by `rng` and receive their costs (n,), until done."""
        ...


@dataclass(frozen=True)
class Optimum:
    """Best candidate (D,), its cost, and the best cost `history[i]` after `evaluations[i]`."""

    x: NDArray[np.float64]
    cost: float
    evaluations: NDArray[np.int64]
    history: NDArray[np.float64]


class CountedCost:
    """A cost that keeps its best candidate."""

    def __init__(self, cost: Callable[[Candidates], Costs], box: Box) -> None:
        self.spent = 0
        self.best = np.inf
        self._cost = cost
        self._best_x = np.full(box.dimension, np.nan)
        self._evaluations: list[int] = []
        self._history: list[float] = []

    def __call__(self, candidates: Candidates) -> Costs:
        costs = self._cost(np.ascontiguousarray(candidates))
        costs = np.where(np.isnan(costs), np.inf, costs)  # else NaN would be the least
        self.spent += len(candidates)
        winner = int(np.argmin(costs))
        if costs[winner] < self.best:
            self.best = float(costs[winner])
            self._best_x = np.array(candidates[winner])
        self._evaluations.append(self.spent)
        self._history.append(self.best)
        return costs

    def optimum(self) -> Optimum:
        return Optimum(self._best_x, self.best, np.array(self._evaluations), np.array(self._history))


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
        cost: function from candidates (n, D) to costs (n,).
        box: the search space.
        optimizer: the algorithm with its settings.
        rng: the source of random numbers.
        budget: of evaluations; None: the optimizer's own.
        progress: called after each batch with the share done and the best cost.

    Returns:
        The best candidate (D,) and the history of the best cost.

    Raises:
        BadInput: the budget is below the first batch.

    Example:
        >>> from ipoa_mission import IPOA, Box, minimize
        >>> box = Box(np.full(4, -5.0), np.full(4, 5.0))
        >>> best = minimize(lambda x: (x**2).sum(axis=1), box, IPOA(iterations=50), np.random.default_rng(7))
        >>> bool(best.cost < 1e-3)
        True
    """
    counted = CountedCost(cost, box)
    search = optimizer.search(box, rng)
    candidates = next(search)
    if budget is not None and budget < len(candidates):
        words = f"expected a budget of at least {len(candidates)} evaluations, as the first batch has, not {budget}"
        raise BadInput(words, hint="raise the budget, or give the optimizer `short_settings` with a smaller batch")
    while budget is None or counted.spent + len(candidates) <= budget:
        costs = counted(candidates)
        spent = counted.spent
        progress(spent / (budget or spent + 30_000), f"{spent} evaluations, cost {counted.best:.1f}")
        try:
            candidates = search.send(costs)
        except StopIteration:
            break
    search.close()
    return counted.optimum()


def keep_better(x: Candidates, f: Costs, trial: Candidates, g: Costs) -> tuple[Candidates, Costs]:
    """Accept greedily, the paper's eqs. (15) and (17)."""
    won = g < f
    return np.where(won[:, None], trial, x), np.where(won, g, f)


#: An optimizer's `short_settings` are those of its short searches. Without them they end after this many evaluations.
SHORT_EVALUATIONS = 2500
SHORT_SETTINGS = {"population": 20, "iterations": 25}


Count: TypeAlias = Annotated[int, Field(ge=1)]
Members: TypeAlias = Annotated[int, Field(ge=4)]  # for steps between distinct members
Fraction: TypeAlias = Annotated[float, Field(ge=0, le=1)]
Amount: TypeAlias = Annotated[float, Field(ge=0)]
