"""SSA, the sparrow search algorithm (Xue and Shen, Systems Science & Control Engineering 2020, 8, 22).

"Starving" are the worse half of the followers, not of all sparrows as in the authors' code: the paper's share of
finders is 0.7. Costs N + T N (1 + SD).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.optimize.search import (
    SHORT_SETTINGS,
    Box,
    Candidates,
    Costs,
    Count,
    Fraction,
    Members,
    Search,
    keep_better,
)


@dataclass(frozen=True)
class SSA:
    """Constants of Table 2."""

    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000
    safety: Fraction = 0.6  # ST
    finders: Fraction = 0.7  # PD
    vigilant: Fraction = 0.2  # SD

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        n = self.population
        producers = min(max(round(self.finders * n), 1), n - 1)
        rank = np.arange(1, n + 1)[:, None]
        starving = rank[producers:] > producers + (n - producers) / 2
        x = box.sample(n, rng)
        f = yield x
        for _ in range(self.iterations):
            order = np.argsort(f, kind="stable")
            x, f = x[order], f[order]
            worst = x[-1]

            # eq. (3) of Xue and Shen
            head = x[:producers]
            if rng.random() < self.safety:
                trial = head * np.exp(-rank[:producers] / ((1 - rng.random((producers, 1))) * self.iterations))
            else:
                trial = head + rng.standard_normal((producers, 1))
            trial = box.clip(trial)
            head, head_cost = keep_better(head, f[:producers], trial, (yield trial))

            # eq. (4)
            tail = x[producers:]
            prey = head[head_cost.argmin()]
            signs = rng.choice((-1.0, 1.0), tail.shape)
            elsewhere = rng.standard_normal((n - producers, 1)) * np.exp(
                np.minimum((worst - tail) / rank[producers:] ** 2, 700)
            )
            beside = prey + np.mean(np.abs(tail - prey) * signs, axis=1, keepdims=True)  # |x - x_p| A+ L
            trial = box.clip(np.where(starving, elsewhere, beside))
            tail, tail_cost = keep_better(tail, f[producers:], trial, (yield trial))
            x, f = np.concatenate([head, tail]), np.concatenate([head_cost, tail_cost])

            # eq. (5)
            alarmed = rng.permutation(n)[: round(self.vigilant * n)]
            if alarmed.size:
                trial = box.clip(flee(x, f, alarmed, rng))
                x[alarmed], f[alarmed] = keep_better(x[alarmed], f[alarmed], trial, (yield trial))


def flee(x: Candidates, f: Costs, alarmed: NDArray[np.intp], rng: np.random.Generator) -> Candidates:
    """Return places (m, D): near the best, or for the best one away from the worst."""
    here, cost = x[alarmed], f[alarmed, None]
    best, worst = x[f.argmin()], x[f.argmax()]
    m, d = here.shape
    inwards = best + rng.standard_normal((m, d)) * np.abs(here - best)
    gap = f.max() - f.min() if np.isfinite(f.min()) else 0.0
    away = here + (2 * rng.random((m, 1)) - 1) * np.abs(here - worst) / (-gap - 1e-50)
    fled: Candidates = np.where(cost > f.min(), inwards, away)
    return fled
