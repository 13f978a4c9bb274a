"""Kernels as machine code: compiled when the package was built, or else by numba when they are first needed.

A kernel is one Python function, decorated with `njit`, or handed to `jit_if_faster` where it also runs as plain Python.
A wheel carries the machine code of both, made by `tools/machine_code`: it loads in a millisecond and needs neither
numba nor a writable folder. Where the sources (`library.SOURCES`), the system or the CPU differ from those that it was
made for, numba compiles, as in a checkout, and caches the result until one of these differs.
"""

import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

from ipoa_mission.compiled.library import PACKAGE, shipped, sources_digest
from ipoa_mission.errors import MissionError

Function = TypeVar("Function", bound=Callable[..., Any])
MANY_STEPS = 50_000  # so many take plain Python as long as it takes to load numba and what it has kept


def njit(**options: Any) -> Any:
    """`numba.njit`, for a kernel that may have been compiled before.

    Raises:
        MissionError: there is no machine code for this system, and no numba.
    """

    def decorated(function: Callable[..., Any]) -> Any:
        kernels = shipped()
        if kernels is not None:  # what is not there is called by kernels only
            return kernels.get(f"{function.__module__}.{function.__name__}", function)
        try:
            import numba
        except ImportError:
            words = "there is no machine code of these sources for this system, and numba is not installed"
            hint = "pip install numba; or, where sources were changed, pip install that folder again"
            raise MissionError(words, hint=hint, code="package-missing", place=PACKAGE) from None
        try:
            kernel = numba.njit(**options)(function)
        except RuntimeError:  # nowhere to keep it
            return numba.njit(**options | {"cache": False})(function)
        if options.get("cache"):  # numba itself would look at the time of one file, and not of those that it imports
            kernel._cache._cache_file._source_stamp = _digest()
        return kernel

    return decorated


_digest = lru_cache(maxsize=1)(sources_digest)


def jit_if_faster(function: Function, fast: bool | None, steps: float) -> Function:
    """A plain function itself, or compiled if `fast`; None takes whichever is sooner ready with so many steps.

    Both speeds say the same, bit for bit, so the choice is one of time only.
    """
    if fast is None:
        at_hand = shipped() is not None or compiled.cache_info().currsize > 0
        fast = at_hand or (steps > MANY_STEPS and _was_kept(function))
    return compiled(function) if fast else function


@lru_cache(maxsize=8)
def compiled(function: Any) -> Any:
    """A plain function as machine code, with all functions of its package that it calls."""
    options = {"error_model": "numpy", "no_cfunc_wrapper": True}
    kernel = njit(cache=True, **options)(function)
    if shipped() is None:
        from numba.extending import register_jitable

        for called in called_by(function):
            register_jitable(forceinline=True, **options)(called)
    return kernel


def called_by(function: Any) -> set[FunctionType]:
    """The functions of its package that a function calls, and those that they call."""
    package, found, todo = function.__module__.rpartition(".")[0], set[FunctionType](), [function]
    while todo:
        caller = todo.pop()
        named = {caller.__globals__.get(name) for name in caller.__code__.co_names}
        new = {one for one in named if isinstance(one, FunctionType) and one.__module__.startswith(package)} - found
        found |= new
        todo += new
    return found


def _was_kept(function: Any) -> bool:
    """Whether numba has once kept the compiled function beside its source."""
    source = Path(sys.modules[function.__module__].__file__ or "")
    return any((source.parent / "__pycache__").glob(f"{source.stem}.{function.__name__}-*.nbi"))
