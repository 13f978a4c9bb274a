"""Make the paper's Tables 3 to 8, and tests of the printed values.

Its maps are unpublished: of Tables 5 to 8 only ranks and ratios compare.
"""

import tomllib
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.paper.markdown_table import Table, factor, number, ours_and_print, per_cent
from ipoa_mission.paper.problems import FUNCTIONS, OPTIMA, WEIGHTS
from ipoa_mission.paper.runs import ALGORITHMS, TrialRow, mean_evaluations, mean_results, results, runs_of
from ipoa_mission.paper.statistics import compare_pairs, count_signs, holm, places, rank_sum, ranking

FLOOR = 1e-8  # smaller errors count as this, as in the CEC competitions
RIVALS_OF_TABLE_4 = ("dbo", "poa", "ssa", "hho", "mpoa")
#: Printed numbers by table, part (function, experiment or map), and measure. `table_4` has p against
#: `RIVALS_OF_TABLE_4`.
PRINTED: dict[str, Any] = tomllib.loads(
    files("ipoa_mission.paper").joinpath("published.toml").read_text(encoding="utf-8")
)


def improved(where: str) -> list[dict[str, list[float]]]:
    """Return the printed parts that a claim in the text is about: "Table 6" or "Table 7, 10 obstacles"."""
    name, _, obstacles = where.removesuffix(" obstacles").partition(", ")
    table = PRINTED[name.lower().replace(" ", "_")]
    return [table[obstacles]] if obstacles else [table] if name == "Table 8" else list(table.values())


def _spread(costs: NDArray[np.float64]) -> dict[str, float]:
    return {"best": costs.min(), "mean": costs.mean(), "sd": costs.std(ddof=min(1, len(costs) - 1))}


def table_3(rows: Sequence[TrialRow]) -> Table:
    lines = []
    firsts = 0
    printed_firsts = 0
    for function, optimum in zip(FUNCTIONS, OPTIMA, strict=True):
        spreads = [_spread(results(rows, function, name) + optimum) for name in ALGORITHMS]
        for metric in spreads[0]:
            ours = [spread[metric] for spread in spreads]
            theirs = PRINTED["table_3"][function][metric]
            least = 0.0 if metric == "sd" else optimum
            ratios = (factor(o - least, t - least) for o, t in zip(ours, theirs, strict=True))
            firsts += places(ours)[0] == 1
            printed_firsts += places(theirs)[0] == 1
            cells = zip(ours_and_print(ours, theirs), ratios, strict=True)
            lines.append([function, metric, *map(" · ".join, cells)])
    means = mean_results(rows, FUNCTIONS)
    widest = np.sqrt(30) * (PRINTED["table_3"]["f7"]["mean"][2] - PRINTED["table_3"]["f7"]["best"][2])
    printed_means = np.array([PRINTED["table_3"][f]["mean"] for f in FUNCTIONS])
    return Table(
        f"Table 3. CEC2022, D = 20, {runs_of(rows)} runs. Each cell: ours (place) · printed (place) · "
        "ratio of the errors (of SD itself).",
        ["", "", *map(str.upper, ALGORITHMS)],
        lines,
        [
            f"IPOA is first in {firsts} of 36 here; in print in {printed_firsts} (its text says 25).",
            f"Mean rank over the functions by mean cost, here: {ranking(ALGORITHMS, means)}.",
            f"Printed: {ranking(ALGORITHMS, printed_means)}.",
            f"The printed SD of POA on f7, {PRINTED['table_3']['f7']['sd'][2]}, is impossible: thirty numbers cannot "
            "have an SD above √30 times their mean less their least, here "
            f"{widest:.0f}. The place printed for it, 4, matches 28.35.",
            f"Mean evaluations of a run: {mean_evaluations(rows)}. MPOA is inferred, see its module.",
        ],
    )


def table_4(rows: Sequence[TrialRow]) -> Table:
    """Compare p of rank-sum tests, corrected by Holm over all sixty, with the printed p."""
    rivals = RIVALS_OF_TABLE_4
    raw = [rank_sum(results(rows, f, "ipoa"), results(rows, f, rival)) for rival in rivals for f in FUNCTIONS]
    compared = _compare_with_rivals(rows, rivals, FUNCTIONS)
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


def _compare_with_rivals(
    rows: Sequence[TrialRow], rivals: Sequence[str], cases: Sequence[str], measure: str | None = None
) -> dict[str, list[str]]:
    """Return whether IPOA is lower (+), higher (-), or neither (=), Holm over all."""
    ours = [results(rows, case, "ipoa", measure) for case in cases]
    theirs = {rival: [results(rows, case, rival, measure) for case in cases] for rival in rivals}
    signs = iter(compare_pairs([pair for each in theirs.values() for pair in zip(ours, each, strict=True)]))
    return {rival: [next(signs) for _ in cases] for rival in rivals}


def contradictions() -> Table:
    """List pairs whose printed Tables 3 and 4 contradict: distant means, but a large p.

    By Samuelson, no sample of n is over sqrt(n - 1) standard deviations above its mean. If that is below the rival's
    best, p is 3.02e-11.
    """
    lines = []
    for function in FUNCTIONS:
        printed = PRINTED["table_3"][function]
        mean = dict(zip(ALGORITHMS, printed["mean"], strict=True))
        sd = dict(zip(ALGORITHMS, printed["sd"], strict=True))
        best = dict(zip(ALGORITHMS, printed["best"], strict=True))
        worst = mean["ipoa"] + sd["ipoa"] * np.sqrt(29)
        for rival, p in zip(RIVALS_OF_TABLE_4, PRINTED["table_4"][function], strict=True):
            apart = (mean[rival] - mean["ipoa"]) / np.sqrt((sd[rival] ** 2 + sd["ipoa"] ** 2) / 30)
            if p > 0.05 and abs(apart) > 6:
                spreads = [f"{number(mean[name])} ± {number(sd[name])}" for name in ("ipoa", rival)]
                bounds = f"{number(worst)} {'<' if worst < best[rival] else 'against'} {number(best[rival])}"
                lines.append([function, rival.upper(), *spreads, f"{apart:.1f}", f"{p}", bounds])
    heading = "|rival|IPOA, mean ± SD|rival, mean ± SD|standard errors apart|printed p|"
    heading += "IPOA's worst at most, and the rival's best"
    return Table(
        "Contradictions in print: the printed means differ by more than six standard errors, "
        "but the printed p shows no difference.",
        heading.split("|"),
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
        at_20, at_10 = (np.maximum(mean_results(rows, [function])[0], FLOOR) for rows in (rows_20, rows_10))
        ranges = [f"{number(means.min())} to {number(means.max())}" for means in (printed, at_20, at_10)]
        off_20, off_10 = (float(np.mean(np.abs(np.log(means / printed)))) for means in (at_20, at_10))
        nearer = "D = 20" if off_20 < off_10 else "**D = 10**"
        lines.append([function, *ranges, f"{off_20:.2f}", f"{off_10:.2f}", nearer])
    return Table(
        "Which dimension the printed Table 3 shows: least and greatest mean error of the six algorithms, "
        "and the mean of |ln(ours / printed)|.",
        ["", "printed", "ours, D = 20", "ours, D = 10", "off, D = 20", "off, D = 10", "nearer"],
        lines,
    )


def table_5(rows: Sequence[TrialRow]) -> Table:
    lines = []
    for experiment, weights in WEIGHTS.items():
        spreads = [_spread(results(rows, f"map-8-1/{experiment}", name)) for name in ALGORITHMS]
        for metric in spreads[0]:
            ours = [spread[metric] for spread in spreads]
            cells = ours_and_print(ours, PRINTED["table_5"][experiment][metric])
            lines.append([" / ".join(f"{w:g}" for w in weights), metric, *cells])
    return Table(
        f"Table 5. Cost by weights (length / turning / clearance), map-8-1, {runs_of(rows)} runs. "
        "Each cell: ours (place) · printed (place).",
        ["weights", "", *map(str.upper, ALGORITHMS)],
        lines,
        [
            "The scales differ: the paper's costs follow from no reading of its eq. (10) and are not reproduced. "
            "Compare places. A collision adds a thousand or more to the cost."
        ],
    )


def table_6(rows: Sequence[TrialRow]) -> Table:
    return _flights("Table 6", rows, {f"map-8-{k}": printed for k, printed in PRINTED["table_6"].items()})


def table_7(rows: Sequence[TrialRow]) -> Table:
    return _flights("Table 7", rows, {f"map-{k}-1": printed for k, printed in PRINTED["table_7"].items()})


def _flights(title: str, rows: Sequence[TrialRow], maps: dict[str, dict[str, list[float]]]) -> Table:
    measures = {"distance": "Distance [m]", "iterations": "Iterations", "turn": "Turn [°]", "dis_obs": "Dis-obs [m]"}
    lines = []
    for case, printed in maps.items():
        for measure, label in measures.items():
            ours = mean_results(rows, [case], measure)[0].tolist()
            lines.append([case, label, *ours_and_print(ours, printed[measure], "{:.1f}".format, "{:g}".format)])
        feasible = mean_results(rows, [case], "feasible")[0]
        lines.append([case, "collision-free", *(f"{share:.0%}" for share in feasible)])
    cases = list(maps)
    smooth = mean_results(rows, cases, "turn_smooth")
    lengths = mean_results(rows, cases, "distance")
    length = lengths.mean(axis=0)
    printed_length = np.mean([printed["distance"] for printed in maps.values()], axis=0)
    gains = ", ".join(
        f"{name.upper()} {per_cent(length[0], length[k])} (printed {per_cent(printed_length[0], printed_length[k])})"
        for k, name in enumerate(ALGORITHMS[1:], 1)
    )
    signs = _compare_with_rivals(rows, ALGORITHMS[1:], cases, "distance")
    comparison = "; ".join(f"{rival.upper()} {count_signs(outcomes)}" for rival, outcomes in signs.items())
    return Table(
        f"{title}. Means of {runs_of(rows)} runs on our seeded maps. "
        "Each cell: ours (place) · printed, on other maps (place).",
        ["map", "", *map(str.upper, ALGORITHMS)],
        lines,
        [
            f"Length of IPOA's paths against each: {gains}.",
            f"Shorter / no difference / longer on the maps (rank-sum, Holm over {len(cases)} maps and five "
            f"rivals, 0.05): {comparison}.",
            *([f"Mean rank by length: {ranking(ALGORITHMS, lengths)}."] if len(cases) > 2 else []),
            "Distance is the smooth curve's length. Iterations: the first, of a thousand, with the best cost within "
            "1 % of its last. Turn: mean angle between adjacent legs of the control points, which the algorithms "
            f"vary. Over the hundred nodes of the smooth curve it is {smooth.min():.0f}° to {smooth.max():.0f}°, which "
            "contradicts the paper. Dis-obs: mean distance from the hull to the nearest obstacle at those hundred "
            "nodes; less is better, as in the paper. Collision-free: share of the runs whose smooth curve is proved to "
            "touch nothing; the paper does not give it.",
        ],
    )


def table_8(rows: Sequence[TrialRow]) -> Table:
    lines = []
    for measure, printed_as, label in (
        ("distance", "distance", "Distance [m]"),
        ("turn", "turn", "Turn [°]"),
        ("dis_obs", "dis_obs", "Dis-obs [m]"),
        ("time", "time", "Time flown [s]"),
        ("estimate", "time", "Time estimated [s]"),
        ("time_landed", "", "Take-off to landing, flown [s]"),
        ("estimate_landed", "", "Take-off to landing, estimated [s]"),
    ):
        ours = [float(np.mean(_known(rows, name, measure) or [np.nan])) for name in ALGORITHMS]
        place = places([o if np.isfinite(o) else np.inf for o in ours])
        cells = [f"{o:.2f} ({p})" if np.isfinite(o) else "-" for o, p in zip(ours, place, strict=True)]
        if printed_as:
            theirs = PRINTED["table_8"][printed_as]
            for k, (t, q) in enumerate(zip(theirs, places(theirs), strict=True)):
                cells[k] += f" · {t:g} ({q})"
        lines.append([label, *cells])
    count = {name: len(_known(rows, name, "distance")) for name in ALGORITHMS}
    nearest = [np.mean(_known(rows, name, "clearance")) for name in ALGORITHMS]
    lines.append(["Least clearance, mean [m]", *(f"{c:.2f}" for c in nearest)])
    lines.append(["collision-free", *(f"{sum(_known(rows, n, 'feasible')) / count[n]:.0%}" for n in ALGORITHMS)])
    lines.append(["flown", *(f"{sum(_known(rows, n, 'flyable')):.0f} of {count[n]}" for n in ALGORITHMS)])
    return Table(
        f"Table 8. The campus, {runs_of(rows)} runs. Each cell: our mean (place) · printed, on another campus (place).",
        ["", *map(str.upper, ALGORITHMS)],
        lines,
        [
            "A path that touches a building is not flown; times are means of those flown. Clearance is negative inside "
            "something. Time is from the first "
            "waypoint to the last, by the built-in ArduPilot with its limits of acceleration and jerk. The paper's "
            "times are little more than length over 15 m/s."
        ],
    )


def _known(rows: Sequence[TrialRow], algorithm: str, measure: str) -> list[float]:
    values = [row.measures[measure] for row in rows if row.trial.algorithm == algorithm and measure in row.measures]
    return [value for value in values if not isinstance(value, list)]


def table_improvements() -> Table:
    """Compare the improvements claimed in the text with those of its tables."""
    lines = []
    for where, claims in PRINTED["improvements"].items():
        for rival, claimed in claims.items():
            k = ALGORITHMS.index(rival)
            cells = []
            for measure, claim in zip(improved(where)[0], claimed, strict=True):
                rows = [part[measure] for part in improved(where)]
                follows = float(np.mean([(row[k] - row[0]) / row[k] for row in rows])) * 100
                mark = "" if abs(follows - claim) < 0.1 else " **!**"
                cells.append(f"{measure} {claim:.2f} % · {follows:.2f} %{mark}")
            lines.append([where, rival.upper(), *cells])
    return Table(
        "Improvements of IPOA: claimed in the text · computed from its tables (mean over the maps). "
        "**!** marks a difference of a tenth or more.",
        ["", "on", "", "", "", ""],
        lines,
    )
