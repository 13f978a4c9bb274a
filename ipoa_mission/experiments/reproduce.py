"""The paper's tables and figures by name: measure what is missing, then tell what was measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.experiments import beyond, figures, map_figures, paper, paper_maps
from ipoa_mission.experiments.campus import campus_scenario
from ipoa_mission.experiments.executors import open_executor
from ipoa_mission.experiments.maps import map_scenario
from ipoa_mission.experiments.page import findings
from ipoa_mission.experiments.rows import Rows
from ipoa_mission.experiments.runs import measure
from ipoa_mission.experiments.series import (
    CAMPUS,
    CEC_ABLATION,
    CEC_BEYOND,
    CEC_D10,
    CEC_D20,
    CEC_EQUAL,
    MAPS_ABLATION,
    MAPS_BEYOND,
    MAPS_PAPER,
    Series,
)
from ipoa_mission.experiments.tables import Table
from ipoa_mission.files import write_atomically
from ipoa_mission.progress import Progress, silent


@dataclass(frozen=True)
class Item:
    """A table or figure: the series it needs, and how it is made of their rows (a table, or SVG text)."""

    needs: Sequence[Series]
    make: Callable[[Rows], Table | str]


def _paths(rows: Rows, cases: Sequence[str]) -> str:
    return map_figures.paths_on_maps(rows[MAPS_PAPER.name], {case: map_scenario(case) for case in cases})


ITEMS: dict[str, Item] = {
    "table-3": Item([CEC_D20], lambda rows: paper.table_3(rows[CEC_D20.name])),
    "table-4": Item([CEC_D20], lambda rows: paper.table_4(rows[CEC_D20.name])),
    "figure-3": Item([], lambda _: figures.figure_3()),
    "figure-5": Item([], lambda _: figures.figure_5()),
    "figure-7": Item([CEC_D20], lambda rows: figures.figure_7(rows[CEC_D20.name])),
    "figure-8": Item([CEC_D10], lambda rows: figures.figure_8(rows[CEC_D10.name])),
    "dimension": Item(
        [CEC_D20, CEC_D10], lambda rows: paper.dimension_of_the_print(rows[CEC_D20.name], rows[CEC_D10.name])
    ),
    "contradictions": Item([], lambda _: paper.contradictions()),
    "table-8": Item([CAMPUS], lambda rows: paper_maps.table_8(rows[CAMPUS.name])),
    "figure-11": Item(
        [CAMPUS], lambda rows: map_figures.paths_on_maps(rows[CAMPUS.name], {"campus": campus_scenario()})
    ),
    "improvements": Item([], lambda _: paper_maps.table_improvements()),
    "beyond": Item([CEC_D20, CEC_BEYOND], lambda rows: beyond.table_beyond(rows[CEC_BEYOND.name], rows[CEC_D20.name])),
    "table-5": Item([MAPS_PAPER], lambda rows: paper_maps.table_5(rows[MAPS_PAPER.name])),
    "table-6": Item([MAPS_PAPER], lambda rows: paper_maps.table_6(rows[MAPS_PAPER.name])),
    "table-7": Item([MAPS_PAPER], lambda rows: paper_maps.table_7(rows[MAPS_PAPER.name])),
    "figure-9": Item([MAPS_PAPER], lambda rows: _paths(rows, [f"map-8-{k}" for k in range(1, 6)])),
    "figure-10": Item([MAPS_PAPER], lambda rows: _paths(rows, ["map-6-1", "map-10-1"])),
    "maps-beyond": Item(
        [MAPS_PAPER, MAPS_BEYOND],
        lambda rows: beyond.table_maps_beyond(rows[MAPS_BEYOND.name], rows[MAPS_PAPER.name]),
    ),
    "maps-ablation": Item([MAPS_ABLATION], lambda rows: beyond.table_maps_ablation(rows[MAPS_ABLATION.name])),
    "equal": Item([CEC_EQUAL], lambda rows: beyond.table_equal(rows[CEC_EQUAL.name])),
    "ablation": Item([CEC_ABLATION], lambda rows: beyond.table_ablation(rows[CEC_ABLATION.name])),
}


def reproduce(
    what: str,
    runs: int | None,
    out: Path,
    jobs: int,
    executor: str | None,
    progress: Progress = silent,
) -> list[Path]:
    """Measure and write one of `ITEMS`, or "all" of them and the page of findings; returns the files written.

    Runs are kept in `out`/rows, one CSV file a series, and not repeated. Tables are written to `out` as Markdown and
    CSV, figures as SVG; the page of findings is written beside `out`, under its name with `.md`. `runs` is how many of
    each (None: as many as the paper). `jobs` processes run them, or the workers of the Dask scheduler at `executor`.
    `progress` is told after each run.

    Raises:
        BadInput: `what`, `runs`, `jobs` or `executor` is wrong.
        MissionError: a library is missing, or the cluster does not answer.
    """
    if what != "all" and what not in ITEMS:
        close = get_close_matches(what, [*ITEMS, "all"], n=1)
        meant = f" (did you mean {close[0]!r}?)" if close else ""
        raise BadInput(f"what: expected {', '.join(ITEMS)} or all, not {what!r}{meant}")
    if runs is not None and runs < 1:
        raise BadInput(f"runs: expected at least 1, not {runs}")
    names = list(ITEMS) if what == "all" else [what]
    rows = _measure({s.name: s for name in names for s in ITEMS[name].needs}, runs, out, jobs, executor, progress)
    made = {name: ITEMS[name].make(rows) for name in names}
    written = []
    for name, item in made.items():
        if isinstance(item, Table):
            written += [_write(out / f"{name}.md", item.markdown()), _write(out / f"{name}.csv", item.csv())]
        else:
            written.append(_write(out / f"{name}.svg", item))
    if what == "all":
        sources = {name: [series.name for series in ITEMS[name].needs] for name in made}
        written.append(_write(out.with_name(f"{out.name}.md"), findings(made, sources, rows, out.name)))
    return written


def _measure(
    series: Mapping[str, Series],
    runs: int | None,
    out: Path,
    jobs: int,
    address: str | None,
    progress: Progress,
) -> Rows:
    """The rows of every series, measured if they are not in `out` yet."""
    if not series:
        return {}
    rows = {}
    with open_executor(jobs, address) as executor:
        for name, one in series.items():
            rows[name] = measure(one.trials(runs), out / "rows" / f"{name}.csv", executor, progress, f"{name}: ")
    return rows


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, text)
    return path
