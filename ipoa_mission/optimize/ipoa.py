"""IPOA, the multi-strategy improved pelican algorithm (Qiu, Dai and Zhao, Biomimetics 2024, 9, 647), section 4.2.

As printed, eq. (27) fails for an optimum away from the origin (`reading="literal"`). Costs 2 N + 3 N T evaluations.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ipoa_mission.optimize.poa import step_to_prey, wing_step
from ipoa_mission.optimize.search import (
    SHORT_SETTINGS,
    Amount,
    Box,
    Candidates,
    Count,
    Fraction,
    Members,
    Search,
    keep_better,
)


@dataclass(frozen=True)
class IPOA:
    """POA with a chaotic and refracted start, an inertia weight, Levy flights and a t-distributed mutation.

    Defaults are those of Table 2, which lacks k n of eq. (20) and the range of eq. (29).

    Attributes:
        population: N.
        iterations: T.
        radius: R of (16).
        chaos: a of (18).
        refraction: k n of (20); 1 is plain opposition.
        beta: of (25).
        freedom_least: degrees of freedom at t = 0, (29); 1 is Cauchy.
        freedom_most: at t = T; 30 is nearly Gaussian.
        chaotic_start: (18)-(21), else uniform.
        inertia: (22), (23).
        levy: (24)-(27), else POA's exploitation.
        mutation: (28)-(30).
        reading: the factor of s in (27).
        weight: omega of (22).
        prey: a member, or the best one.
        mutated: (30) for each, for the best only; (28) around each.
        rand: of (23), for each pelican (as POA's authors) or coordinate.
        steps: s of (27) and t(nu) of (30), likewise.
        share: factor on s; 0.01 in cuckoo search and Harris hawks.

    Example:
        >>> IPOA(iterations=200, mutation=False).population
        30
    """

    short_settings: ClassVar = SHORT_SETTINGS
    population: Members = 30
    iterations: Count = 1000
    radius: Amount = 0.2
    chaos: Annotated[float, Field(ge=0.01, le=1)] = 0.7
    refraction: Annotated[float, Field(ge=0.01)] = 1.0
    beta: Annotated[float, Field(ge=0.3, le=1.99)] = 1.5
    freedom_least: Annotated[float, Field(ge=0.1)] = 1.0
    freedom_most: Annotated[float, Field(ge=0.1)] = 30.0

    chaotic_start: bool = True
    inertia: bool = True
    levy: bool = True
    mutation: bool = True

    reading: Literal["step", "literal", "survivor"] = "step"
    weight: Literal["exp(t/T)", "exp(t/T-1)", "exp(t/T)-1"] = "exp(t/T)"
    prey: Literal["member", "best"] = "member"
    mutated: Literal["each", "best", "own"] = "each"
    rand: Literal["pelican", "dimension"] = "pelican"
    steps: Literal["pelican", "dimension"] = "dimension"
    share: Fraction = 1.0

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        """Yield 2 N candidates of `box` by `rng` (N if not chaotic), then two or three batches an iteration."""
        n = self.population
        d = box.dimension
        rands, steps = (1 if drawn_for == "pelican" else d for drawn_for in (self.rand, self.steps))
        if self.chaotic_start:
            chaotic = iterate_chaotic_map(self.chaos, n, d, rng)  # (18)
            first = box.lower + (chaotic + 1) / 2 * (box.upper - box.lower)
            both = np.concatenate([first, box.clip(refract(first, box, self.refraction))])  # (21)
            costs = yield both
            best_half = np.argsort(costs, kind="stable")[:n]
            x, f = both[best_half], costs[best_half]
        else:
            x = box.sample(n, rng)  # (13)
            f = yield x

        for t in range(1, self.iterations + 1):
            done = t / self.iterations
            k = int(np.argmin(f)) if self.prey == "best" else int(rng.integers(n))

            # (23) and (15)
            step = step_to_prey(x, f, k, rands, rng)
            trial = box.clip((self._omega(done) * x if self.inertia else x) + step)
            x, f = keep_better(x, f, trial, (yield trial))

            # (16) with the Levy flight (27), and (17)
            step = wing_step(x, self.radius * (1 - done), rng)
            if not self.levy:
                trial = box.clip(x + step)
            else:
                s = self.share * levy_factor(self.beta, (n, steps), rng)
                if self.reading == "step":
                    trial = box.clip(x + s * step)
                elif self.reading == "literal":
                    trial = box.clip((1 + s) * (x + step))
                else:
                    trial = box.clip(x + step)
                    x, f = keep_better(x, f, trial, (yield trial))
                    trial = box.clip((1 + s) * x)
            x, f = keep_better(x, f, trial, (yield trial))

            # (30), with (17) as acceptance
            if self.mutation:
                nu = self.freedom_least + (self.freedom_most - self.freedom_least) * done  # (29)
                b = int(np.argmin(f))
                if self.mutated == "best":
                    trial = box.clip(x[b] + x[b] * rng.standard_t(nu, (1, steps)))
                    (g,) = yield trial
                    if g < f[b]:
                        x, f = x.copy(), f.copy()
                        x[b] = trial[0]
                        f[b] = g
                else:
                    center = x[b] if self.mutated == "each" else x
                    trial = box.clip(center + center * rng.standard_t(nu, (n, steps)))
                    x, f = keep_better(x, f, trial, (yield trial))

    def _omega(self, done: float) -> float:
        """Return the inertia weight, (22); `done` is t/T."""
        if self.weight == "exp(t/T)":
            return math.exp(done)
        return math.exp(done - 1) if self.weight == "exp(t/T-1)" else math.expm1(done)


def iterate_chaotic_map(a: float, count: int, width: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return iterates of the chaotic map, eq. (18), (count, width), in [-1, 1]."""
    z = np.empty((count, width))
    last = 1 - 2 * (1 - rng.random(width)) + np.finfo(float).tiny
    for row in z:
        row[:] = last = np.sin(a * np.pi / last)
    return z


def refract(x: Candidates, box: Box, kn: float) -> Candidates:
    """Return the refracted opposites of `x`, eq. (20)."""
    middle = (box.lower + box.upper) / 2
    return middle + middle / kn - x / kn


def levy_factor(beta: float, shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return factors s by Mantegna's algorithm, eqs. (25) and (26)."""
    sigma_u = (
        math.gamma(1 + beta)
        * math.sin(math.pi * beta / 2)
        / (math.gamma((1 + beta) / 2) * beta * 2 ** ((beta - 1) / 2))
    ) ** (1 / beta)
    u, v = rng.standard_normal((2, *shape))
    factor: NDArray[np.float64] = sigma_u * u / np.abs(v) ** (1 / beta)
    return factor
