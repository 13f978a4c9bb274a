"""Measure missing runs, then write tables, figures and their page."""

import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from ipoa_mission.errors import MissionError, UnknownName, hint_of
from ipoa_mission.files import write_atomically
from ipoa_mission.paper import figures, tables
from ipoa_mission.paper.markdown_table import Table, filled
from ipoa_mission.paper.problems import campus_scenario, map_scenario
from ipoa_mission.paper.runs import SERIES, Rows, Series, TrialRow, measure, runs_of
from ipoa_mission.progress import Progress, silent


@contextmanager
def open_processes(count: int) -> Iterator[Executor]:
    ignore_ctrl_c = (signal.SIGINT, signal.SIG_IGN)  # it ends the parent
    try:
        with ProcessPoolExecutor(count, initializer=signal.signal, initargs=ignore_ctrl_c) as pool:
            yield pool
    except BrokenProcessPool as error:
        raise MissionError(
            "a process that ran trials was killed",
            hint="perhaps by lack of memory; the same command continues",
            code="process-killed",
        ) from error


@dataclass(frozen=True)
class Artifact:
    needs: Sequence[Series]
    make: Callable[[Rows], Table | str]


def _of(make: Callable[..., Table | str], *needs: str) -> Artifact:
    return Artifact([SERIES[name] for name in needs], lambda rows: make(*(rows[name] for name in needs)))


def _paths(*cases: str) -> Callable[[Sequence[TrialRow]], str]:
    return lambda rows: figures.paths_on_maps(rows, {case: map_scenario(case) for case in cases})


ITEMS: dict[str, Artifact] = {
    "table-3": _of(tables.table_3, "cec2022-d20"),
    "table-4": _of(tables.table_4, "cec2022-d20"),
    "figure-3": _of(figures.figure_3),
    "figure-5": _of(figures.figure_5),
    "figure-7": _of(figures.figure_7, "cec2022-d20"),
    "figure-8": _of(figures.figure_8, "cec2022-d10"),
    "dimension": _of(tables.dimension_of_the_print, "cec2022-d20", "cec2022-d10"),
    "contradictions": _of(tables.contradictions),
    "table-8": _of(tables.table_8, "campus"),
    "figure-11": _of(lambda rows: figures.paths_on_maps(rows, {"campus": campus_scenario()}), "campus"),
    "improvements": _of(tables.table_improvements),
    "table-5": _of(tables.table_5, "maps"),
    "table-6": _of(tables.table_6, "maps"),
    "table-7": _of(tables.table_7, "maps"),
    "figure-9": _of(_paths(*(f"map-8-{k}" for k in range(1, 6))), "maps"),
    "figure-10": _of(_paths("map-6-1", "map-10-1"), "maps"),
}


def reproduce(
    what: str, runs: int | None, out: Path, pool: AbstractContextManager[Executor], progress: Progress = silent
) -> list[Path]:
    """Measure and write one of `ITEMS`, or "all" with a page.

    `out` gets tables as Markdown, figures as SVG, and `rows`, which are not measured again. `runs`: of each;
    None as in the paper. `pool`: of `open_processes`; it is not opened if nothing needs a run.
    """
    if what != "all" and what not in ITEMS:
        words = f"expected {', '.join(ITEMS)} or all, not {what!r}"
        raise UnknownName(words, hint=hint_of(what, [*ITEMS, "all"]), place="what")
    names = list(ITEMS) if what == "all" else [what]
    needed = {series.name: series for name in names for series in ITEMS[name].needs}
    rows: dict[str, Sequence[TrialRow]] = {}
    if needed:
        with pool as executor:
            for name, series in needed.items():
                rows[name] = measure(series.trials(runs), out / "rows" / f"{name}.csv", executor, progress, f"{name}: ")
    made = {name: ITEMS[name].make(rows) for name in names}
    texts = dict[Path, str]()
    for name, item in made.items():
        if isinstance(item, Table):
            texts[out / f"{name}.md"] = item.markdown()
        else:
            texts[out / f"{name}.svg"] = item
    if what == "all":
        texts[out / "README.md"] = page(made, rows)
    out.mkdir(parents=True, exist_ok=True)
    for path, text in texts.items():
        write_atomically(path, text)
    return list(texts)


def page(made: Mapping[str, Table | str], rows: Rows) -> str:
    shown = {name: _shown(name, item) for name, item in made.items()}
    words = files("ipoa_mission.paper").joinpath("page.md").read_text(encoding="utf-8")
    return filled(words.format_map({**shown, "measured": _measured(rows)}))


def _shown(name: str, item: Table | str) -> str:
    shown = item.markdown() if isinstance(item, Table) else f"![{name}]({name}.svg)\n"
    linked = ", ".join(f"[`{series.name}.csv`](rows/{series.name}.csv)" for series in ITEMS[name].needs)
    return f"{shown}\n*`ipoa-mission reproduce {name}`; {f'rows: {linked}' if linked else 'needs no runs'}.*"


def _measured(rows: Rows) -> str:
    lines = ["| series | runs | rows | measured | versions | CPU |", "| --- | --- | --- | --- | --- | --- |"]
    for name, series in rows.items():
        dates = sorted({row.date for row in series})
        versions = "; ".join(sorted({row.versions for row in series}))
        minutes = sum(row.seconds for row in series) / 60
        when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
        lines.append(f"| {name} | {runs_of(series)} | {len(series)} | {when} | {versions} | {minutes:.1f} min |")
    return "\n".join(lines)
