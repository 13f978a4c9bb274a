"""What trials are run on: a cost, a box, and what else is measured of what was found."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimum

#: Named measures of an optimum: a number, or the numbers of a vector.
Measures: TypeAlias = dict[str, float | list[float]]


@dataclass(frozen=True)
class Problem:
    """What is minimized, (n, D) -> (n,), inside which box, and the further measures of what was found."""

    cost: Callable[[Candidates], Costs]
    box: Box
    measure: Callable[[Optimum], Measures] = lambda _found: {}
