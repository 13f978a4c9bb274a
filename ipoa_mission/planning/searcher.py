"""Run an optimizer in the space around a curve."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import polyline_length
from ipoa_mission.optimize.registry import build_optimizer, optimizer_class
from ipoa_mission.optimize.search import Optimizer, minimize
from ipoa_mission.optimize.settings import SHORT_EVALUATIONS
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.problem import ALL, Candidate, PreparedProblem, surround
from ipoa_mission.planning.strategy import SearchStrategy
from ipoa_mission.progress import Progress, silent


@dataclass
class Searcher:
    """Successive searches with one stream of random numbers."""

    problem: PreparedProblem
    optimizer: Optimizer
    rng: np.random.Generator
    strategy: SearchStrategy
    budget: int | None = None
    spent: list[int] = field(default_factory=list)
    best: list[float] = field(default_factory=list)

    def search(
        self,
        around: Candidate,
        width: float,
        part: slice = ALL,
        progress: Progress = silent,
    ) -> Candidate:
        """Return the best curve found around one, or around a `part` of it.

        `width` is a share of the varied length.
        """
        task = self.problem.task
        spread = width * polyline_length(around.curve.control[1:-1][part])
        encoding = surround(encoding_of(task), around, spread, task, part)
        costs, box = self.problem.costs(encoding), encoding.box
        optimum = minimize(costs, box, self.optimizer, self.rng, budget=self.budget, progress=progress)
        spent, best = (self.spent[-1], self.best[-1]) if self.spent else (0, np.inf)
        self.spent += [spent + int(evaluations) for evaluations in optimum.evaluations]
        candidate = Candidate(encoding.curve(optimum.x), around.via_at)
        if part == ALL:
            self.best += [min(best, float(cost)) for cost in optimum.history]
        else:
            self.best += [best] * (len(optimum.history) - 1) + [min(best, self.problem.cost(candidate))]
        return candidate

    def history(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the evaluations spent and the best cost by then, (k,) each."""
        return np.array(self.spent), np.array(self.best)


def encoding_of(task: PathTask) -> str:
    return task.planning.encoding or ("absolute" if task.planning.planner == "paper" else "sine")


def optimizer_of(task: PathTask, short: bool) -> tuple[Optimizer, int | None]:
    """Return the task's optimizer and its budget; if `short`, its `short_settings` complete the settings.

    Raises:
        BadInput: there is no such optimizer, or it has no such setting.
    """
    name, settings = task.optimizer.name, task.optimizer.settings
    defaults = getattr(optimizer_class(name), "short_settings", None) if short else {}
    budget = SHORT_EVALUATIONS if defaults is None and not settings else None
    return build_optimizer(name, (defaults or {}) | settings), budget
