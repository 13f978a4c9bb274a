"""Make Tables 5 to 8: the maps are unpublished, so only ranks and ratios compare."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.paper.markdown_table import Table, number, ours_and_print, per_cent
from ipoa_mission.paper.problems import MAPS, WEIGHTS
from ipoa_mission.paper.published import ALGORITHMS, PRINTED, improved
from ipoa_mission.paper.rows import TrialRow, mean_results, results, runs_of
from ipoa_mission.paper.statistics import against, count_signs, places, ranking


def mean_over_maps(rows: Sequence[TrialRow], algorithm: str, measure: str | None = None, settings: str = "{}") -> float:
    return float(np.mean([results(rows, case, algorithm, measure, settings).mean() for case in MAPS]))


def table_5(rows: Sequence[TrialRow]) -> Table:
    lines = []
    for experiment, weights in WEIGHTS.items():
        costs = [results(rows, f"map-8-1/{experiment}", name) for name in ALGORITHMS]
        for metric, of in (("best", np.min), ("mean", np.mean), ("sd", lambda c: np.std(c, ddof=min(1, len(c) - 1)))):
            ours = [float(of(c)) for c in costs]
            cells = ours_and_print(ours, PRINTED["table_5"][experiment][metric], (number, number))
            lines.append([" / ".join(f"{w:g}" for w in weights), metric, *cells])
    return Table(
        f"Table 5. Cost by weights (length / turning / clearance), map-8-1, {runs_of(rows)} runs. "
        "Each cell: ours (place) · printed (place).",
        ["weights", "", *(name.upper() for name in ALGORITHMS)],
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
            ours = mean_results(rows, [case], ALGORITHMS, measure)[0].tolist()
            lines.append([case, label, *ours_and_print(ours, printed[measure], ("{:.1f}".format, "{:g}".format))])
        feasible = mean_results(rows, [case], ALGORITHMS, "feasible")[0]
        lines.append([case, "collision-free", *(f"{share:.0%}" for share in feasible)])
    cases = list(maps)
    smooth = mean_results(rows, cases, ALGORITHMS, "turn_smooth")
    lengths = mean_results(rows, cases, ALGORITHMS, "distance")
    length = lengths.mean(axis=0)
    printed_length = np.mean([printed["distance"] for printed in maps.values()], axis=0)
    gains = ", ".join(
        f"{name.upper()} {per_cent(length[0], length[k])} (printed {per_cent(printed_length[0], printed_length[k])})"
        for k, name in enumerate(ALGORITHMS[1:], 1)
    )

    def lengths_of(name: str, case: str) -> NDArray[np.float64]:
        return results(rows, case, name, "distance")

    signs = against(lengths_of, "ipoa", ALGORITHMS[1:], cases)
    comparison = "; ".join(f"{rival.upper()} {count_signs(outcomes)}" for rival, outcomes in signs.items())
    return Table(
        f"{title}. Means of {runs_of(rows)} runs on our seeded maps. "
        "Each cell: ours (place) · printed, on other maps (place).",
        ["map", "", *(name.upper() for name in ALGORITHMS)],
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
    names = [*ALGORITHMS, *sorted({row.trial.algorithm for row in rows}.difference(ALGORITHMS))]
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
        ours = [float(np.mean(_known(rows, name, measure) or [np.nan])) for name in names]
        place = places([o if np.isfinite(o) else np.inf for o in ours])
        cells = [f"{o:.2f} ({p})" if np.isfinite(o) else "-" for o, p in zip(ours, place, strict=True)]
        if printed_as:
            theirs = PRINTED["table_8"][printed_as]
            for k, (t, q) in enumerate(zip(theirs, places(theirs), strict=True)):
                cells[k] += f" · {t:g} ({q})"
        lines.append([label, *cells])
    count = {name: len(_known(rows, name, "distance")) for name in names}
    nearest = [np.mean(_known(rows, name, "clearance")) for name in names]
    lines.append(["Least clearance, mean [m]", *(f"{c:.2f}" for c in nearest)])
    lines.append(["collision-free", *(f"{sum(_known(rows, n, 'feasible')) / count[n]:.0%}" for n in names)])
    lines.append(["flown", *(f"{sum(_known(rows, n, 'flyable')):.0f} of {count[n]}" for n in names)])
    return Table(
        f"Table 8. The campus, {runs_of(rows)} runs. Each cell: our mean (place) · printed, on another campus (place).",
        ["", *(name.upper() if name in ALGORITHMS else name for name in names)],
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
