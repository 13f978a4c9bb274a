"""Kernels as machine code: shipped, or by numba at first use.

A kernel is a function decorated with `njit`, or passed to `compiled` if it also runs as plain Python. Shipped code
(`tools/machine_code`) loads in 1 ms; numba compiles if `library.SOURCES`, system or CPU differ.
"""

from collections.abc import Callable
from functools import cache, lru_cache
from operator import attrgetter
from types import FunctionType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

from ipoa_mission.compiled.library import PACKAGE, shipped, sources_digest
from ipoa_mission.errors import MissionError

_PLAIN = {float: np.float64, complex: np.complex128, int: np.int64, bool: np.bool_}


def njit(**options: Any) -> Any:
    """Decorate a kernel like `numba.njit`, with shipped machine code if available."""

    def decorated(function: Callable[..., Any]) -> Any:
        kernels = shipped()
        if kernels is not None:  # others are only called by kernels
            return kernels.get(f"{function.__module__}.{function.__name__}", function)
        try:
            import numba
        except ImportError:
            words = "expected machine code for these sources and this system, or numba"
            hint = "pip install numba; or, where sources were changed, pip install that folder again"
            raise MissionError(words, hint=hint, code="package-missing", place=PACKAGE) from None
        try:
            kernel = numba.njit(**options)(function)
        except RuntimeError:  # no writable cache folder
            return numba.njit(**options | {"cache": False})(function)
        if options.get("cache"):  # numba would check the time of one file, without its imports
            index = kernel._cache._cache_file
            # numba unpickles only its own version's index; other sources may have other module names
            index._version = f"{numba.__version__} {_digest()}"
            index._source_stamp = _digest()
        return kernel

    return decorated


_digest = lru_cache(maxsize=1)(sources_digest)


@lru_cache(maxsize=8)
def compiled(function: Any) -> Any:
    """Compile a function and those of its package that it calls; results are bit-equal."""
    options = {"error_model": "numpy", "no_cfunc_wrapper": True}
    kernel = njit(cache=True, **options)(function)
    if shipped() is None:
        from numba.extending import register_jitable

        for called in called_by(function):
            register_jitable(forceinline=True, **options)(called)
    return kernel


def called_by(function: Any) -> set[FunctionType]:
    """Return all functions of its distribution that a function calls."""
    package = function.__module__.partition(".")[0]
    found = set[FunctionType]()
    todo = [function]
    while todo:
        caller = todo.pop()
        named = {caller.__globals__.get(name) for name in caller.__code__.co_names}
        new = {one for one in named if isinstance(one, FunctionType) and one.__module__.startswith(package)} - found
        found |= new
        todo += new
    return found


@cache
def record_type(kind: type) -> np.dtype[np.void]:
    """Return a class's record type; `Annotated[list[X], n]` has length n."""
    return np.dtype([(name, *_field(hint)) for name, hint in get_type_hints(kind, include_extras=True).items()])


def _field(hint: Any) -> tuple[Any, ...]:
    if get_origin(hint) is Annotated:
        inner, note = get_args(hint)
        return _field(inner) if isinstance(note, str) else (*_field(*get_args(inner)), (note,))
    return (_PLAIN.get(hint) or record_type(hint),)


def records(values: Any, kind: type) -> Any:
    """Return named tuples, or objects with plain fields, as numpy records for compiled code."""
    made = record_type(kind)
    rows = list(values) if issubclass(kind, tuple) else list(map(attrgetter(*made.names or ()), values))
    return np.array(rows, made)
