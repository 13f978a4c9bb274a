from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector
from ipoa_mission.planning.cost import CostTerms, curve_cost
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.proof import Proof, prove_curve
from ipoa_mission.planning.spline import Spline


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """A path that may be flown; made by `plan_path`.

    Attributes:
        curve: the path.
        cost: term by term.
        proof: its clearance from every limit.
        optimizer: the name of the search algorithm.
        seed: of the random numbers.
        evaluations: numbers of evaluated costs, (n,).
        history: best cost after each of these, (n,).
        via_at: the curve's parameters at the places to pass, (k,).
    """

    curve: Spline
    cost: CostTerms
    proof: Proof
    optimizer: str
    seed: int
    evaluations: NDArray[np.int64]
    history: NDArray[np.float64]
    via_at: Vector = field(default_factory=lambda: np.zeros(0))

    def judged_by(self, task: PathTask) -> "Plan":
        """Return the same path with cost and proof for another `task`."""
        return replace(self, cost=curve_cost(self.curve, task), proof=prove_curve(self.curve, task))

    def __repr__(self) -> str:
        cost, count = float(self.history[-1]), int(self.evaluations[-1])
        return f"<Plan: {self.curve.length:.1f} m, cost {cost:.4f}, by {self.optimizer}, {count} evaluations>"
