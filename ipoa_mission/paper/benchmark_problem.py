"""Define an optimization problem for trials: a cost, a box, and further measures of an optimum."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimum

#: Named measures of an optimum: numbers or vectors.
Measures: TypeAlias = dict[str, float | list[float]]


@dataclass(frozen=True)
class Problem:
    """Define a cost (n, D) -> (n,) to minimize, its box, and further measures of an optimum."""

    cost: Callable[[Candidates], Costs]
    box: Box
    measure: Callable[[Optimum], Measures] = lambda _found: {}
