"""`run_trial` is a pure function (except for the seconds): process, machine and order do not matter."""

import json
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info, threadpool_limits

from ipoa_mission.errors import UnknownName
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import Optimum, minimize
from ipoa_mission.paper.campus import campus_problem
from ipoa_mission.paper.cec2022 import Problem, cec2022
from ipoa_mission.paper.paper_maps import map_problem
from ipoa_mission.paper.peers import RIVALS
from ipoa_mission.paper.rows import Trial, TrialRow, line_of, open_to_append, read_rows
from ipoa_mission.progress import Progress, count, silent

#: shares of a run's evaluations
CHECKPOINTS = np.linspace(0, 1, 26)


PROBLEMS: dict[str, Callable[[str, int], Problem]] = {"cec2022": cec2022, "map": map_problem, "campus": campus_problem}


def run_trial(trial: Trial) -> TrialRow:
    """Raises BadInput."""
    if trial.problem not in PROBLEMS:
        raise UnknownName(f"expected {' or '.join(PROBLEMS)}, not {trial.problem!r}", place="problem")
    with threadpool_limits(1, "blas"):  # two threads sum in another order
        return _run(trial)


def _run(trial: Trial) -> TrialRow:
    problem = PROBLEMS[trial.problem](trial.case, trial.dimension)
    rng = np.random.default_rng([*trial.problem.encode(), *trial.case.encode(), trial.dimension, trial.run])
    started = time.process_time()
    if trial.algorithm in RIVALS:
        optimum = RIVALS[trial.algorithm](problem.cost, problem.box, trial.budget, rng)
    else:
        optimizer = build_optimizer(trial.algorithm, json.loads(trial.settings))
        optimum = minimize(problem.cost, problem.box, optimizer, rng, budget=trial.budget or None)
    seconds = time.process_time() - started
    return TrialRow(
        trial,
        optimum.cost,
        int(optimum.evaluations[-1]),
        seconds,
        _at_checkpoints(optimum),
        problem.measure(optimum),
        date.today().isoformat(),
        _versions(),
    )


def measure(
    trials: Iterable[Trial], path: Path, executor: Executor, progress: Progress = silent, what: str = ""
) -> list[TrialRow]:
    """Run the trials that `path` lacks, and return all rows in their order. Raises BadInput, MissionError."""
    wanted = list(dict.fromkeys(trials))
    row_of = {row.trial: row for row in read_rows(path)}
    if row_of.keys() >= set(wanted):
        count(progress, len(wanted), len(wanted), what)
        return [row_of[trial] for trial in wanted]
    with open_to_append(path) as file:
        row_of = {row.trial: row for row in read_rows(path)}  # read again under the lock
        missing = [trial for trial in wanted if trial not in row_of]
        done = len(wanted) - len(missing)
        count(progress, done, len(wanted), what)
        waiting = [executor.submit(run_trial, trial) for trial in missing]
        try:
            for future in as_completed(waiting):
                row = future.result()
                row_of[row.trial] = row
                file.write(line_of(row))
                file.flush()
                done += 1
                count(progress, done, len(wanted), what)
        finally:
            for future in waiting:
                future.cancel()
    return [row_of[trial] for trial in wanted]


def _at_checkpoints(optimum: Optimum) -> tuple[float, ...]:
    """Return the best cost after each share of the evaluations."""
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
