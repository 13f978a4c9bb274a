"""Tables 3 and 4 of the paper, and what it lacks on the same functions: each a pure function of rows of runs."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.experiments import published
from ipoa_mission.experiments.cec2022 import FUNCTIONS, OPTIMA
from ipoa_mission.experiments.rows import Row, settings_text
from ipoa_mission.experiments.series import ABLATION, BEYOND, EQUAL
from ipoa_mission.experiments.statistics import friedman, holm, places, rank_sum
from ipoa_mission.experiments.tables import Table, number, per_cent

_FLOOR = 1e-8  # errors below it count as it, as the CEC competitions have it
_METRICS: dict[str, Callable[[NDArray[np.float64]], float]] = {
    "best": lambda costs: float(costs.min()),
    "mean": lambda costs: float(costs.mean()),
    "sd": lambda costs: float(costs.std(ddof=1)) if len(costs) > 1 else 0.0,
}


def errors(rows: Sequence[Row], function: str, algorithm: str, settings: str = "{}") -> NDArray[np.float64]:
    """Cost less the optimum of every run, in the order of the runs."""
    found = [
        (row.trial.run, row.cost)
        for row in rows
        if (row.trial.case, row.trial.algorithm, row.trial.settings) == (function, algorithm, settings)
    ]
    return np.array([cost for _, cost in sorted(found)])


def mean_log_error(rows: Sequence[Row], algorithm: str, settings: str = "{}") -> float:
    """log10 of the mean error, averaged over the twelve functions: how near the optimum a method comes."""
    means = [max(errors(rows, function, algorithm, settings).mean(), _FLOOR) for function in FUNCTIONS]
    return float(np.mean(np.log10(means)))


def table_3(rows: Sequence[Row]) -> Table:
    """Best, mean and SD on CEC2022 at D = 20: ours and its place, the printed value and its place, the difference."""
    lines, firsts = [], 0
    for function, optimum in zip(FUNCTIONS, OPTIMA, strict=True):
        costs = [errors(rows, function, name) + optimum for name in published.ALGORITHMS]
        for metric, of in _METRICS.items():
            ours = [of(sample) for sample in costs]
            theirs = published.TABLE_3[function][metric]
            place, printed = places(ours), places(theirs)
            firsts += place[0] == 1
            lines.append(
                [
                    function,
                    metric,
                    *(
                        f"{number(o)} ({p}) · {number(t)} ({q}) · {per_cent(o, t)}"
                        for o, p, t, q in zip(ours, place, theirs, printed, strict=True)
                    ),
                ]
            )
    printed_firsts = sum(
        places(published.TABLE_3[function][metric])[0] == 1 for function in FUNCTIONS for metric in _METRICS
    )
    ranks = friedman(np.array([[errors(rows, f, name).mean() for name in published.ALGORITHMS] for f in FUNCTIONS]))
    printed_ranks = friedman(np.array([published.TABLE_3[f]["mean"] for f in FUNCTIONS]))
    return Table(
        f"Table 3. CEC2022, D = 20, {_runs(rows)} runs. Each cell: ours (place) · printed (place) · difference.",
        ["", "", *(name.upper() for name in published.ALGORITHMS)],
        lines,
        [
            f"IPOA is first in {firsts} of 36 here; the print has it first in {printed_firsts} (its text says 25).",
            "Mean rank over the functions by mean cost, here: "
            + _listed(published.ALGORITHMS, ranks.mean_ranks)
            + f" (Friedman p = {ranks.p:.1e}); printed: "
            + _listed(published.ALGORITHMS, printed_ranks.mean_ranks)
            + f" (p = {printed_ranks.p:.1e}).",
            "Mean evaluations of a run: "
            + ", ".join(
                f"{name.upper()} {np.mean([r.evaluations for r in rows if r.trial.algorithm == name]):,.0f}"
                for name in published.ALGORITHMS
            )
            + ". MPOA is inferred, see its module.",
        ],
    )


def table_4(rows: Sequence[Row]) -> Table:
    """Rank-sum tests of IPOA against each rival: ours, corrected by Holm over all sixty, and the printed p."""
    rivals = published.RIVALS_OF_TABLE_4
    pairs = [(function, rival) for function in FUNCTIONS for rival in rivals]
    raw = [rank_sum(errors(rows, f, "ipoa").tolist(), errors(rows, f, rival).tolist()) for f, rival in pairs]
    corrected = dict(zip(pairs, zip(raw, holm(raw), strict=True), strict=True))
    lines, wins, losses = [], 0, 0
    for function in FUNCTIONS:
        cells = [function]
        for rival, printed in zip(rivals, published.TABLE_4[function], strict=True):
            p, with_holm = corrected[function, rival]
            better = np.median(errors(rows, function, "ipoa")) < np.median(errors(rows, function, rival))
            sign = "=" if with_holm >= 0.05 else "+" if better else "-"
            wins, losses = wins + (sign == "+"), losses + (sign == "-")
            cells.append(f"{p:.2g}, Holm {with_holm:.2g} ({sign}) · {printed:.2g}")
        lines.append(cells)
    return Table(
        f"Table 4. Wilcoxon rank-sum, IPOA against each, {_runs(rows)} runs. Each cell: our p, with Holm's correction "
        "over all sixty (+ IPOA better, - worse, = not told apart at 0.05) · printed p.",
        ["", *(name.upper() for name in rivals)],
        lines,
        [
            f"IPOA is better in {wins}, worse in {losses} and not told apart in {60 - wins - losses} of 60.",
            "Printed p values below 0.05 (uncorrected): "
            + f"{sum(p < 0.05 for row in published.TABLE_4.values() for p in row)} of 60.",
        ],
    )


def contradictions() -> Table:
    """Where the printed Table 4 cannot belong to the printed Table 3: far means, and yet a large p.

    No number of a sample of n lies more than sqrt(n - 1) standard deviations above its mean (Samuelson): where even
    that is below the rival's best, all of IPOA's results are below all of the rival's, and p is 3.02e-11.
    """
    lines = []
    for function in FUNCTIONS:
        printed = published.TABLE_3[function]
        mean, sd, best = printed["mean"], printed["sd"], printed["best"]
        for rival, p in zip(published.RIVALS_OF_TABLE_4, published.TABLE_4[function], strict=True):
            k = published.ALGORITHMS.index(rival)
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
        "The print against itself: pairs whose printed means lie more than six standard errors apart, "
        "and whose printed p says that they cannot be told apart.",
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
            "No number of a sample of thirty lies more than √29 standard deviations above its mean. Where the last "
            "column has <, every one of IPOA's results was below every one of the rival's, and p can only be 3.0e-11."
        ],
    )


def dimension_of_the_print(rows_20: Sequence[Row], rows_10: Sequence[Row]) -> Table:
    """To which dimension the printed means lie nearer, function by function, over the six algorithms."""
    lines = []
    for function, optimum in zip(FUNCTIONS, OPTIMA, strict=True):
        printed = np.array(published.TABLE_3[function]["mean"]) - optimum
        ours = {
            d: np.array([max(errors(rows, function, name).mean(), _FLOOR) for name in published.ALGORITHMS])
            for d, rows in ((20, rows_20), (10, rows_10))
        }
        off = {d: float(np.mean(np.abs(np.log(o / printed)))) for d, o in ours.items()}
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


def table_beyond(rows: Sequence[Row], paper: Sequence[Row]) -> Table:
    """Mean error of the rivals beyond the paper, beside IPOA and the best of the paper's other five."""
    everyone = [*rows, *paper]
    names = [*BEYOND, *published.ALGORITHMS]
    lines = []
    for function in FUNCTIONS:
        means = [errors(everyone, function, name).mean() for name in names]
        lines.append([function, *(f"{number(m)} ({p})" for m, p in zip(means, places(means), strict=True))])
    lines.append(["mean log10", *(f"**{mean_log_error(everyone, name):.2f}**" for name in names)])
    costs = np.array([[errors(everyone, f, name).mean() for name in names] for f in FUNCTIONS])
    ranks = friedman(np.maximum(costs, _FLOOR))
    ours, rest = BEYOND[0], names[1:]
    notes = [
        f"Mean error (place), {_runs(rows)} runs; the last line is log10 of it, errors below 1e-8 counted as 1e-8, "
        "averaged over the functions. "
        f"The first {len(BEYOND)} spent 90,060 evaluations a run, the paper's six what N = 30 and T = 1000 gives them.",
        "Mean rank: " + _listed(names, ranks.mean_ranks) + f" (Friedman p = {ranks.p:.1e}).",
    ]
    for rival in [*rest[: len(BEYOND) - 1], "ipoa"]:
        raw = [
            rank_sum(
                np.maximum(errors(everyone, f, ours), _FLOOR).tolist(),
                np.maximum(errors(everyone, f, rival), _FLOOR).tolist(),
            )
            for f in FUNCTIONS
        ]
        signs = [
            "=" if p >= 0.05 else "+" if errors(everyone, f, ours).mean() < errors(everyone, f, rival).mean() else "-"
            for f, p in zip(FUNCTIONS, holm(raw), strict=True)
        ]
        notes.append(
            f"{ours} against {rival} (rank-sum, Holm over the twelve, 0.05): better on {signs.count('+')}, "
            f"worse on {signs.count('-')}, not told apart on {signs.count('=')}."
        )
    return Table("Beyond the paper: CEC2022, D = 20.", ["", *names], lines, notes)


def table_equal(rows: Sequence[Row]) -> Table:
    """The six at the same number of evaluations: what is left of the places when nobody is given more."""
    settings = {name: settings_text(**wanted) for name, wanted in EQUAL.items()}
    lines = []
    for function in FUNCTIONS:
        means = [errors(rows, function, name, settings[name]).mean() for name in EQUAL]
        lines.append([function, *(f"{number(m)} ({p})" for m, p in zip(means, places(means), strict=True))])
    lines.append(["mean log10", *(f"**{mean_log_error(rows, name, settings[name]):.2f}**" for name in EQUAL)])
    spent = ", ".join(
        f"{name.upper()} {np.mean([r.evaluations for r in rows if r.trial.algorithm == name]):,.0f}" for name in EQUAL
    )
    return Table(
        f"The six at equal budget: mean error (place), CEC2022, D = 20, 90,060 evaluations, {_runs(rows)} runs.",
        ["", *(name.upper() for name in EQUAL)],
        lines,
        [f"Iterations are set so that each spends the budget; mean evaluations: {spent}."],
    )


def table_ablation(rows: Sequence[Row]) -> Table:
    """IPOA with each strategy off and each other reading, one at a time."""
    base = settings_text()
    lines = []
    for label, wanted in ABLATION.items():
        settings = settings_text(**wanted)
        raw = [
            rank_sum(errors(rows, f, "ipoa").tolist(), errors(rows, f, "ipoa", settings).tolist()) for f in FUNCTIONS
        ]
        means = [errors(rows, f, "ipoa", settings).mean() for f in FUNCTIONS]
        signs = [
            "=" if p >= 0.05 else "+" if m < errors(rows, f, "ipoa").mean() else "-"
            for f, p, m in zip(FUNCTIONS, holm(raw), means, strict=True)
        ]
        printed = [
            abs(np.log(m / (published.TABLE_3[f]["mean"][0] - o)))
            for f, m, o in zip(FUNCTIONS, means, OPTIMA, strict=True)
        ]
        lines.append(
            [
                label,
                f"{mean_log_error(rows, 'ipoa', settings):.2f}",
                "-" if settings == base else f"{signs.count('+')} / {signs.count('=')} / {signs.count('-')}",
                f"{np.mean(printed):.2f}",
                *(number(m) for m in means),
            ]
        )
    return Table(
        f"Ablation and readings: IPOA on CEC2022, D = 20, {_runs(rows)} runs.",
        ["", "mean log10 error", "better / same / worse than the first", "off the print", *FUNCTIONS],
        lines,
        [
            "Better, same, worse: functions on which the rank-sum test with Holm's correction says so at 0.05. "
            "Off the print: mean of |ln(our mean error / the printed one)|; 0 is a perfect match. "
            "The twelve columns are mean errors."
        ],
    )


def _runs(rows: Sequence[Row]) -> int:
    return 1 + max(row.trial.run for row in rows)


def _listed(names: Sequence[str], values: NDArray[np.float64]) -> str:
    return ", ".join(
        f"{name} {value:.2f}" for name, value in sorted(zip(names, values, strict=True), key=lambda p: p[1])
    )
