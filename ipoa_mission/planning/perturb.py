"""Iterated local search: beside a curve that is locally best there may be another that is cheaper."""

from collections.abc import Iterator

import numpy as np

from ipoa_mission.planning.polish import polish
from ipoa_mission.planning.problem import Candidate, PreparedProblem
from ipoa_mission.planning.spline import Spline
from ipoa_mission.planning.strategy import SearchStrategy


def perturbed(trail: Candidate, problem: PreparedProblem, strategy: SearchStrategy) -> Iterator[Candidate]:
    """A cheaper curve, if there is one: one piece after the other bent to either side and polished again.

    Of the pieces of a long curve, random ones miss some; a short one is not looked at. Nor is one through via points,
    which it would miss.
    """
    count, cost, cheapest = len(trail.curve.control) - 2, problem.cost(trail), trail
    if count < strategy.kicked_control_points or len(trail.via_at):
        return
    bend = np.sin(np.pi * (np.arange(strategy.piece) + 0.5) / strategy.piece)[:, None]
    for first in range(0, count - strategy.piece + 1, strategy.piece // 2):
        piece = slice(first, first + strategy.piece)
        for side in (-strategy.perturb, strategy.perturb):
            control = cheapest.curve.control.copy()
            inner = control[1:-1][piece]
            ahead = np.gradient(inner[:, :2], axis=0)
            inner[:, :2] += side * len(inner) * bend * np.column_stack([-ahead[:, 1], ahead[:, 0]])
            polished = polish(Candidate(Spline(control), trail.via_at), problem, part=piece)
            if (again := problem.cost(polished)) < (1 - strategy.least_gain) * cost:
                cost, cheapest = again, polished
    if cheapest is not trail:
        yield cheapest
