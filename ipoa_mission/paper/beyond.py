"""Make tables that the paper lacks."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.paper.function_tables import FLOOR, mean_log_error, off_the_print
from ipoa_mission.paper.map_tables import mean_over_maps
from ipoa_mission.paper.markdown_table import Table, number
from ipoa_mission.paper.problems import FUNCTIONS, MAPS
from ipoa_mission.paper.published import ALGORITHMS
from ipoa_mission.paper.rows import TrialRow, mean_evaluations, mean_results, results, runs_of, settings_text
from ipoa_mission.paper.series import ABLATION, BEYOND, EQUAL
from ipoa_mission.paper.statistics import Samples, against, compare_pairs, count_signs, places, ranking


def table_equal(rows: Sequence[TrialRow]) -> Table:
    settings = {name: settings_text(**changed) for name, changed in EQUAL.items()}

    def errors_of(name: str, function: str) -> NDArray[np.float64]:
        return results(rows, function, name, settings=settings[name])

    means = np.array([[errors_of(name, f).mean() for name in EQUAL] for f in FUNCTIONS])
    scores = [mean_log_error(rows, name, settings[name]) for name in EQUAL]
    signs = _compare_each(errors_of, "ipoa", [name for name in EQUAL if name != "ipoa"], FUNCTIONS)
    return Table(
        f"The six at equal budget: mean error (place), CEC2022, D = 20, 90,060 evaluations, {runs_of(rows)} runs.",
        ["", *(name.upper() for name in EQUAL)],
        [*_with_places(FUNCTIONS, means), ["mean log10", *(f"**{score:.2f}**" for score in scores)]],
        [
            "Iterations are set so that each spends the budget; mean evaluations: "
            f"{mean_evaluations(rows, list(EQUAL))}.",
            f"Mean rank: {ranking(list(EQUAL), means)}.",
            _sentence("IPOA", {rival.upper(): outcomes for rival, outcomes in signs.items()}, "twelve functions"),
        ],
    )


def table_ablation(rows: Sequence[TrialRow]) -> Table:
    return _ablation(
        rows,
        f"Ablation and readings: IPOA on CEC2022, D = 20, {runs_of(rows)} runs.",
        FUNCTIONS,
        {
            "mean log10 error": lambda settings: f"{mean_log_error(rows, 'ipoa', settings):.2f}",
            "off the print": lambda settings: f"{off_the_print(rows, settings):.2f}",
        },
        "Better, same, worse: number of functions by the rank-sum test with Holm's correction over the twelve "
        "at 0.05. Off the print: mean of |ln(our mean error / the printed one)|; 0 is a perfect match. "
        "The twelve columns are mean errors.",
    )


def table_maps_ablation(rows: Sequence[TrialRow]) -> Table:
    return _ablation(
        rows,
        f"Ablation and readings on the maps: mean cost of IPOA, {runs_of(rows)} runs, absolute coordinates.",
        MAPS,
        {
            "mean cost": lambda settings: f"{mean_over_maps(rows, 'ipoa', settings=settings):.1f}",
            "collision-free": lambda settings: f"{mean_over_maps(rows, 'ipoa', 'feasible', settings):.0%}",
        },
        "Better, same, worse: number of maps by the rank-sum test with Holm's correction over the seven at 0.05.",
    )


def _ablation(
    rows: Sequence[TrialRow], caption: str, cases: Sequence[str], columns: Mapping[str, Callable[[str], str]], note: str
) -> Table:
    first = [results(rows, case, "ipoa") for case in cases]
    lines = []
    for label, changed in ABLATION.items():
        settings = settings_text(**changed)
        costs = [results(rows, case, "ipoa", settings=settings) for case in cases]
        compared = count_signs(compare_pairs(list(zip(costs, first, strict=True)))) if changed else "-"
        measured = [measure(settings) for measure in columns.values()]
        lines.append([label, *measured, compared, *(number(sample.mean()) for sample in costs)])
    return Table(caption, ["", *columns, "better / same / worse than the first", *cases], lines, [note])


def table_beyond(paper: Sequence[TrialRow], rivals: Sequence[TrialRow]) -> Table:
    everyone = [*rivals, *paper]
    return _rivals(
        everyone,
        ["Beyond the paper: CEC2022, D = 20.", ""],
        FUNCTIONS,
        ("mean log10", lambda name: f"**{mean_log_error(everyone, name):.2f}**"),
        f"Mean error (place), {runs_of(rivals)} runs; the last line is log10 of it, averaged over the functions; "
        f"errors below 1e-8 count as 1e-8. The first {len(BEYOND)} spent 90,060 evaluations a run. The "
        "paper's six have N = 30 and T = 1000.",
    )


def table_maps_beyond(paper: Sequence[TrialRow], rivals: Sequence[TrialRow]) -> Table:
    everyone = [*rivals, *paper]
    words = f"Beyond the paper, on the maps: mean cost (place), {runs_of(rivals)} runs, absolute coordinates."
    share = ("collision-free", lambda name: f"{mean_over_maps(everyone, name, 'feasible'):.0%}")
    return _rivals(everyone, [words, "map"], MAPS, share)


def _rivals(
    rows: Sequence[TrialRow],
    heading: Sequence[str],
    cases: Sequence[str],
    last: tuple[str, Callable[[str], str]],
    *notes: str,
) -> Table:
    names = [*BEYOND, *ALGORITHMS]
    ours = BEYOND[0]
    means = mean_results(rows, cases, names)

    def costs_of(name: str, case: str) -> NDArray[np.float64]:
        return np.maximum(results(rows, case, name), FLOOR)

    signs = _compare_each(costs_of, ours, (*BEYOND[1:], "ipoa"), cases)
    (caption, corner), (label, words) = heading, last
    return Table(
        caption,
        [corner, *names],
        [*_with_places(cases, means), [label, *map(words, names)]],
        [
            *notes,
            f"Mean rank: {ranking(names, np.maximum(means, FLOOR), ours)}.",
            _sentence(ours, signs, f"{len(cases)}"),
        ],
    )


def _compare_each(
    costs_of: Callable[[str, str], Samples], ours: str, rivals: Sequence[str], cases: Sequence[str]
) -> dict[str, list[str]]:
    return {rival: against(costs_of, ours, [rival], cases)[rival] for rival in rivals}


def _sentence(ours: str, signs: dict[str, list[str]], over: str) -> str:
    return (
        f"{ours} better / no difference / worse (rank-sum, Holm over the {over}, 0.05): "
        + "; ".join(f"than {rival} {count_signs(outcomes)}" for rival, outcomes in signs.items())
        + "."
    )


def _with_places(labels: Sequence[str], means: NDArray[np.float64]) -> list[list[str]]:
    return [
        [label, *(f"{number(m)} ({p})" for m, p in zip(row, places(row.tolist()), strict=True))]
        for label, row in zip(labels, means, strict=True)
    ]
