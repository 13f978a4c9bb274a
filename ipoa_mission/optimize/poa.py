"""POA, the pelican optimization algorithm (Trojovsky and Dehghani, Sensors 2022, 22, 855), as in its authors' code."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ipoa_mission.optimize.search import (
    SHORT_SETTINGS,
    Amount,
    Box,
    Candidates,
    Costs,
    Count,
    Members,
    Search,
    keep_better,
)


@dataclass(frozen=True)
class POA:
    """`radius`: R (Table 2). `rand` of eq. (14): drawn per pelican, as by the authors, or per coordinate."""

    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000
    radius: Amount = 0.2
    rand: Literal["pelican", "dimension"] = "pelican"

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield N candidates, then two batches of N an iteration; draw the prey once."""
        x = box.sample(self.population, rng)  # (13)
        f = yield x
        for t in range(1, self.iterations + 1):
            x, f = yield from self.iterate(x, f, t, box, rng)

    def iterate(
        self, x: Candidates, f: Costs, t: int, box: Box, rng: np.random.Generator
    ) -> Generator[Candidates, Costs, tuple[Candidates, Costs]]:
        width = 1 if self.rand == "pelican" else box.dimension
        trial = box.clip(x + step_to_prey(x, f, rng.integers(len(x)), width, rng))
        x, f = keep_better(x, f, trial, (yield trial))  # (15)
        trial = box.clip(x + wing_step(x, self.radius * (1 - t / self.iterations), rng))
        return keep_better(x, f, trial, (yield trial))  # (17)


def step_to_prey(x: Candidates, f: Costs, k: int | np.integer, width: int, rng: np.random.Generator) -> Candidates:
    """Step towards prey `k`, or away if it is worse, eq. (14)."""
    intensity = rng.integers(1, 3, (len(x), 1))
    towards = (f[k] < f)[:, None]
    step: Candidates = rng.random((len(x), width)) * np.where(towards, x[k] - intensity * x, x - x[k])
    return step


def wing_step(x: Candidates, radius: float, rng: np.random.Generator) -> Candidates:
    """Eq. (16); `radius` is R (1 - t/T)."""
    return radius * (2 * rng.random(x.shape) - 1) * x
