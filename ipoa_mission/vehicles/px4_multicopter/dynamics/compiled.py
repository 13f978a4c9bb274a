"""`fly` a second time, compiled: one source, two speeds.

The machine code is what was shipped, or numba's: that takes seconds, once on a machine (numba keeps the result). A
flight then takes a millisecond. Both speeds say the same, so the choice is one of time only.
"""

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from ipoa_mission.compiled import njit
from ipoa_mission.compiled.library import shipped
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.vehicles.px4_multicopter.dynamics import flight
from ipoa_mission.vehicles.px4_multicopter.dynamics.flight import fly
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Law, Order, record_type

ROOM = Path(__file__).parent
HERE = __package__ + "."
MANY_STEPS = 50_000  # so many take plain Python as long as it takes to load numba and what it has kept
Flown = tuple[Vector, Points]


def flying(orders: Sequence[Order], law: Law, fast: bool | None, steps: float) -> Callable[..., Flown]:
    """`fly` for these orders, as a function of height, seeds and `every`: compiled if `fast`, plain if not.

    None takes whichever is sooner ready with so many steps.
    """
    if fast is None:
        at_hand = shipped() is not None or compiled.cache_info().currsize > 0
        fast = at_hand or (steps > MANY_STEPS and _is_kept())
    if not fast:
        return lambda *how: fly(orders, (law,), *how)
    machine = compiled()
    arguments = records(orders, Order), records([law], Law)
    return lambda *how: machine(*arguments, *how)


def records(tuples: Sequence[Any], kind: type) -> Any:
    """Named tuples of one kind as an array of records."""
    return np.array(list(tuples), record_type(kind))


@lru_cache(maxsize=1)
def compiled() -> Callable[..., Flown]:
    """`fly` compiled, with all functions of this room that it calls."""
    kernels = shipped()
    if kernels is not None:
        return kernels[f"{flight.__name__}.{fly.__name__}"]
    machine: Callable[..., Flown] = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)(fly)
    from numba.extending import register_jitable

    for function in _called(flight):
        if function is not fly:
            register_jitable(error_model="numpy", no_cfunc_wrapper=True, forceinline=True)(function)
    if not _is_kept():
        for kept in _kept():
            kept.unlink(missing_ok=True)
    return machine


def _called(module: Any) -> set[FunctionType]:
    """The functions of this room that a module has or imports, and those that they call."""
    kernels: set[FunctionType] = set()
    names = {module.__name__}
    while names:
        module = sys.modules[names.pop()]
        for function in vars(module).values():
            if isinstance(function, FunctionType) and function.__module__.startswith(HERE) and function not in kernels:
                kernels.add(function)
                names.add(function.__module__)
    return kernels


def _kept() -> list[Path]:
    return list((ROOM / "__pycache__").glob("flight.fly-*.nbi"))


def _is_kept() -> bool:
    """Whether numba has kept the compiled flight beside its source, and no source has changed since."""
    written = max(source.stat().st_mtime for source in ROOM.glob("*.py"))
    return any(index.stat().st_mtime > written for index in _kept())
