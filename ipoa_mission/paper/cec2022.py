"""Provide CEC2022 by `minionpy`, the organizers' C code; `opfunu` 1.0.4 is wrong on eleven functions."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ipoa_mission.errors import BadInput, UnknownName, imported
from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimum

#: F_i* of Table 1
OPTIMA = (300.0, 400.0, 600.0, 800.0, 900.0, 1800.0, 2000.0, 2200.0, 2300.0, 2400.0, 2600.0, 2700.0)
FUNCTIONS = tuple(f"f{i}" for i in range(1, 13))
DIMENSIONS = (10, 20)


Measures: TypeAlias = dict[str, float | list[float]]


@dataclass(frozen=True)
class Problem:
    """A cost (n, D) -> (n,) to minimize, its box, and further measures of an optimum."""

    cost: Callable[[Candidates], Costs]
    box: Box
    measure: Callable[[Optimum], Measures] = lambda _optimum: {}


def cec2022(function: str, dimension: int) -> Problem:
    """Return the error of "f1" to "f12": cost minus optimum."""
    if function not in FUNCTIONS:
        raise UnknownName(f"expected f1 to f12, not {function!r}", place="function")
    if dimension not in DIMENSIONS:
        raise BadInput(f"expected 10 or 20, not {dimension}", place="dimension")
    cec = imported("minionpy.cec", "the CEC2022 functions need minionpy, which is not installed", "paper")
    number = FUNCTIONS.index(function)
    raw = cec.CEC2022Functions(number + 1, dimension)

    def error_of(candidates: Candidates) -> Costs:
        return np.asarray(raw(candidates), dtype=np.float64) - OPTIMA[number]

    return Problem(error_of, Box(np.full(dimension, -100.0), np.full(dimension, 100.0)))
