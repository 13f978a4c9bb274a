"""`fly` a second time, compiled by numba: one source, two speeds.

Compiling takes seconds, once on a machine (numba keeps the result); after that a flight takes a millisecond. Both say
the same, so the choice is one of time only.
"""

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from ipoa_mission.dynamics.px4 import flight
from ipoa_mission.dynamics.px4.flight import fly
from ipoa_mission.dynamics.px4.state import Law, Order, record_type

ROOM = Path(__file__).parent
HERE = __package__ + "."
MANY_STEPS = 50_000  # so many take plain Python as long as it takes to load numba and what it has kept
Flown = tuple[list[float], list[float]]


def flying(orders: Sequence[Order], law: Law, fast: bool | None, steps: float) -> Callable[..., Flown]:
    """`fly` for these orders, as a function of height, seeds and `every`: compiled if `fast`, plain if not.

    None takes whichever is sooner ready with so many steps.
    """
    if fast is None:
        fast = compiled.cache_info().currsize > 0 or (steps > MANY_STEPS and _is_kept())
    if not fast:
        return lambda *how: fly(orders, (law,), *how)
    machine = compiled()
    records, laws = np.array(list(orders), record_type(Order)), np.array([law], record_type(Law))
    return lambda *how: machine(records, laws, *how)


@lru_cache(maxsize=1)
def compiled() -> Callable[..., Flown]:
    """`fly` compiled, with all functions of this room that it calls."""
    import numba
    from numba.extending import register_jitable

    for function in _called(flight):
        if function is not fly:
            register_jitable(error_model="numpy", no_cfunc_wrapper=True, forceinline=True)(function)
    machine: Callable[..., Flown] = numba.njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)(fly)
    if not _is_kept():
        for kept in _kept():
            kept.unlink(missing_ok=True)
    return machine


def _called(module: Any) -> set[FunctionType]:
    """The functions of this room that a module has or imports, and those that they call."""
    found: set[FunctionType] = set()
    names = {module.__name__}
    while names:
        module = sys.modules[names.pop()]
        for function in vars(module).values():
            if isinstance(function, FunctionType) and function.__module__.startswith(HERE) and function not in found:
                found.add(function)
                names.add(function.__module__)
    return found


def _kept() -> list[Path]:
    return list((ROOM / "__pycache__").glob("flight.fly-*.nbi"))


def _is_kept() -> bool:
    """Whether numba has kept the compiled flight beside its source, and no source has changed since."""
    written = max(source.stat().st_mtime for source in ROOM.glob("*.py"))
    return any(index.stat().st_mtime > written for index in _kept())
