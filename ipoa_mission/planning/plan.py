"""What planning comes to: a curve, what it costs, and the proof that it may be flown."""

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
    """A path that may be flown; `plan_path` makes it.

    Attributes:
        curve: the path, a spline.
        cost: what it costs, term by term.
        proof: that it keeps every limit, and how near it comes.
        optimizer: the name of the search algorithm.
        seed: what its random numbers began with.
        evaluations: costs that had been worked out, (n,) ...
        history: ... when this was the best cost known, (n,).
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
        """The same path with its cost and its proof by another `task`, as by one that asks for less room."""
        return replace(self, cost=curve_cost(self.curve, task), proof=prove_curve(self.curve, task))

    def __repr__(self) -> str:
        cost, count = float(self.history[-1]), int(self.evaluations[-1])
        return f"<Plan: {self.curve.length:.1f} m, cost {cost:.4f}, by {self.optimizer}, {count} evaluations>"
