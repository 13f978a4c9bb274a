"""DBO, the dung beetle optimizer (Xue and Shen, The Journal of Supercomputing 2023, 79, 7305).

As in the authors' code, bounds x (1 - R) and x (1 + R) swap for negative x. Clipping then returns the upper one. Costs
N + N T evaluations.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from ipoa_mission.optimize.search import SHORT_SETTINGS, Amount, Box, Count, Fraction, Search, keep_better


@dataclass(frozen=True)
class DBO:
    """k, b and S as in the paper's Table 2 (the authors' code: b = 0.3, S = 0.5)."""

    short_settings: ClassVar = SHORT_SETTINGS
    population: Annotated[int, Field(ge=10)] = 30
    iterations: Count = 1000
    deflection: Amount = 0.1  # k
    rolling: Amount = 0.1  # b
    stealing: Amount = 0.3  # S
    obstacle: Fraction = 0.1  # probability of dancing, from the authors

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        n = self.population
        rollers, broods, foragers = round(n * 6 / 30), round(n * 12 / 30), round(n * 19 / 30)  # last index of each role
        x = box.sample(n, rng)
        f = yield x
        home, home_cost = x, f
        before = home
        for t in range(1, self.iterations + 1):
            best = home[home_cost.argmin()]
            worst = x[f.argmax()]

            # eqs. (1) and (2) of Xue and Shen
            here, previous = home[:rollers], before[:rollers]
            if rng.random() >= self.obstacle:
                alpha = np.where(rng.random((rollers, 1)) > 0.1, 1, -1)
                trial = here + self.rolling * np.abs(here - worst) + alpha * self.deflection * previous
            else:
                degrees = rng.integers(1, 181, (rollers, 1))
                dances = degrees % 90 != 0
                trial = here + np.where(dances, np.tan(np.radians(degrees)), 0) * np.abs(here - previous)
            rolled = box.clip(trial)
            rolled_cost = yield rolled
            x, f = np.concatenate([rolled, x[rollers:]]), np.concatenate([rolled_cost, f[rollers:]])

            shrinking = 1 - t / self.iterations  # R
            local = x[f.argmin()]

            # eqs. (3) and (4)
            low, high = box.clip(local * (1 - shrinking)), box.clip(local * (1 + shrinking))
            here = home[rollers:broods]
            r1, r2 = rng.random((2, *here.shape))
            brood = np.minimum(np.maximum(local + r1 * (here - low) + r2 * (here - high), low), high)

            # eqs. (5) and (6)
            low, high = box.clip(best * (1 - shrinking)), box.clip(best * (1 + shrinking))
            here = home[broods:foragers]
            c1, c2 = rng.standard_normal((len(here), 1)), rng.random(here.shape)
            forage = here + c1 * (here - low) + c2 * (here - high)

            # eq. (7)
            here = home[foragers:]
            g = rng.standard_normal(here.shape)
            theft = best + self.stealing * g * (np.abs(here - local) + np.abs(here - best))

            others = box.clip(np.concatenate([brood, forage, theft]))
            others_cost = yield others
            x, f = np.concatenate([rolled, others]), np.concatenate([rolled_cost, others_cost])
            before = home
            home, home_cost = keep_better(home, home_cost, x, f)
