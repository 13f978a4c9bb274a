"""Make Tables 3 and 4, and tests of the printed values."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.paper.markdown_table import Table, factor, number, ours_and_print
from ipoa_mission.paper.problems import FUNCTIONS, OPTIMA
from ipoa_mission.paper.published import ALGORITHMS, PRINTED, RIVALS_OF_TABLE_4
from ipoa_mission.paper.rows import TrialRow, mean_evaluations, mean_results, results, runs_of
from ipoa_mission.paper.statistics import against, holm, places, rank_sum, ranking

FLOOR = 1e-8  # smaller errors count as this, as in the CEC competitions


def mean_log_error(rows: Sequence[TrialRow], algorithm: str, settings: str = "{}") -> float:
    """Return log10 of the mean error, averaged over the functions."""
    means = [max(results(rows, function, algorithm, settings=settings).mean(), FLOOR) for function in FUNCTIONS]
    return float(np.mean(np.log10(means)))


def off_the_print(rows: Sequence[TrialRow], settings: str) -> float:
    """Return the mean of |ln(IPOA's mean error / the printed one)|."""
    ratios = [
        results(rows, f, "ipoa", settings=settings).mean() / (PRINTED["table_3"][f]["mean"][0] - optimum)
        for f, optimum in zip(FUNCTIONS, OPTIMA, strict=True)
    ]
    return float(np.mean(np.abs(np.log(ratios))))


def table_3(rows: Sequence[TrialRow]) -> Table:
    metrics: dict[str, Callable[[NDArray[np.float64]], float]] = {
        "best": lambda costs: float(costs.min()),
        "mean": lambda costs: float(costs.mean()),
        "sd": lambda costs: float(costs.std(ddof=1)) if len(costs) > 1 else 0.0,
    }
    lines = []
    firsts = 0
    printed_firsts = 0
    for function, optimum in zip(FUNCTIONS, OPTIMA, strict=True):
        costs = [results(rows, function, name) + optimum for name in ALGORITHMS]
        for metric, of in metrics.items():
            ours = [of(sample) for sample in costs]
            theirs = PRINTED["table_3"][function][metric]
            least = 0.0 if metric == "sd" else optimum
            ratios = (factor(o - least, t - least) for o, t in zip(ours, theirs, strict=True))
            cells = ours_and_print(ours, theirs, (number, number))
            firsts += places(ours)[0] == 1
            printed_firsts += places(theirs)[0] == 1
            lines.append([function, metric, *(" · ".join(both) for both in zip(cells, ratios, strict=True))])
    means = mean_results(rows, FUNCTIONS, ALGORITHMS)
    widest = np.sqrt(30) * (PRINTED["table_3"]["f7"]["mean"][2] - PRINTED["table_3"]["f7"]["best"][2])
    printed_means = np.array([PRINTED["table_3"][f]["mean"] for f in FUNCTIONS])
    return Table(
        f"Table 3. CEC2022, D = 20, {runs_of(rows)} runs. Each cell: ours (place) · printed (place) · "
        "ratio of the errors (of SD itself).",
        ["", "", *(name.upper() for name in ALGORITHMS)],
        lines,
        [
            f"IPOA is first in {firsts} of 36 here; in print in {printed_firsts} (its text says 25).",
            f"Mean rank over the functions by mean cost, here: {ranking(ALGORITHMS, means)}.",
            f"Printed: {ranking(ALGORITHMS, printed_means)}.",
            f"The printed SD of POA on f7, {PRINTED['table_3']['f7']['sd'][2]}, is impossible: thirty numbers cannot "
            "have an SD above √30 times their mean less their least, here "
            f"{widest:.0f}. The place printed for it, 4, matches 28.35.",
            f"Mean evaluations of a run: {mean_evaluations(rows, ALGORITHMS)}. MPOA is inferred, see its module.",
        ],
    )


def table_4(rows: Sequence[TrialRow]) -> Table:
    """Compare p of rank-sum tests, corrected by Holm over all sixty, with the printed p."""
    rivals = RIVALS_OF_TABLE_4
    raw = [rank_sum(results(rows, f, "ipoa"), results(rows, f, rival)) for rival in rivals for f in FUNCTIONS]
    compared = against(lambda name, f: results(rows, f, name), "ipoa", rivals, FUNCTIONS)
    signs = [sign for outcomes in compared.values() for sign in outcomes]
    cells = [f"{p:.2g}, Holm {q:.2g} ({sign})" for p, q, sign in zip(raw, holm(raw), signs, strict=True)]
    columns = [cells[k : k + len(FUNCTIONS)] for k in range(0, len(cells), len(FUNCTIONS))]
    printed = [p for outcomes in PRINTED["table_4"].values() for p in outcomes]
    return Table(
        f"Table 4. Wilcoxon rank-sum, IPOA against each, {runs_of(rows)} runs. Each cell: our p, with Holm's "
        "correction over all sixty (+ IPOA better, - worse, = no difference at 0.05) · printed p.",
        ["", *(name.upper() for name in rivals)],
        [
            [f, *(f"{cell} · {p:.2g}" for cell, p in zip(row, PRINTED["table_4"][f], strict=True))]
            for f, row in zip(FUNCTIONS, zip(*columns, strict=True), strict=True)
        ],
        [
            f"IPOA is better in {signs.count('+')} and worse in {signs.count('-')} of {len(signs)}; "
            f"{signs.count('=')} show no difference.",
            f"Printed p values below 0.05 (uncorrected): {sum(p < 0.05 for p in printed)} of {len(printed)}.",
        ],
    )


def contradictions() -> Table:
    """List pairs whose printed Tables 3 and 4 contradict: distant means, but a large p.

    By Samuelson, no sample of n is over sqrt(n - 1) standard deviations above its mean. If that is below the rival's
    best, p is 3.02e-11.
    """
    lines = []
    for function in FUNCTIONS:
        printed = PRINTED["table_3"][function]
        mean = printed["mean"]
        sd = printed["sd"]
        best = printed["best"]
        for rival, p in zip(RIVALS_OF_TABLE_4, PRINTED["table_4"][function], strict=True):
            k = ALGORITHMS.index(rival)
            apart = (mean[k] - mean[0]) / np.sqrt((sd[k] ** 2 + sd[0] ** 2) / 30)
            worst = mean[0] + sd[0] * np.sqrt(29)
            if p > 0.05 and abs(apart) > 6:
                lines.append(
                    [
                        function,
                        rival.upper(),
                        f"{number(mean[0])} ± {number(sd[0])}",
                        f"{number(mean[k])} ± {number(sd[k])}",
                        f"{apart:.1f}",
                        f"{p}",
                        f"{number(worst)} {'<' if worst < best[k] else 'against'} {number(best[k])}",
                    ]
                )
    return Table(
        "Contradictions in print: the printed means differ by more than six standard errors, "
        "but the printed p shows no difference.",
        [
            "",
            "rival",
            "IPOA, mean ± SD",
            "rival, mean ± SD",
            "standard errors apart",
            "printed p",
            "IPOA's worst at most, and the rival's best",
        ],
        lines,
        [
            "No number of a sample of thirty is more than √29 standard deviations above its mean. With < in the last "
            "column all of IPOA's results were below all of the rival's, and p can only be 3.0e-11."
        ],
    )


def dimension_of_the_print(rows_20: Sequence[TrialRow], rows_10: Sequence[TrialRow]) -> Table:
    lines = []
    for function, optimum in zip(FUNCTIONS, OPTIMA, strict=True):
        printed = np.array(PRINTED["table_3"][function]["mean"]) - optimum
        ours = {
            dimension: np.maximum(mean_results(rows, [function], ALGORITHMS)[0], FLOOR)
            for dimension, rows in ((20, rows_20), (10, rows_10))
        }
        off = {dimension: float(np.mean(np.abs(np.log(means / printed)))) for dimension, means in ours.items()}
        lines.append(
            [
                function,
                f"{number(printed.min())} to {number(printed.max())}",
                f"{number(ours[20].min())} to {number(ours[20].max())}",
                f"{number(ours[10].min())} to {number(ours[10].max())}",
                f"{off[20]:.2f}",
                f"{off[10]:.2f}",
                "D = 20" if off[20] < off[10] else "**D = 10**",
            ]
        )
    return Table(
        "Which dimension the printed Table 3 shows: least and greatest mean error of the six algorithms, "
        "and the mean of |ln(ours / printed)|.",
        ["", "printed", "ours, D = 20", "ours, D = 10", "off, D = 20", "off, D = 10", "nearer"],
        lines,
    )
