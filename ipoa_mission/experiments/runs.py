"""Measuring: runs are rows appended to a CSV file; a run that is there already is not repeated.

A trial says what to run; `run_trial` is a pure function of it (but for the seconds), so it does not matter which
process or which machine runs it, nor in which order. Whoever runs it, the rows are written here, one whole line at a
time: a series that was interrupted goes on where it stopped.
"""

import csv
import io
import json
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import astuple, dataclass, fields
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.experiments.campus import campus_problem
from ipoa_mission.experiments.cec2022 import cec2022
from ipoa_mission.experiments.maps import map_problem
from ipoa_mission.experiments.problem import Measures, Problem
from ipoa_mission.experiments.rivals import RIVALS
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import Optimum, minimise

#: Where along a run its best cost is kept: shares of the evaluations it spent.
CHECKPOINTS = np.linspace(0, 1, 26)


#: Each makes a problem of a trial's case and dimension.
PROBLEMS: dict[str, Callable[[str, int], Problem]] = {"cec2022": cec2022, "map": map_problem, "campus": campus_problem}


@dataclass(frozen=True)
class Trial:
    """One run of one algorithm on one problem; the run's number is its seed, the same for all algorithms.

    `settings` is JSON with sorted keys, "{}" for defaults. `budget` ends the run; 0 lets the algorithm's own number of
    iterations end it.
    """

    problem: str
    case: str
    dimension: int
    algorithm: str
    settings: str
    budget: int
    run: int


@dataclass(frozen=True)
class Row:
    """A trial and what came of it. `history` is the best cost at `CHECKPOINTS`; `measures` is what else was asked."""

    trial: Trial
    cost: float
    evaluations: int
    seconds: float
    history: tuple[float, ...]
    measures: Measures
    date: str
    versions: str


def settings_text(**settings: object) -> str:
    """Settings as a trial carries them."""
    return json.dumps(settings, sort_keys=True)


def run_trial(trial: Trial) -> Row:
    """Run `trial` and say what came of it.

    Raises:
        BadInput: no such problem, algorithm or setting.
    """
    if trial.problem not in PROBLEMS:
        raise BadInput(f"problem: expected {' or '.join(PROBLEMS)}, not {trial.problem!r}")
    problem = PROBLEMS[trial.problem](trial.case, trial.dimension)
    rng = np.random.default_rng([*trial.problem.encode(), *trial.case.encode(), trial.dimension, trial.run])
    started = time.process_time()
    if trial.algorithm in RIVALS:
        found = RIVALS[trial.algorithm](problem.cost, problem.box, trial.budget, rng)
    else:
        optimizer = build_optimizer(trial.algorithm, json.loads(trial.settings))
        found = minimise(problem.cost, problem.box, optimizer, rng, trial.budget or None)
    seconds = time.process_time() - started
    return Row(
        trial,
        found.cost,
        int(found.evaluations[-1]),
        seconds,
        _at_checkpoints(found),
        problem.measure(found),
        date.today().isoformat(),
        _versions(),
    )


def measure(
    trials: Iterable[Trial],
    path: Path,
    executor: Executor,
    progress: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """Run what `path` does not hold yet, append it there, and return the rows of all `trials`, in their order.

    `progress(done, all)` is called at the start and after each run.
    """
    wanted = list(dict.fromkeys(trials))
    known = {row.trial: row for row in read_rows(path)}
    missing = [trial for trial in wanted if trial not in known]
    done = len(wanted) - len(missing)
    if progress is not None:
        progress(done, len(wanted))
    if missing:
        with _appendable(path) as file:
            waiting = {executor.submit(run_trial, trial) for trial in missing}
            for future in as_completed(waiting):
                row = future.result()
                known[row.trial] = row
                file.write(_line(row))
                file.flush()
                done += 1
                if progress is not None:
                    progress(done, len(wanted))
    return [known[trial] for trial in wanted]


_COLUMNS = [f.name for f in fields(Trial)] + [f.name for f in fields(Row) if f.name != "trial"]


def read_rows(path: Path) -> list[Row]:
    """All rows of a file of runs; none if it is not there. A last line that was cut off is no row.

    Raises:
        BadInput: the file is not a file of runs; the message names the line.
    """
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()
    if lines and lines[0].rstrip("\n") != ",".join(_COLUMNS):
        raise BadInput(f"{path}:1: expected the columns {','.join(_COLUMNS)}")
    return list(_rows(path, lines[1:]))


def _rows(path: Path, lines: Sequence[str]) -> Iterator[Row]:
    for number, cells in enumerate(csv.reader(lines), start=2):
        try:
            problem, case, dimension, algorithm, settings, budget, run, cost, spent, seconds, history, *rest = cells
            measures, day, versions = rest
            trial = Trial(problem, case, int(dimension), algorithm, settings, int(budget), int(run))
            curve = tuple(float(h) for h in history.split())
            yield Row(trial, float(cost), int(spent), float(seconds), curve, json.loads(measures), day, versions)
        except ValueError as error:
            raise BadInput(f"{path}:{number}: expected {len(_COLUMNS)} cells of a run: {error}") from error


def _line(row: Row) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(
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
    return text.getvalue()


def _appendable(path: Path) -> io.TextIOWrapper:
    """`path` opened for appending, with its heading, and without a last line that was cut off."""
    path.parent.mkdir(parents=True, exist_ok=True)
    kept = path.read_bytes() if path.exists() else b""
    whole = kept.rfind(b"\n") + 1
    if whole < len(kept):
        with path.open("r+b") as file:
            file.truncate(whole)
    opened = path.open("a", encoding="utf-8", newline="")
    if not whole:
        opened.write(",".join(_COLUMNS) + "\n")
    return opened


def _at_checkpoints(found: Optimum) -> tuple[float, ...]:
    """The best cost known when a share of all evaluations had been spent; before the first batch, its best."""
    spent = np.searchsorted(found.evaluations, CHECKPOINTS * found.evaluations[-1], side="right") - 1
    return tuple(float(h) for h in found.history[np.maximum(spent, 0)])


def _versions() -> str:
    def of(package: str) -> str:
        try:
            return version(package)
        except PackageNotFoundError:
            return "absent"

    return " ".join(f"{package}={of(package)}" for package in ("ipoa-mission", "numpy", "scipy", "minionpy"))
