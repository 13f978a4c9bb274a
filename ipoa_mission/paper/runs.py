"""Trials and their runs, in a CSV file for each series; an incomplete last line is no row.

`run_trial` is a pure function (except for the seconds): process, machine and order do not matter.
"""

import csv
import json
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager, suppress
from dataclasses import astuple, dataclass, fields, replace
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, TextIO, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, TypeAdapter
from threadpoolctl import threadpool_info, threadpool_limits

from ipoa_mission.errors import MissionError, WrongFormat
from ipoa_mission.files import read_text
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import Optimum, minimize
from ipoa_mission.paper import problems
from ipoa_mission.progress import Progress, count, silent

#: columns of all tables; the paper prints Tables 5 to 8 in another order
ALGORITHMS = ("ipoa", "dbo", "poa", "ssa", "mpoa", "hho")
#: shares of a run's evaluations
CHECKPOINTS = np.linspace(0, 1, 26)


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
    history: Annotated[tuple[float, ...], BeforeValidator(str.split)]
    measures: Annotated[problems.Measures, BeforeValidator(json.loads)]
    date: str
    versions: str


Rows: TypeAlias = Mapping[str, Sequence[TrialRow]]


@dataclass(frozen=True)
class Series:
    name: str
    runs: int
    firsts: Sequence[Trial]

    def trials(self, runs: int | None) -> list[Trial]:
        """`runs` None: the paper's number."""
        return [replace(t, run=run) for run in range(self.runs if runs is None else runs) for t in self.firsts]


def _trials(problem: str, cases: Sequence[str], dimension: int) -> list[Trial]:
    return [Trial(problem, case, dimension, name, "{}", 0, 0) for case in cases for name in ALGORITHMS]


_WEIGHTED = [f"map-8-1/{experiment}" for experiment in problems.WEIGHTS]
SERIES = {
    series.name: series
    for series in (
        Series("cec2022-d20", 30, _trials("cec2022", problems.FUNCTIONS, 20)),
        Series("cec2022-d10", 30, _trials("cec2022", problems.FUNCTIONS, 10)),
        Series("maps", 10, _trials("map", (*_WEIGHTED, *problems.MAPS), 3 * problems.INNER)),
        Series("campus", 20, _trials("campus", ("campus",), 3 * problems.INNER)),
    )
}


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


def _problem_of(trial: Trial) -> problems.Problem:
    if trial.problem == "cec2022":
        return problems.cec2022(trial.case, trial.dimension)
    if trial.problem == "campus":
        return problems.campus_problem()
    return problems.path_problem(problems.map_scenario(trial.case))


def run_trial(trial: Trial) -> TrialRow:
    rng = np.random.default_rng([*trial.problem.encode(), *trial.case.encode(), trial.dimension, trial.run])
    with threadpool_limits(1, "blas"):  # two threads sum in another order
        problem = _problem_of(trial)
        started = time.process_time()
        optimizer = build_optimizer(trial.algorithm, json.loads(trial.settings))
        optimum = minimize(problem.cost, problem.box, optimizer, rng, budget=trial.budget or None)
        seconds = time.process_time() - started
        measures = problem.measure(optimum)
    evaluations = int(optimum.evaluations[-1])
    today = date.today().isoformat()
    return TrialRow(trial, optimum.cost, evaluations, seconds, _at_checkpoints(optimum), measures, today, _versions())


def _at_checkpoints(optimum: Optimum) -> tuple[float, ...]:
    spent = np.searchsorted(optimum.evaluations, CHECKPOINTS * optimum.evaluations[-1], side="right") - 1
    return tuple(float(h) for h in optimum.history[np.maximum(spent, 0)])


def _versions() -> str:
    """Return package versions and NumPy's BLAS kernels: they determine the last digits."""

    def of(package: str) -> str:
        try:
            return version(package)
        except PackageNotFoundError:
            return "absent"

    packages = [f"{package}={of(package)}" for package in ("ipoa-mission", "numpy", "scipy", "minionpy")]
    kernels = sorted({info.get("architecture", info["internal_api"]) for info in threadpool_info()})
    return " ".join([*packages, f"blas={'+'.join(kernels)}"])


def measure(
    trials: Iterable[Trial], path: Path, executor: Executor, progress: Progress = silent, label: str = ""
) -> list[TrialRow]:
    """Run the trials that `path` lacks, and return all rows in their order. Raises MissionError if it is locked."""
    wanted = list(dict.fromkeys(trials))
    with _locked(path) as file:
        row_of = {row.trial: row for row in read_rows(path)}
        missing = [trial for trial in wanted if trial not in row_of]
        done = len(wanted) - len(missing)
        count(progress, done, len(wanted), label)
        waiting = [executor.submit(run_trial, trial) for trial in missing]
        try:
            for future in as_completed(waiting):
                row = future.result()
                row_of[row.trial] = row
                _write_row(file, row)
                done += 1
                count(progress, done, len(wanted), label)
        finally:
            for future in waiting:
                future.cancel()
    return [row_of[trial] for trial in wanted]


_COLUMNS = [f.name for f in fields(Trial)] + [f.name for f in fields(TrialRow) if f.name != "trial"]


@contextmanager
def _locked(path: Path) -> Iterator[TextIO]:
    """Open a file to append whole rows; no other process may, except on Windows."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8", newline="") as file:
        try:
            with suppress(ImportError):
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            hint = "wait for its end, or write elsewhere: --out"
            raise MissionError("another process adds runs to it", hint=hint, code="in-use", place=path) from error
        whole = path.read_bytes().rfind(b"\n") + 1
        file.truncate(whole)
        if not whole:
            file.write(",".join(_COLUMNS) + "\n")
            file.flush()
        yield file


def _write_row(file: TextIO, row: TrialRow) -> None:
    cells = [*astuple(row.trial), repr(row.cost), row.evaluations, f"{row.seconds:.3f}"]
    cells += [" ".join(f"{h:.5g}" for h in row.history), json.dumps(row.measures), row.date, row.versions]
    csv.writer(file, lineterminator="\n").writerow(cells)
    file.flush()


def read_rows(path: Path) -> list[TrialRow]:
    lines = read_text(path).splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()
    if lines and lines[0].rstrip("\n") != ",".join(_COLUMNS):
        raise WrongFormat(f"expected the columns {','.join(_COLUMNS)}", place=f"{path}:1")
    return list(_rows(path, lines[1:]))


def _rows(path: Path, lines: Sequence[str]) -> Iterator[TrialRow]:
    row = TypeAdapter(TrialRow)
    for number, cells in enumerate(csv.DictReader(lines, _COLUMNS), start=2):
        try:
            yield row.validate_python(cells | {"trial": cells})
        except ValueError as error:
            raise WrongFormat(f"expected {len(_COLUMNS)} cells of a run: {error}", place=f"{path}:{number}") from error
