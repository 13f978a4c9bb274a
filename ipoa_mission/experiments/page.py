"""The page of findings: what came out, what did not, and what the paper must have meant, told from the rows.

Every number in its sentences is computed from the rows; where a sentence depends on how a comparison came out, the
sentence is chosen by the numbers.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ipoa_mission.experiments import published
from ipoa_mission.experiments.cec2022 import FUNCTIONS, OPTIMA
from ipoa_mission.experiments.paper import errors, mean_log_error
from ipoa_mission.experiments.runs import Row, settings_text
from ipoa_mission.experiments.series import BEYOND, CEC_ABLATION, CEC_BEYOND, CEC_D10, CEC_D20
from ipoa_mission.experiments.statistics import places
from ipoa_mission.experiments.tables import Table

Made = Mapping[str, Table | str]
Rows = Mapping[str, Sequence[Row]]


def findings(made: Made, rows: Rows, folder: str) -> str:
    """The page, in Markdown; tables are set in it, figures are linked from `folder` beside it."""

    def table(name: str) -> str:
        found = made[name]
        return found.markdown() if isinstance(found, Table) else f"![{name}]({folder}/{name}.svg)\n"

    return "\n".join(
        [
            "# The paper, reproduced",
            "",
            "*Made by `ipoa-mission reproduce all`; every number on this page comes from the rows in "
            f"[`{folder}/`]({folder}/), and can be made again from them or from nothing.*",
            "",
            _measured(rows),
            "",
            "## What came out, in short",
            "",
            *(f"* {line}" for line in _in_short(rows)),
            "",
            "## Table 3: the six algorithms on CEC2022",
            "",
            _HOW_TO_READ,
            "",
            table("table-3"),
            "## Which dimension is it?",
            "",
            "The paper says D = 20 for its Table 3. Here are the six algorithms at both dimensions, beside the print.",
            "",
            table("dimension"),
            "## Table 4: rank-sum tests",
            "",
            table("table-4"),
            table("contradictions"),
            "## Figure 3 and Figure 5: the chaotic map, the densities",
            "",
            table("figure-3"),
            table("figure-5"),
            "## Figure 7: convergence at D = 20",
            "",
            table("figure-7"),
            "## Figure 8: box plots at D = 10",
            "",
            table("figure-8"),
            "## Tables 5 to 7, Figures 9 and 10: paths on random maps",
            "",
            _MAPS,
            "",
            table("table-5"),
            table("table-6"),
            table("table-7"),
            table("figure-9"),
            table("figure-10"),
            "## Table 8 and Figure 11: the campus",
            "",
            table("table-8"),
            table("figure-11"),
            "## What the text says of its tables",
            "",
            "The percentages that the text draws from its own tables:",
            "",
            table("improvements"),
            "## What each strategy is worth, and what each reading gives",
            "",
            _READINGS,
            "",
            table("ablation"),
            table("maps-ablation"),
            "## Beyond the paper",
            "",
            _BEYOND,
            "",
            table("beyond"),
            table("maps-beyond"),
        ]
    )


def _measured(rows: Rows) -> str:
    lines = ["| series | rows | measured | versions | CPU |", "| --- | --- | --- | --- | --- |"]
    for name, series in rows.items():
        dates = sorted({row.date for row in series})
        versions = "; ".join(sorted({row.versions for row in series}))
        minutes = sum(row.seconds for row in series) / 60
        when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
        lines.append(f"| {name} | {len(series)} | {when} | {versions} | {minutes:.1f} min |")
    seeds = "The seed of a run is its number, with the problem and its dimension: the same for all algorithms."
    return "\n".join([*lines, "", seeds])


def _in_short(rows: Rows) -> list[str]:
    table, beyond = rows[CEC_D20.name], rows[CEC_BEYOND.name]
    firsts = sum(places([errors(table, f, name).mean() for name in published.ALGORITHMS])[0] == 1 for f in FUNCTIONS)
    printed_firsts = sum(places(published.TABLE_3[f]["mean"])[0] == 1 for f in FUNCTIONS)
    off = {
        name: float(
            np.mean(
                [
                    abs(np.log(errors(table, f, name).mean() / (published.TABLE_3[f]["mean"][k] - optimum)))
                    for f, optimum in zip(FUNCTIONS, OPTIMA, strict=True)
                ]
            )
        )
        for k, name in enumerate(published.ALGORITHMS)
    }
    score = {name: mean_log_error(beyond, name) for name in BEYOND}
    ours, ipoa = score[BEYOND[0]], mean_log_error(table, "ipoa")
    six = {name: mean_log_error(table, name) for name in published.ALGORITHMS}
    better_than_ipoa = [name.upper() for name, value in six.items() if value < six["ipoa"]]
    ten = rows[CEC_D10.name]
    f4 = {d: errors(some, "f4", "poa").mean() + 800 for d, some in ((20, table), (10, ten))}
    literal = mean_log_error(rows[CEC_ABLATION.name], "ipoa", settings_text(reading="literal"))
    return [
        f"**IPOA's mean is the best of the six on {firsts} of 12 functions here; in the print on {printed_firsts}.** "
        + (
            f"By mean log10 error IPOA ({six['ipoa']:.2f}) comes after {' and '.join(better_than_ipoa)}"
            f" ({', '.join(f'{six[n.lower()]:.2f}' for n in better_than_ipoa)})."
            if better_than_ipoa
            else f"By mean log10 error IPOA ({six['ipoa']:.2f}) leads the six."
        )
        + " MPOA is our inference of an algorithm whose formulas we did not have, so its column proves nothing about "
        "the authors' own MPOA.",
        "IPOA does improve on POA, the algorithm that it is made from: mean log10 error "
        f"{six['ipoa']:.2f} against {six['poa']:.2f}. It also spends half as many evaluations again.",
        "**No column of Table 3 could be reproduced.** The mean of |ln(our mean error / the printed one)| is "
        + ", ".join(f"{name.upper()} {value:.2f}" for name, value in off.items())
        + " (0 would be a match, 0.69 is a factor of two). POA is the telling one: its authors' code leaves nothing to "
        "read into it, our POA agrees with an independent implementation, and still the column is not met.",
        f"The printed f4 values look like D = 10: POA, {published.TABLE_3['f4']['mean'][2]} in print, gives "
        f"{f4[20]:.1f} at D = 20 and {f4[10]:.1f} at D = 10.",
        "Table 4 contradicts Table 3: pairs whose printed means lie many standard errors apart have printed p values "
        "far above 0.05.",
        f"Read as printed (the Levy factor on the whole position), IPOA comes to {literal:.2f}, far behind its other "
        f"reading ({ipoa:.2f}) that is the default here.",
        f"On these functions none of the six is near the state of the art: restarted CMA-ES {score['rcmaes']:.2f}, "
        f"L-SHADE {score['lshade']:.2f}, scipy's differential evolution {score['de']:.2f}, and our variant "
        f"`{BEYOND[0]}` {ours:.2f}, against {ipoa:.2f} of IPOA: one unit is a factor of ten in the error.",
    ]


_HOW_TO_READ = (
    "N = 30, T = 1000, Table 2's constants, the functions from `minionpy`. The algorithms are given the same number of "
    "iterations, as in the paper, not the same number of evaluations: the last note says how many each spends."
)

_MAPS = (
    "The paper's maps are not published, nor how many control points its paths have, nor how the costs are scaled. "
    "These are seeded maps of its size and number of obstacles (`missions/paper/`), eight inner control points in "
    "absolute coordinates, its cost summed over a hundred nodes, and nothing of what the package's own planner adds: "
    "this is the paper's method, not the product's. Two things are seen at once. Control points gather near the "
    "start: the algorithms move by multiplying coordinates, which draws everything towards the origin, and the start "
    "at (5, 5) happens to be beside it. And a path that costs little at its nodes may still touch something between "
    "them."
)

_READINGS = (
    "The formulas leave several things open (`omega`, the prey, what the Levy factor multiplies, for whom the t "
    "mutation is drawn), and values for `k n` and `nu` are not given. The default is the reading that keeps all four "
    "strategies as the words describe them and is among the nearest to the print; it was not chosen for its results, "
    "and better ones are in the table. Each line changes what it names from the first."
)

_BEYOND = (
    "Restarted CMA-ES and L-SHADE are `minionpy`'s with their own defaults, differential evolution is scipy's. "
    "`adaptive-pelican` is ours: the pelican's two phases, but moving by differences instead of products, with scale "
    "and crossover adapted by success, an archive, and a population that shrinks. It owes what it can do to those "
    "(they are L-SHADE's), not to the pelicans."
)
