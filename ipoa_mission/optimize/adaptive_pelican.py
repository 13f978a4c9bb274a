"""Adaptive pelican, our own algorithm: POA with difference steps of adaptive size.

Step scales: SHADE (Tanabe and Fukunaga 2013). The population shrinks as in L-SHADE (2014).
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ipoa_mission.optimize.search import SHORT_EVALUATIONS, Amount, Box, Candidates, Costs, Count, Fraction, Search


@dataclass(frozen=True)
class AdaptivePelican:
    """The flock begins with `per_dimension` D members, or fewer for `evaluations_per_member`."""

    short_settings: ClassVar = {"evaluations": SHORT_EVALUATIONS, "evaluations_per_member": 40.0}
    evaluations: Annotated[int, Field(ge=40)] = 90_060
    per_dimension: Annotated[float, Field(ge=1)] = 12.0
    evaluations_per_member: Annotated[float, Field(ge=10)] = 200.0
    prey_share: Fraction = 0.11  # of the best
    winging_share: Fraction = 0.1  # of the best
    surface_share: Fraction = 0.3  # of the best
    memories: Count = 6
    archive: Amount = 1.0  # members, per member

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield the first flock, then two batches a generation."""
        first = int(min(self.per_dimension * box.dimension, self.evaluations / self.evaluations_per_member))
        smallest = 4
        first = max(first, smallest)
        x = box.sample(first, rng)
        f = yield x
        spent = first
        scales, crossings, wings = (_Memory(self.memories, 0.5) for _ in range(3))
        displaced = np.empty((0, box.dimension))

        while spent < self.evaluations:
            order = np.argsort(f, kind="stable")
            x, f = x[order], f[order]
            n, d = x.shape
            each = np.arange(n)

            scale = _cauchy(scales.draw(n, rng), rng)
            crossing = np.clip(crossings.draw(n, rng) + 0.1 * rng.standard_normal(n), 0, 1)
            prey = x[rng.integers(max(2, round(self.prey_share * n)), size=n)]
            everyone = np.concatenate([x, displaced])
            r = _other_than(each[:, None], n, rng)
            s = _other_than(np.sort(np.column_stack([each, r])), len(everyone), rng)
            trial = _repair(x + scale[:, None] * (prey - x + x[r] - everyone[s]), x, box)
            crossed = rng.random((n, d)) < crossing[:, None]
            crossed[each, rng.integers(d, size=n)] = True
            trial = np.where(crossed, trial, x)[: self.evaluations - spent]
            g = yield trial
            m = len(trial)
            spent += m
            gain = _gain(f[:m], g)
            scales.learn(scale[:m], gain)
            crossings.learn(crossing[:m], gain)
            displaced = np.concatenate([displaced, x[:m][gain > 0]])
            x, f = _keep_not_worse(x, f, trial, g)

            order = np.argsort(f, kind="stable")
            x, f = x[order], f[order]
            surface = x[: max(2, round(self.surface_share * n))]
            weights = np.log(len(surface) + 0.5) - np.log(np.arange(1, len(surface) + 1))
            weights /= weights.sum()
            m = min(max(1, round(self.winging_share * n)), self.evaluations - spent)
            if m and self.winging_share:
                scale = np.abs(wings.draw(m, rng) + 0.1 * rng.standard_cauchy(m))
                scale = np.minimum(scale, 2)
                blend = rng.standard_normal((m, len(surface))) * np.sqrt(weights)
                trial = x[:m] + scale[:, None] * (blend @ (surface - weights @ surface))
                trial = _repair(trial, x[:m], box)
                g = yield trial
                spent += m
                gain = _gain(f[:m], g)
                wings.learn(scale, gain)
                displaced = np.concatenate([displaced, x[:m][gain > 0]])
                x, f = _keep_not_worse(x, f, trial, g)

            n = round(first + (smallest - first) * spent / self.evaluations)
            if n < len(x):
                best = np.argsort(f, kind="stable")[:n]
                x, f = x[best], f[best]
            kept = round(self.archive * n)
            if len(displaced) > kept:
                displaced = displaced[rng.permutation(len(displaced))[:kept]]


class _Memory:
    """Weighted Lehmer means of recent successes."""

    def __init__(self, slots: int, start: float) -> None:
        self._means = np.full(slots, start)
        self._next = 0

    def draw(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return self._means[rng.integers(len(self._means), size=n)]

    def learn(self, values: NDArray[np.float64], gain: NDArray[np.float64]) -> None:
        good, weight = values[gain > 0], gain[gain > 0]
        total = float(weight @ good)
        if total > 0:
            self._means[self._next] = weight @ good**2 / total
            self._next = (self._next + 1) % len(self._means)


def _gain(f: Costs, g: Costs) -> Costs:
    gain = np.subtract(f, g, out=np.zeros(len(f)), where=g < f)
    finite = np.isfinite(gain)
    return np.where(finite, gain, max(gain[finite].max(initial=0), 1e-300))


def _cauchy(centers: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    drawn = centers + 0.1 * rng.standard_cauchy(len(centers))
    while (again := np.flatnonzero(drawn <= 0)).size:
        drawn[again] = centers[again] + 0.1 * rng.standard_cauchy(again.size)
    return np.minimum(drawn, 1)


def _other_than(taken: NDArray[np.intp], n: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return an index below `n` for each row, not in that row of `taken` (ascending)."""
    index = rng.integers(n - taken.shape[1], size=len(taken))
    for column in taken.T:
        index += index >= column
    return index


def _repair(trial: Candidates, parent: Candidates, box: Box) -> Candidates:
    """Set coordinates outside the box halfway between parent and bound."""
    trial = np.where(trial < box.lower, (parent + box.lower) / 2, trial)
    return np.where(trial > box.upper, (parent + box.upper) / 2, trial)


def _keep_not_worse(x: Candidates, f: Costs, trial: Candidates, g: Costs) -> tuple[Candidates, Costs]:
    m = len(trial)
    accepted = g <= f[:m]
    x, f = x.copy(), f.copy()
    x[:m] = np.where(accepted[:, None], trial, x[:m])
    f[:m] = np.where(accepted, g, f[:m])
    return x, f
