"""The tests that tell a difference from chance, and the corrections that many comparisons need."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

Samples: TypeAlias = Sequence[float] | NDArray[np.float64]


def rank_sum(a: Samples, b: Samples) -> float:
    """p of the Wilcoxon rank-sum test, two-sided, by the normal approximation with continuity correction.

    The paper's: two samples of thirty without overlap give 3.0199e-11, which its Table 4 shows many times.
    """
    if len({*a, *b}) == 1:
        return 1.0
    return float(scipy.stats.mannwhitneyu(a, b, alternative="two-sided", method="asymptotic").pvalue)


def holm(p: Sequence[float]) -> list[float]:
    """p values corrected by Holm's step-down method: the chance of even one false alarm among all stays at alpha."""
    order = np.argsort(p, kind="stable")
    corrected = np.maximum.accumulate((len(p) - np.arange(len(p))) * np.asarray(p, dtype=float)[order])
    result = np.empty(len(p))
    result[order] = np.minimum(corrected, 1)
    return [float(c) for c in result]


def told_apart(pairs: Sequence[tuple[Samples, Samples]]) -> list[str]:
    """For each pair of samples of costs: is the first told from the second, and how?

    "+" the first is lower, "-" it is higher, by the rank-sum test with Holm's correction over all pairs; "=" at 0.05
    they are not told apart.
    """
    corrected = holm([rank_sum(a, b) for a, b in pairs])
    return ["=" if p >= 0.05 else "+" if _is_lower(a, b) else "-" for (a, b), p in zip(pairs, corrected, strict=True)]


def against(
    of: Callable[[str, str], Samples], ours: str, rivals: Sequence[str], cases: Sequence[str]
) -> dict[str, list[str]]:
    """For each rival, case by case: is `ours` told to be lower (+), higher (-), or neither (=)?

    `of` gives the sample of a name on a case; Holm's correction is over all of them.
    """
    signs = iter(told_apart([(of(ours, case), of(rival, case)) for rival in rivals for case in cases]))
    return {rival: [next(signs) for _ in cases] for rival in rivals}


def counted(signs: Sequence[str]) -> str:
    """How many are lower, not told apart and higher."""
    return " / ".join(str(signs.count(sign)) for sign in "+=-")


def _is_lower(a: Samples, b: Samples) -> bool:
    """Whether a number of `a` is more often below one of `b` than above it."""
    return bool(scipy.stats.mannwhitneyu(a, b).statistic < len(a) * len(b) / 2)


@dataclass(frozen=True)
class Friedman:
    """Mean rank of each treatment (1 is best), over how many blocks, the test statistic, and its p."""

    mean_ranks: NDArray[np.float64]
    blocks: int
    statistic: float
    p: float


def friedman(costs: NDArray[np.float64]) -> Friedman:
    """Friedman's test on `costs` (blocks, treatments), three treatments or more: do all rank alike over the blocks?"""
    ranks = scipy.stats.rankdata(costs, axis=1)
    result = scipy.stats.friedmanchisquare(*costs.T)
    return Friedman(ranks.mean(axis=0), len(costs), float(result.statistic), float(result.pvalue))


def post_hoc(test: Friedman, control: int) -> list[float]:
    """p of each treatment against the one at index `control` (itself 1), by mean rank, corrected by Holm.

    The normal approximation that follows a Friedman test: Demsar, JMLR 2006, 7, 1, section 3.2.2.
    """
    k = len(test.mean_ranks)
    z = (test.mean_ranks - test.mean_ranks[control]) / np.sqrt(k * (k + 1) / (6 * test.blocks))
    p = 2 * scipy.stats.norm.sf(np.abs(z))
    others = [i for i in range(k) if i != control]
    corrected = np.ones(k)
    corrected[others] = holm(p[others].tolist())
    return [float(c) for c in corrected]


def places(values: Sequence[float]) -> list[int]:
    """The place of each value, 1 for the least; equals share the better place."""
    return [int(r) for r in scipy.stats.rankdata(values, method="min")]


def ranking(names: Sequence[str], costs: NDArray[np.float64], control: str = "ipoa") -> str:
    """What the test says of `costs` (blocks, names), and how the others compare with `control` after it."""
    test = friedman(costs)
    own = names.index(control)
    p = post_hoc(test, own)
    signs = {
        name: "=" if p[i] >= 0.05 else "+" if test.mean_ranks[own] < test.mean_ranks[i] else "-"
        for i, name in enumerate(names)
        if i != own
    }
    in_order = sorted(zip(test.mean_ranks, names, p, strict=True))
    return (
        ", ".join(f"{name} {rank:.2f}" for rank, name, _ in in_order)
        + f" (Friedman p = {test.p:.1e}; after it {control} against "
        + ", ".join(f"{name} {q:.2g} ({signs[name]})" for _, name, q in in_order if name != control)
        + ", Holm)"
    )
