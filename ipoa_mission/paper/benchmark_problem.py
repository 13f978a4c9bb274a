from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimum

Measures: TypeAlias = dict[str, float | list[float]]


@dataclass(frozen=True)
class Problem:
    """A cost (n, D) -> (n,) to minimize, its box, and further measures of an optimum."""

    cost: Callable[[Candidates], Costs]
    box: Box
    measure: Callable[[Optimum], Measures] = lambda _found: {}
