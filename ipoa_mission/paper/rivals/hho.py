"""HHO, Harris hawks optimization (Heidari et al., Future Gener. Comput. Syst. 2019, 97, 849), as its authors code it.

A hawk that does not dive moves even to a worse position; only the best position found, the rabbit, is kept.
Costs N + N T evaluations, and one for every dive repeated with a Levy step. Known costs are not evaluated again, as in
the authors' code.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ipoa_mission.optimize.levy import levy_factor
from ipoa_mission.optimize.search import Box, Search, keep_better
from ipoa_mission.optimize.settings import SHORT_SETTINGS, Count, Members


@dataclass(frozen=True)
class HHO:
    """Search by hawks that perch while the rabbit has energy and besiege it later; E0 and J are random (Table 2)."""

    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield N candidates, then N an iteration and the repeated dives after them."""
        n, d = self.population, box.dimension
        span = box.upper - box.lower
        x = box.sample(n, rng)
        f = yield x
        rabbit, rabbit_cost = x[f.argmin()], f.min()
        for t in range(self.iterations):
            energy = 2 * (1 - t / self.iterations) * (2 * rng.random((n, 1)) - 1)  # E, their eq. (3)
            jump = 2 * (1 - rng.random((n, 1)))  # J
            perching, hard = np.abs(energy) >= 1, np.abs(energy) < 0.5
            q, r1, r2, r3, r4 = rng.random((5, n, 1))
            mean = x.mean(axis=0)

            # Perching, their eq. (1)
            other = x[rng.integers(n, size=n)]
            perch = np.where(
                q < 0.5,
                other - r1 * np.abs(other - 2 * r2 * x),  # close to a family member
                rabbit - mean - r3 * (box.lower + r4 * span),  # on a tall tree
            )
            # Besieging, hard by their eq. (6) or soft by (4)
            besiege = np.where(
                hard,
                rabbit - energy * np.abs(rabbit - x),
                rabbit - x - energy * np.abs(jump * rabbit - x),
            )
            # Diving, their eqs. (7) and (12), and repeated with a Levy step, (8) and (13), if that was no better
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
