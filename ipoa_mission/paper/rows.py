"""Runs as CSV: an incomplete last line is ignored, and removed before the next row."""

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import WrongFormat
from ipoa_mission.files import read_text
from ipoa_mission.paper.problems import Measures
from ipoa_mission.paper.published import ALGORITHMS


@dataclass(frozen=True)
class Trial:
    """Define one run; its number is its seed, the same for all algorithms.

    `settings`: JSON with sorted keys. `budget`: evaluations; 0: the algorithm's own number of iterations.
    """

    problem: str
    case: str
    dimension: int
    algorithm: str
    settings: str
    budget: int
    run: int


@dataclass(frozen=True)
class TrialRow:
    """Hold a trial's result; `history`: the best cost at `CHECKPOINTS`."""

    trial: Trial
    cost: float
    evaluations: int
    seconds: float
    history: tuple[float, ...]
    measures: Measures
    date: str
    versions: str


Rows: TypeAlias = Mapping[str, Sequence[TrialRow]]


def runs_of(rows: Sequence[TrialRow]) -> int:
    return 1 + max(row.trial.run for row in rows)


def results(rows: Sequence[TrialRow], case: str, algorithm: str, measure: str | None = None) -> NDArray[np.float64]:
    """Return the cost of every run on a case, or a measure, (runs,). On CEC2022 the optimum is subtracted."""
    values = [
        (row.trial.run, row.cost if measure is None else row.measures[measure])
        for row in rows
        if (row.trial.case, row.trial.algorithm) == (case, algorithm)
    ]
    return np.array([value for _, value in sorted(values)], dtype=np.float64)


def mean_results(rows: Sequence[TrialRow], cases: Sequence[str], measure: str | None = None) -> NDArray[np.float64]:
    return np.array([[results(rows, case, name, measure).mean() for name in ALGORITHMS] for case in cases])


def mean_evaluations(rows: Sequence[TrialRow]) -> str:
    means = {name: np.mean([row.evaluations for row in rows if row.trial.algorithm == name]) for name in ALGORITHMS}
    return ", ".join(f"{name.upper()} {mean:,.0f}" for name, mean in means.items())


_COLUMNS = [f.name for f in fields(Trial)] + [f.name for f in fields(TrialRow) if f.name != "trial"]


def read_rows(path: Path) -> list[TrialRow]:
    if not path.exists():
        return []
    lines = read_text(path).splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()
    if lines and lines[0].rstrip("\n") != ",".join(_COLUMNS):
        raise WrongFormat(f"expected the columns {','.join(_COLUMNS)}", place=f"{path}:1")
    return list(_rows(path, lines[1:]))


def _rows(path: Path, lines: Sequence[str]) -> Iterator[TrialRow]:
    for number, cells in enumerate(csv.reader(lines), start=2):
        try:
            problem, case, dimension, algorithm, settings, budget, run, *measured = cells
            cost, evaluations, seconds, history, measures, day, versions = measured
            trial = Trial(problem, case, int(dimension), algorithm, settings, int(budget), int(run))
            costs = tuple(float(h) for h in history.split())
            yield TrialRow(
                trial, float(cost), int(evaluations), float(seconds), costs, json.loads(measures), day, versions
            )
        except ValueError as error:
            raise WrongFormat(f"expected {len(_COLUMNS)} cells of a run: {error}", place=f"{path}:{number}") from error


def write_row(file: io.TextIOWrapper, row: TrialRow) -> None:
    csv.writer(file, lineterminator="\n").writerow(
        [
            *astuple(row.trial),
            repr(row.cost),
            row.evaluations,
            f"{row.seconds:.3f}",
            " ".join(f"{h:.5g}" for h in row.history),
            json.dumps(row.measures),
            row.date,
            row.versions,
        ]
    )


def open_to_append(path: Path) -> io.TextIOWrapper:
    path.parent.mkdir(parents=True, exist_ok=True)
    opened = path.open("a", encoding="utf-8", newline="")
    whole = path.read_bytes().rfind(b"\n") + 1
    opened.truncate(whole)
    if not whole:
        opened.write(",".join(_COLUMNS) + "\n")
    return opened
