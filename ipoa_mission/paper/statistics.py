from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

Samples: TypeAlias = Sequence[float] | NDArray[np.float64]


def rank_sum(a: Samples, b: Samples) -> float:
    """Return p of the two-sided Wilcoxon rank-sum test, normal approximation with continuity correction."""
    if len({*a, *b}) == 1:
        return 1.0
    return float(scipy.stats.mannwhitneyu(a, b, alternative="two-sided", method="asymptotic").pvalue)


def holm(p: Sequence[float]) -> list[float]:
    """Return p values corrected by Holm's step-down method."""
    order = np.argsort(p, kind="stable")
    corrected = np.maximum.accumulate((len(p) - np.arange(len(p))) * np.asarray(p, dtype=float)[order])
    result = np.empty(len(p))
    result[order] = np.minimum(corrected, 1)
    return [float(c) for c in result]


def compare_pairs(pairs: Sequence[tuple[Samples, Samples]]) -> list[str]:
    """Return "+" (the first is lower), "-" or "=" for each pair, by rank sums at 0.05 with Holm's correction."""
    signs = []
    for (a, b), p in zip(pairs, holm([rank_sum(a, b) for a, b in pairs]), strict=True):
        lower = "+" if scipy.stats.mannwhitneyu(a, b).statistic < len(a) * len(b) / 2 else "-"
        signs.append(lower if p < 0.05 else "=")
    return signs


def count_signs(signs: Sequence[str]) -> str:
    return " / ".join(str(signs.count(sign)) for sign in "+=-")


def post_hoc(mean_ranks: NDArray[np.float64], blocks: int, control: int) -> list[float]:
    """Return p of each treatment against `control`, by Holm: Demsar, JMLR 2006, 7, 1, section 3.2.2."""
    k = len(mean_ranks)
    z = (mean_ranks - mean_ranks[control]) / np.sqrt(k * (k + 1) / (6 * blocks))
    p = 2 * scipy.stats.norm.sf(np.abs(z))
    corrected = holm(np.delete(p, control).tolist())
    return [*corrected[:control], 1.0, *corrected[control:]]


def places(values: Sequence[float]) -> list[int]:
    """Return ranks, 1 for the least; equals share the better one."""
    return [int(r) for r in scipy.stats.rankdata(values, method="min")]


def ranking(names: Sequence[str], costs: NDArray[np.float64]) -> str:
    """Describe Friedman's test on `costs` (blocks, names), against IPOA."""
    ranks = scipy.stats.rankdata(costs, axis=1).mean(axis=0)
    own = names.index("ipoa")
    in_order = sorted(zip(ranks, names, post_hoc(ranks, len(costs), own), strict=True))
    signs = {name: "=" if p >= 0.05 else "+" if ranks[own] < rank else "-" for rank, name, p in in_order}
    return (
        ", ".join(f"{name} {rank:.2f}" for rank, name, _ in in_order)
        + f" (Friedman p = {scipy.stats.friedmanchisquare(*costs.T).pvalue:.1e}; after it ipoa against "
        + ", ".join(f"{name} {p:.2g} ({signs[name]})" for _, name, p in in_order if name != "ipoa")
        + ", Holm)"
    )
