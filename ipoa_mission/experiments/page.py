"""The page of findings: what came out, what did not, and what the paper must have meant, told from the rows.

Every number in its sentences is computed from the rows; where a sentence depends on how a comparison came out, the
sentence is chosen by the numbers.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ipoa_mission.experiments.came_out import came_out
from ipoa_mission.experiments.fell_short import fell_short
from ipoa_mission.experiments.figures import chaotic_iterates
from ipoa_mission.experiments.meant import meant
from ipoa_mission.experiments.rows import Rows, runs_of
from ipoa_mission.experiments.tables import Table

Made = Mapping[str, Table | str]


def findings(made: Made, sources: Mapping[str, Sequence[str]], rows: Rows, folder: str) -> str:
    """The page, in Markdown; tables are set in it, figures are linked from `folder` beside it.

    `sources` names the series that each table or figure is made of.
    """

    def show(name: str) -> str:
        found = made[name]
        shown = found.markdown() if isinstance(found, Table) else f"![{name}]({folder}/{name}.svg)\n"
        files = ", ".join(f"[`{one}.csv`]({folder}/rows/{one}.csv)" for one in sources[name])
        return f"{shown}\n*`ipoa-mission reproduce {name}`; {f'rows: {files}' if files else 'needs no runs'}.*\n"

    return "\n".join(
        [
            "# The paper, reproduced",
            "",
            "*Made by `ipoa-mission reproduce all`; every number on this page comes from the rows in "
            f"[`{folder}/rows/`]({folder}/rows/), and can be made again from them or from nothing.*",
            "",
            _WORDS,
            "",
            *_sentences(rows),
            "## Table 3: the six algorithms on CEC2022",
            "",
            _TABLE_3,
            "",
            show("table-3"),
            "The paper gives all six the same iterations; at the same evaluations it looks like this:",
            "",
            show("equal"),
            "## Which dimension is it?",
            "",
            "The paper says D = 20 for its Table 3. Here are the six algorithms at both dimensions, beside the print.",
            "",
            show("dimension"),
            "## Table 4: rank-sum tests",
            "",
            show("table-4"),
            show("contradictions"),
            "## Figure 3 and Figure 5: the chaotic map, the densities",
            "",
            _chaos(),
            "",
            show("figure-3"),
            show("figure-5"),
            "## Figure 7: convergence at D = 20",
            "",
            "An iteration costs each algorithm another number of evaluations; so the axis is the share of those that "
            "each spends, which Table 3's notes list. For an axis of iterations multiply by a thousand.",
            "",
            show("figure-7"),
            "## Figure 8: box plots at D = 10",
            "",
            "Boxes from the first quartile to the third, the median in them; whiskers to the last run within one and a "
            "half boxes.",
            "",
            show("figure-8"),
            "## Tables 5 to 7, Figures 9 and 10: paths on random maps",
            "",
            _MAPS,
            "",
            show("table-5"),
            show("table-6"),
            show("table-7"),
            "In the figures a path that touches something is dotted; of each algorithm's runs the cheapest is drawn.",
            "",
            show("figure-9"),
            show("figure-10"),
            "## Table 8 and Figure 11: the campus",
            "",
            show("table-8"),
            show("figure-11"),
            "## What the text says of its tables",
            "",
            "The percentages that the text draws from its own tables:",
            "",
            show("improvements"),
            "## What each strategy is worth, and what each reading gives",
            "",
            _READINGS,
            "",
            show("ablation"),
            show("maps-ablation"),
            "## Beyond the paper",
            "",
            _BEYOND,
            "",
            show("beyond"),
            show("maps-beyond"),
            "## What was run",
            "",
            _measured(rows),
            "",
        ]
    )


def _sentences(rows: Rows) -> list[str]:
    found = {
        "What came out": came_out(rows),
        "What did not": fell_short(rows),
        "What the paper must have meant": meant(rows),
    }
    lines = []
    for heading, sentences in found.items():
        lines += [f"## {heading}", "", *(f"* {sentence}" for sentence in sentences), ""]
    return lines


def _chaos() -> str:
    size = np.abs(chaotic_iterates(1000))
    outer, inner = float(np.mean(size > 0.9)), float(np.mean(size < 0.1))
    return (
        "The chaotic map is said to spread the first pelicans evenly. Of 300 iterates from each of a thousand starts "
        f"{outer:.0%} lie in the outermost tenth of the interval and {inner:.0%} in the innermost, where an even "
        "spread has a tenth in each."
    )


def _measured(rows: Rows) -> str:
    lines = ["| series | runs | rows | measured | versions | CPU |", "| --- | --- | --- | --- | --- | --- |"]
    for name, series in rows.items():
        dates = sorted({row.date for row in series})
        versions = "; ".join(sorted({row.versions for row in series}))
        minutes = sum(row.seconds for row in series) / 60
        when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
        lines.append(f"| {name} | {runs_of(series)} | {len(series)} | {when} | {versions} | {minutes:.1f} min |")
    return "\n".join([*lines, "", _SEEDS])


_WORDS = (
    "*Error* is what a cost lies above the known optimum of its function. *Mean log10 error* is log10 of the mean "
    "error over the runs, averaged over the twelve functions: one unit is a factor of ten, lower is better. One "
    "algorithm is *told* to be better than another where a two-sided rank-sum test says so at 0.05 after Holm's "
    "correction. *Place* is 1 for the lowest. After each Friedman test over functions or maps, one algorithm is "
    "compared with all others by mean rank, again with Holm's correction (+ better, - worse, = not told apart)."
)

_TABLE_3 = (
    "N = 30, T = 1000, Table 2's constants, the functions from `minionpy`. The algorithms are given the same number of "
    "iterations, as in the paper, not the same number of evaluations: the last note says how many each spends."
)

_SEEDS = (
    "The seed of a run is its number, with the problem and its dimension: the same for all algorithms. The same seed "
    "gives the same row to the last digit on the same kind of processor; `docs/cluster.md` says what another one "
    "changes. CPU is what these runs took on a machine that was not quiet."
)

_MAPS = (
    "The paper's maps are not published, nor how many control points its paths have, nor how the costs are scaled. "
    "These are seeded maps of its size and number of obstacles (`missions/paper/`), eight inner control points in "
    "absolute coordinates, its cost summed over a hundred nodes, and nothing of what the package's own planner adds: "
    "this is the paper's method, not the product's. Two things are seen at once. Control points gather near the "
    "start: the algorithms move by multiplying coordinates, which draws everything towards the origin, and the start "
    "at (5, 5) happens to be beside it. And a path that costs little at its nodes may still touch something between "
    "them. *Iterations*, which the paper does not define, are counted to the first, of a thousand, at which the best "
    "cost known was within 1 % of what the search ended with."
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
    "(they are L-SHADE's), not to the pelicans. Its constants were chosen among some twenty settings tried on these "
    "same functions with other seeds: the comparison favours it a little, and its lead over L-SHADE is nothing to "
    "build on."
)
