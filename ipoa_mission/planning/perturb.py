"""Iterated local search."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.planning.polish import polish
from ipoa_mission.planning.problem import Candidate, PreparedProblem
from ipoa_mission.planning.spline import Spline
from ipoa_mission.planning.strategy import SearchStrategy


def perturbed(candidate: Candidate, problem: PreparedProblem, strategy: SearchStrategy) -> Iterator[Candidate]:
    """Yield a cheaper curve: bend one piece after the other and polish again.

    Not for short curves, nor with via points, which a bend would miss.
    """
    count, cost, cheapest = len(candidate.curve.control) - 2, problem.cost(candidate), candidate
    if count < strategy.perturbed_control_points or len(candidate.via_at):
        return
    bend = np.sin(np.pi * (np.arange(strategy.piece) + 0.5) / strategy.piece)[:, None]
    for first in range(0, count - strategy.piece + 1, strategy.piece // 2):
        piece = slice(first, first + strategy.piece)
        for side in (-strategy.perturb, strategy.perturb):
            control = cheapest.curve.control.copy()
            inner = control[1:-1][piece]
            ahead = np.gradient(inner[:, :2], axis=0)
            inner[:, :2] += side * len(inner) * bend * np.column_stack([-ahead[:, 1], ahead[:, 0]])
            polished = polish(Candidate(Spline(control), candidate.via_at), problem, part=piece)
            if (again := problem.cost(polished)) < (1 - strategy.least_gain) * cost:
                cost, cheapest = again, polished
    if cheapest is not candidate:
        yield cheapest
