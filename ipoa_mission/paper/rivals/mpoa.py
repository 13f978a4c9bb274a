"""MPOA, a modified pelican algorithm (the paper's reference [43]). INFERRED: its formulas were not available.

By Table 2 (a = 1, SD = 0.2): POA, a Cauchy mutation x + x C(0, a), the sparrows' alarm for a share SD. Each is accepted
greedily. Costs N + T N (3 + SD).
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.search import Amount, Box, Candidates, Costs, Fraction, keep_better
from ipoa_mission.paper.rivals.ssa import flee


@dataclass(frozen=True)
class MPOA(POA):
    null_space: Amount = 1.0  # a, scale of the Cauchy distribution
    vigilant: Fraction = 0.2  # SD

    def iterate(
        self, x: Candidates, f: Costs, t: int, box: Box, rng: np.random.Generator
    ) -> Generator[Candidates, Costs, tuple[Candidates, Costs]]:
        x, f = yield from super().iterate(x, f, t, box, rng)
        # inferred
        trial = box.clip(x + x * self.null_space * rng.standard_cauchy(x.shape))
        x, f = keep_better(x, f, trial, (yield trial))
        # inferred: the sparrows' rule
        alarmed = rng.permutation(len(x))[: round(self.vigilant * len(x))]
        if alarmed.size:
            trial = box.clip(flee(x, f, alarmed, rng))
            x, f = x.copy(), f.copy()
            x[alarmed], f[alarmed] = keep_better(x[alarmed], f[alarmed], trial, (yield trial))
        return x, f
