"""The problems that trials are run on: each has a cost, a box, and what else is measured of an optimum."""

from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.experiments.cec2022 import cec2022
from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimum


@dataclass(frozen=True)
class Problem:
    """What is minimised, (n, D) -> (n,), inside which box, and the further measures of what was found."""

    cost: Callable[[Candidates], Costs]
    box: Box
    measure: Callable[[Optimum], dict[str, float]]


def _cec2022(case: str, dimension: int) -> Problem:
    cost, box = cec2022(case, dimension)
    return Problem(cost, box, lambda _found: {})


PROBLEMS: dict[str, Callable[[str, int], Problem]] = {"cec2022": _cec2022}
