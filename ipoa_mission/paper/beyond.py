"""What the paper lacks: equal budgets, each strategy off, other readings, and rivals from libraries.

On CEC2022 and on the maps; each table is a pure function of rows of runs.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.paper import published
from ipoa_mission.paper.cec2022 import FUNCTIONS
from ipoa_mission.paper.function_tables import FLOOR, mean_log_error, off_the_print
from ipoa_mission.paper.map_tables import mean_over_maps
from ipoa_mission.paper.maps import MAPS
from ipoa_mission.paper.rows import TrialRow, mean_evaluations, results, runs_of, settings_text
from ipoa_mission.paper.series import ABLATION, BEYOND, EQUAL
from ipoa_mission.paper.statistics import Samples, against, counted, places, ranking, told_apart
from ipoa_mission.paper.tables import Table, number

OURS = BEYOND[0]


def table_equal(rows: Sequence[TrialRow]) -> Table:
    """The six at the same number of evaluations: what is left of the places when nobody is given more."""
    settings = {name: settings_text(**wanted) for name, wanted in EQUAL.items()}

    def of(name: str, function: str) -> NDArray[np.float64]:
        return results(rows, function, name, settings=settings[name])

    means = np.array([[of(name, f).mean() for name in EQUAL] for f in FUNCTIONS])
    scores = [mean_log_error(rows, name, settings[name]) for name in EQUAL]
    signs = _each_told_apart(of, "ipoa", [name for name in EQUAL if name != "ipoa"], FUNCTIONS)
    return Table(
        f"The six at equal budget: mean error (place), CEC2022, D = 20, 90,060 evaluations, {runs_of(rows)} runs.",
        ["", *(name.upper() for name in EQUAL)],
        [*_with_places(FUNCTIONS, means), ["mean log10", *(f"**{score:.2f}**" for score in scores)]],
        [
            "Iterations are set so that each spends the budget; mean evaluations: "
            + ", ".join(f"{name.upper()} {mean_evaluations(rows, name):,.0f}" for name in EQUAL)
            + ".",
            f"Mean rank: {ranking(list(EQUAL), means)}.",
            _sentence("IPOA", {rival.upper(): outcomes for rival, outcomes in signs.items()}, "twelve functions"),
        ],
    )


def table_ablation(rows: Sequence[TrialRow]) -> Table:
    """IPOA on CEC2022 with each strategy off and each other reading, one at a time."""
    return Table(
        f"Ablation and readings: IPOA on CEC2022, D = 20, {runs_of(rows)} runs.",
        ["", "mean log10 error", "off the print", "better / same / worse than the first", *FUNCTIONS],
        [
            [
                label,
                f"{mean_log_error(rows, 'ipoa', settings_text(**wanted)):.2f}",
                f"{off_the_print(rows, settings=settings_text(**wanted)):.2f}",
                *_against_the_first(rows, wanted, FUNCTIONS),
            ]
            for label, wanted in ABLATION.items()
        ],
        [
            "Better, same, worse: functions on which the rank-sum test with Holm's correction over the twelve says so "
            "at 0.05. Off the print: mean of |ln(our mean error / the printed one)|; 0 is a perfect match. "
            "The twelve columns are mean errors."
        ],
    )


def table_maps_ablation(rows: Sequence[TrialRow]) -> Table:
    """The same on the maps, by cost."""
    return Table(
        f"Ablation and readings on the maps: mean cost of IPOA, {runs_of(rows)} runs, absolute coordinates.",
        ["", "mean cost", "collision-free", "better / same / worse than the first", *MAPS],
        [
            [
                label,
                f"{mean_over_maps(rows, 'ipoa', settings=settings_text(**wanted)):.1f}",
                f"{mean_over_maps(rows, 'ipoa', 'feasible', settings_text(**wanted)):.0%}",
                *_against_the_first(rows, wanted, MAPS),
            ]
            for label, wanted in ABLATION.items()
        ],
        ["Better, same, worse: maps on which the rank-sum test with Holm's correction over the seven says so at 0.05."],
    )


def _against_the_first(rows: Sequence[TrialRow], wanted: dict[str, object], cases: Sequence[str]) -> list[str]:
    """On how many cases IPOA so set is better, the same and worse than by default; then its mean on each."""
    ours, first = (
        [results(rows, case, "ipoa", settings=settings) for case in cases]
        for settings in (settings_text(**wanted), settings_text())
    )
    signs = told_apart(list(zip(ours, first, strict=True)))
    return [counted(signs) if wanted else "-", *(number(costs.mean()) for costs in ours)]


def table_beyond(rows: Sequence[TrialRow], paper: Sequence[TrialRow]) -> Table:
    """Mean error of the rivals beyond the paper, beside the paper's six."""
    everyone = [*rows, *paper]
    names = [*BEYOND, *published.ALGORITHMS]
    means = np.array([[results(everyone, f, name).mean() for name in names] for f in FUNCTIONS])
    return Table(
        "Beyond the paper: CEC2022, D = 20.",
        ["", *names],
        [
            *_with_places(FUNCTIONS, means),
            ["mean log10", *(f"**{mean_log_error(everyone, name):.2f}**" for name in names)],
        ],
        [
            f"Mean error (place), {runs_of(rows)} runs; the last line is log10 of it, errors below 1e-8 counted as "
            f"1e-8, averaged over the functions. The first {len(BEYOND)} spent 90,060 evaluations a run, the paper's "
            "six what N = 30 and T = 1000 gives them.",
            f"Mean rank: {ranking(names, np.maximum(means, FLOOR), OURS)}.",
            _sentence(OURS, ours_against(rows, paper), f"{len(FUNCTIONS)}"),
        ],
    )


def table_maps_beyond(rows: Sequence[TrialRow], paper: Sequence[TrialRow]) -> Table:
    """Mean cost on each map: rivals beyond the paper beside the paper's six."""
    everyone = [*rows, *paper]
    names = [*BEYOND, *published.ALGORITHMS]
    means = np.array([[results(everyone, case, name).mean() for name in names] for case in MAPS])
    feasible = [mean_over_maps(everyone, name, "feasible") for name in names]
    return Table(
        f"Beyond the paper, on the maps: mean cost (place), {runs_of(rows)} runs, absolute coordinates.",
        ["map", *names],
        [*_with_places(MAPS, means), ["collision-free", *(f"{share:.0%}" for share in feasible)]],
        [f"Mean rank: {ranking(names, means, OURS)}.", _sentence(OURS, ours_against_on_maps(everyone), f"{len(MAPS)}")],
    )


def ours_against(rows: Sequence[TrialRow], paper: Sequence[TrialRow]) -> dict[str, list[str]]:
    """For each rival, function by function: is our variant told to be better (+), worse (-), or neither (=)?"""
    everyone = [*rows, *paper]

    def of(name: str, function: str) -> NDArray[np.float64]:
        return np.maximum(results(everyone, function, name), FLOOR)

    return _each_told_apart(of, OURS, (*BEYOND[1:], "ipoa"), FUNCTIONS)


def ours_against_on_maps(rows: Sequence[TrialRow]) -> dict[str, list[str]]:
    """The same by cost on the maps; `rows` are those of the paper's six and of the rivals."""
    return _each_told_apart(lambda name, case: results(rows, case, name), OURS, (*BEYOND[1:], "ipoa"), MAPS)


def _each_told_apart(
    of: Callable[[str, str], Samples], ours: str, rivals: Sequence[str], cases: Sequence[str]
) -> dict[str, list[str]]:
    """As `against`, but Holm's correction is over the cases of one rival."""
    return {rival: against(of, ours, [rival], cases)[rival] for rival in rivals}


def _sentence(ours: str, signs: dict[str, list[str]], over: str) -> str:
    return (
        f"{ours} better / not told apart / worse (rank-sum, Holm over the {over}, 0.05): "
        + "; ".join(f"than {rival} {counted(outcomes)}" for rival, outcomes in signs.items())
        + "."
    )


def _with_places(labels: Sequence[str], means: NDArray[np.float64]) -> list[list[str]]:
    return [
        [label, *(f"{number(m)} ({p})" for m, p in zip(row, places(row.tolist()), strict=True))]
        for label, row in zip(labels, means, strict=True)
    ]
