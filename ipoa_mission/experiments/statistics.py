"""The tests that tell a difference from chance, and the correction that many comparisons need."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats


def rank_sum(a: Sequence[float], b: Sequence[float]) -> float:
    """p of the Wilcoxon rank-sum test, two-sided, by the normal approximation with continuity correction.

    The paper's: two samples of thirty without overlap give 3.0199e-11, which its Table 4 shows many times.
    """
    if len({*a, *b}) == 1:
        return 1.0
    return float(stats.mannwhitneyu(a, b, alternative="two-sided", method="asymptotic").pvalue)


def holm(p: Sequence[float]) -> list[float]:
    """p values corrected by Holm's step-down method: the chance of even one false alarm among all stays at alpha."""
    order = np.argsort(p, kind="stable")
    corrected = np.maximum.accumulate((len(p) - np.arange(len(p))) * np.asarray(p, dtype=float)[order])
    result = np.empty(len(p))
    result[order] = np.minimum(corrected, 1)
    return [float(c) for c in result]


@dataclass(frozen=True)
class Friedman:
    """Mean rank of each treatment (1 is best), the test statistic, and its p."""

    mean_ranks: NDArray[np.float64]
    statistic: float
    p: float


def friedman(costs: NDArray[np.float64]) -> Friedman:
    """Friedman's test on `costs` (blocks, treatments), three treatments or more: do all rank alike over the blocks?"""
    ranks = stats.rankdata(costs, axis=1)
    result = stats.friedmanchisquare(*costs.T)
    return Friedman(ranks.mean(axis=0), float(result.statistic), float(result.pvalue))


def places(values: Sequence[float]) -> list[int]:
    """The place of each value, 1 for the least; equals share the better place."""
    return [int(r) for r in stats.rankdata(values, method="min")]
