"""`run_trial` is a pure function (except for the seconds): process, machine and order do not matter."""

import json
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info, threadpool_limits

from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import Optimum, minimize
from ipoa_mission.paper import problems
from ipoa_mission.paper.published import ALGORITHMS
from ipoa_mission.paper.rows import Trial, TrialRow, open_to_append, read_rows, write_row
from ipoa_mission.progress import Progress, count, silent


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

#: shares of a run's evaluations
CHECKPOINTS = np.linspace(0, 1, 26)


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
    return TrialRow(
        trial,
        optimum.cost,
        int(optimum.evaluations[-1]),
        seconds,
        _at_checkpoints(optimum),
        measures,
        date.today().isoformat(),
        _versions(),
    )


def measure(
    trials: Iterable[Trial], path: Path, executor: Executor, progress: Progress = silent, label: str = ""
) -> list[TrialRow]:
    """Run the trials that `path` lacks, and return all rows in their order."""
    wanted = list(dict.fromkeys(trials))
    row_of = {row.trial: row for row in read_rows(path)}
    missing = [trial for trial in wanted if trial not in row_of]
    done = len(wanted) - len(missing)
    count(progress, done, len(wanted), label)
    if not missing:
        return [row_of[trial] for trial in wanted]
    with open_to_append(path) as file:
        waiting = [executor.submit(run_trial, trial) for trial in missing]
        try:
            for future in as_completed(waiting):
                row = future.result()
                row_of[row.trial] = row
                write_row(file, row)
                file.flush()
                done += 1
                count(progress, done, len(wanted), label)
        finally:
            for future in waiting:
                future.cancel()
    return [row_of[trial] for trial in wanted]


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
