"""MPOA, a modified pelican algorithm (the paper's reference [43]). INFERRED: its formulas were not available.

By Table 2 (a = 1, SD = 0.2): POA, a Cauchy mutation x + x C(0, a), the sparrows' alarm for a share SD. Each is accepted
greedily. Costs N + T N (3 + SD).
"""

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ipoa_mission.optimize.poa import step_to_prey, wing_step
from ipoa_mission.optimize.search import SHORT_SETTINGS, Amount, Box, Count, Fraction, Members, Search, keep_better
from ipoa_mission.paper.rivals.ssa import flee


@dataclass(frozen=True)
class MPOA:
    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000
    radius: Amount = 0.2  # R of (16)
    null_space: Amount = 1.0  # a, scale of the Cauchy distribution
    vigilant: Fraction = 0.2  # SD
    rand: Literal["pelican", "dimension"] = "pelican"

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        n, d = self.population, box.dimension
        width = 1 if self.rand == "pelican" else d
        x = box.sample(n, rng)  # (13)
        f = yield x
        for t in range(1, self.iterations + 1):
            # (14) to (17)
            trial = box.clip(x + step_to_prey(x, f, rng.integers(n), width, rng))
            x, f = keep_better(x, f, trial, (yield trial))
            trial = box.clip(x + wing_step(x, self.radius * (1 - t / self.iterations), rng))
            x, f = keep_better(x, f, trial, (yield trial))

            # inferred
            trial = box.clip(x + x * self.null_space * rng.standard_cauchy((n, d)))
            x, f = keep_better(x, f, trial, (yield trial))

            # inferred: the sparrows' rule
            alarmed = rng.permutation(n)[: round(self.vigilant * n)]
            if alarmed.size:
                trial = box.clip(flee(x, f, alarmed, rng))
                x, f = x.copy(), f.copy()
                x[alarmed], f[alarmed] = keep_better(x[alarmed], f[alarmed], trial, (yield trial))
