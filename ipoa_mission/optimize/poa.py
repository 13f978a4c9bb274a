"""POA, the pelican optimization algorithm (Trojovsky and Dehghani, Sensors 2022, 22, 855), as in its authors' code."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ipoa_mission.optimize.search import Box, Candidates, Costs, Search, keep_better
from ipoa_mission.optimize.settings import SHORT_SETTINGS, Amount, Count, Members


@dataclass(frozen=True)
class POA:
    """`radius` is the paper's R (Table 2).

    `rand` of eq. (14) is drawn per pelican, as by the authors, or coordinate.
    """

    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000
    radius: Amount = 0.2
    rand: Literal["pelican", "dimension"] = "pelican"

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield N candidates, then two batches of N an iteration; draw the prey once."""
        n, d = self.population, box.dimension
        width = 1 if self.rand == "pelican" else d
        x = box.sample(n, rng)  # (13)
        f = yield x
        for t in range(1, self.iterations + 1):
            trial = box.clip(towards_prey(x, f, width, rng))
            x, f = keep_better(x, f, trial, (yield trial))  # (15)
            trial = box.clip(wing(x, self.radius * (1 - t / self.iterations), rng))
            x, f = keep_better(x, f, trial, (yield trial))  # (17)


def towards_prey(x: Candidates, f: Costs, width: int, rng: np.random.Generator) -> Candidates:
    """Move towards prey, eq. (14)."""
    n = len(x)
    k = rng.integers(n)
    prey, prey_cost = x[k], f[k]
    intensity = rng.integers(1, 3, (n, 1))
    cheaper = (prey_cost < f)[:, None]
    moved: Candidates = x + rng.random((n, width)) * np.where(cheaper, prey - intensity * x, x - prey)
    return moved


def wing(x: Candidates, radius: float, rng: np.random.Generator) -> Candidates:
    """Eq. (16); `radius` is R (1 - t/T)."""
    return x + radius * (2 * rng.random(x.shape) - 1) * x
