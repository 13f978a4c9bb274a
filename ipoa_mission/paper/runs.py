"""`run_trial` is a pure function (except for the seconds): process, machine and order do not matter."""

import json
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from datetime import date
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_info, threadpool_limits

from ipoa_mission.errors import imported
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import Box, Candidates, Costs, CountedCost, Optimum, minimize
from ipoa_mission.paper.problems import Problem, campus_problem, cec2022, map_scenario, path_problem
from ipoa_mission.paper.rows import Trial, TrialRow, line_of, open_to_append, read_rows
from ipoa_mission.progress import Progress, count, silent

Rival = Callable[[Callable[[Candidates], Costs], Box, int, np.random.Generator], Optimum]


def _by_minionpy(
    name: str, cost: Callable[[Candidates], Costs], box: Box, budget: int, rng: np.random.Generator
) -> Optimum:
    algorithms = imported("minionpy.algorithms", f"{name} needs minionpy, which is not installed", "paper")
    counted = CountedCost(cost, box, budget)

    def call(candidates: Any) -> list[float]:
        costs = counted(np.asarray(candidates, dtype=np.float64))
        return list(np.where(np.isfinite(costs), costs, 1e300))

    bounds = list(zip(box.lower.tolist(), box.upper.tolist(), strict=True))
    getattr(algorithms, name)(call, bounds, maxevals=budget, seed=int(rng.integers(2**31)), options={}).optimize()
    return counted.optimum()


def _by_scipy(cost: Callable[[Candidates], Costs], box: Box, budget: int, rng: np.random.Generator) -> Optimum:
    """Minimize with scipy's defaults, a population of 5 D, and no polish."""
    from scipy.optimize import differential_evolution

    counted = CountedCost(cost, box, budget)
    population = 5 * box.dimension
    differential_evolution(
        lambda x: counted(x.T),
        list(zip(box.lower, box.upper, strict=True)),
        popsize=5,
        maxiter=budget // population + 1,
        tol=0,
        atol=0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=rng,
    )
    return counted.optimum()


RIVALS: dict[str, Rival] = {
    "rcmaes": partial(_by_minionpy, "RCMAES"),  # CMA-ES with restarts
    "lshade": partial(_by_minionpy, "LSHADE"),
    "de": _by_scipy,
}

#: shares of a run's evaluations
CHECKPOINTS = np.linspace(0, 1, 26)


def run_trial(trial: Trial) -> TrialRow:
    with threadpool_limits(1, "blas"):  # two threads sum in another order
        return _run(trial)


def _problem_of(trial: Trial) -> Problem:
    if trial.problem == "cec2022":
        return cec2022(trial.case, trial.dimension)
    return campus_problem() if trial.problem == "campus" else path_problem(map_scenario(trial.case))


def _run(trial: Trial) -> TrialRow:
    problem = _problem_of(trial)
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
    trials: Iterable[Trial], path: Path, executor: Executor, progress: Progress = silent, label: str = ""
) -> list[TrialRow]:
    """Run the trials that `path` lacks, and return all rows in their order."""
    wanted = list(dict.fromkeys(trials))
    row_of = {row.trial: row for row in read_rows(path)}
    if row_of.keys() >= set(wanted):
        count(progress, len(wanted), len(wanted), label)
        return [row_of[trial] for trial in wanted]
    with open_to_append(path) as file:
        row_of = {row.trial: row for row in read_rows(path)}  # read again under the lock
        missing = [trial for trial in wanted if trial not in row_of]
        done = len(wanted) - len(missing)
        count(progress, done, len(wanted), label)
        waiting = [executor.submit(run_trial, trial) for trial in missing]
        try:
            for future in as_completed(waiting):
                row = future.result()
                row_of[row.trial] = row
                file.write(line_of(row))
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
