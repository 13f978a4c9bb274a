"""One search for a path: an optimizer of the registry let loose in the space round a curve."""

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import polyline_length
from ipoa_mission.optimize.registry import build_optimizer, optimizer_class
from ipoa_mission.optimize.search import Optimizer, minimize
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.problem import ALL, Candidate, PreparedProblem, surround
from ipoa_mission.planning.strategy import SearchStrategy
from ipoa_mission.progress import Progress, silent

#: A search that is one of several may be short: settings for optimizers that have them, where the task sets none.
SHORT = {"population": 20, "iterations": 25, "evaluations": 2500, "evaluations_per_member": 40.0}


@dataclass
class Searcher:
    """Searches one after the other, with one stream of random numbers, and what the best cost was after which."""

    problem: PreparedProblem
    optimizer: Optimizer
    rng: np.random.Generator
    strategy: SearchStrategy
    spent: list[int] = field(default_factory=list)
    best: list[float] = field(default_factory=list)

    def search(
        self,
        around: Candidate,
        width: float,
        part: slice = ALL,
        progress: Progress = silent,
    ) -> Candidate:
        """The best curve found round one, or round a part of its inner control points.

        `width` is how far the search goes, as a share of the length of what is varied; `progress` is `minimize`'s.
        """
        task = self.problem.task
        spread = width * polyline_length(around.curve.control[1:-1][part])
        encoding = surround(encoding_of(task), around, spread, task, part)
        optimum = minimize(self.problem.costs(encoding), encoding.box, self.optimizer, self.rng, progress=progress)
        spent, best = (self.spent[-1], self.best[-1]) if self.spent else (0, np.inf)
        self.spent += [spent + int(evaluations) for evaluations in optimum.evaluations]
        trail = Candidate(encoding.curve(optimum.x), around.via_at)
        if part == ALL:
            self.best += [min(best, float(cost)) for cost in optimum.history]
        else:  # these are costs of a part
            self.best += [best] * (len(optimum.history) - 1) + [min(best, self.problem.cost(trail))]
        return trail

    def history(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Evaluations spent and the best cost known by then, (k,) each."""
        return np.array(self.spent), np.array(self.best)


def encoding_of(task: PathTask) -> str:
    """The name of the search space: the paper's is `absolute`; left open, it is `sine`."""
    return task.planning.encoding or ("absolute" if task.planning.planner == "paper" else "sine")


def optimizer_of(task: PathTask, short: bool) -> Optimizer:
    """The task's optimizer with its settings; what is not set is as in `SHORT`, or else the algorithm's default.

    Raises:
        BadInput: there is no such optimizer, or it has no such setting.
    """
    name, settings = task.optimizer.name, task.optimizer.settings
    if short:
        accepted = {setting.name for setting in fields(optimizer_class(name))}  # type: ignore[arg-type]
        settings = {key: value for key, value in SHORT.items() if key in accepted} | settings
    return build_optimizer(name, settings)
