"""The step-by-step modules a second time, compiled by numba: one source, two speeds.

Compiling takes seconds, once on a machine (numba keeps the result beside the source); after that a mission takes
milliseconds. `estimate` runs the plain twin unless it is told that it will be called often.
"""

import importlib.util
import sys
from functools import lru_cache
from pathlib import Path
from types import ModuleType


@lru_cache(maxsize=4)
def compiled(name: str) -> ModuleType:
    """The module `name` of this room, its `@jit` functions compiled."""
    import numba

    full = f"{__package__}.{name}_compiled"
    spec = importlib.util.spec_from_file_location(full, Path(__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.jit = numba.njit(cache=True)  # type: ignore[attr-defined]
    sys.modules[full] = module  # numba's cache looks functions up by the name of their module
    spec.loader.exec_module(module)
    return module
