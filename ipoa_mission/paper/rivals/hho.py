"""HHO, Harris hawks optimization (Heidari et al., Future Gener. Comput. Syst. 2019, 97, 849), as its authors code it.

Costs N + N T evaluations, and one for every dive repeated with a Levy step. Known costs are not evaluated again.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ipoa_mission.optimize.ipoa import levy_factor
from ipoa_mission.optimize.search import SHORT_SETTINGS, Box, Count, Members, Search, keep_better


@dataclass(frozen=True)
class HHO:
    """E0 and J are random (Table 2)."""

    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        n, d = self.population, box.dimension
        span = box.upper - box.lower
        x = box.sample(n, rng)
        f = yield x
        rabbit, rabbit_cost = x[f.argmin()], f.min()
        for t in range(self.iterations):
            energy = 2 * (1 - t / self.iterations) * (2 * rng.random((n, 1)) - 1)  # E, eq. (3)
            jump = 2 * (1 - rng.random((n, 1)))  # J
            perching, hard = np.abs(energy) >= 1, np.abs(energy) < 0.5
            q, r1, r2, r3, r4 = rng.random((5, n, 1))
            mean = x.mean(axis=0)

            # eq. (1) of Heidari et al.
            other = x[rng.integers(n, size=n)]
            perch = np.where(
                q < 0.5, other - r1 * np.abs(other - 2 * r2 * x), rabbit - mean - r3 * (box.lower + r4 * span)
            )
            # eq. (6), or soft by (4)
            besiege = np.where(
                hard, rabbit - energy * np.abs(rabbit - x), rabbit - x - energy * np.abs(jump * rabbit - x)
            )
            # eqs. (7) and (12); if not better, (8) and (13) with a Levy step
            dive = rabbit - energy * np.abs(jump * rabbit - np.where(hard, mean, x))  # Y
            diving = ~perching & (q < 0.5)
            trial = box.clip(np.where(perching, perch, np.where(diving, dive, besiege)))
            g = yield trial
            x, f, before, cost_before = trial, g, x, f

            failed = np.flatnonzero(diving[:, 0] & (g >= cost_before))
            if failed.size:
                again = box.clip(
                    dive[failed] + rng.random((failed.size, d)) * levy_factor(1.5, (failed.size, d), rng)  # Z
                )
                h = yield again
                x, f = trial.copy(), g.copy()
                x[failed], f[failed] = keep_better(before[failed], cost_before[failed], again, h)
            if f.min() < rabbit_cost:
                rabbit, rabbit_cost = x[f.argmin()], f.min()
