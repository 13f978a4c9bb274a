"""The step-by-step modules a second time, compiled by numba: one source, two speeds.

Compiling takes seconds, once on a machine (numba keeps the result beside the source); after that a mission takes
milliseconds. Both say the same, so the choice is one of time only.
"""

import importlib
import importlib.util
import sys
from functools import lru_cache
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent


def stepping(name: str, fast: bool | None, steps: float) -> ModuleType:
    """The module `name`: compiled if `fast`, plain if not; None takes whichever is sooner ready with so many steps.

    Plain code does some thirty steps a millisecond; to load numba and what it has kept takes a second.
    """
    loaded = f"{__package__}.{name}_compiled" in sys.modules
    if fast is None:
        fast = loaded or (steps > 50_000 and _is_kept(name))
    return compiled(name) if fast else importlib.import_module(f"{__package__}.{name}")


def _is_kept(name: str) -> bool:
    """Whether numba has kept the compiled module beside its source, and the source has not changed since."""
    written = (HERE / f"{name}.py").stat().st_mtime
    return any(index.stat().st_mtime > written for index in (HERE / "__pycache__").glob(f"{name}.fly_*.nbi"))


@lru_cache(maxsize=4)
def compiled(name: str) -> ModuleType:
    """The module `name` of this room, its `@jit` functions compiled."""
    import numba

    full = f"{__package__}.{name}_compiled"
    spec = importlib.util.spec_from_file_location(full, HERE / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.jit = numba.njit(cache=True)  # type: ignore[attr-defined]
    sys.modules[full] = module  # numba's cache looks functions up by the name of their module
    spec.loader.exec_module(module)
    return module
