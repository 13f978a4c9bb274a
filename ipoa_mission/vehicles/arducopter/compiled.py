"""The step-by-step modules a second time, compiled: one source, two speeds.

The machine code is what was shipped, or numba's: that takes seconds, once on a machine (numba keeps the result beside
the source). Both speeds say the same, so the choice is one of time only.
"""

import importlib
import importlib.util
import sys
from functools import lru_cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from ipoa_mission.compiled import njit
from ipoa_mission.compiled.library import shipped


def stepping(plain: ModuleType, fast: bool | None, steps: float) -> Any:
    """The module itself, or compiled if `fast`; None takes whichever is sooner ready with so many steps.

    Plain code does some thirty steps a millisecond; to load numba and what it has kept takes a second.
    """
    if fast is None:
        at_hand = shipped() is not None or f"{plain.__name__}_compiled" in sys.modules
        fast = at_hand or (steps > 50_000 and _is_kept(_source(plain)))
    return compiled(plain) if fast else plain


def _source(module: ModuleType) -> Path:
    assert module.__file__ is not None
    return Path(module.__file__)


def _is_kept(source: Path) -> bool:
    """Whether numba has kept the compiled module beside its source, and the source has not changed since."""
    written = source.stat().st_mtime
    kept = (source.parent / "__pycache__").glob(f"{source.stem}.fly_*.nbi")
    return any(index.stat().st_mtime > written for index in kept)


@lru_cache(maxsize=4)
def compiled(plain: ModuleType) -> Any:
    """The module with its `@jit` functions compiled; of machine code that was shipped, those that Python calls."""
    kernels = shipped()
    if kernels is not None:
        of = f"{plain.__name__}."
        return SimpleNamespace(**{name[len(of) :]: kernel for name, kernel in kernels.items() if name.startswith(of)})
    full = f"{plain.__name__}_compiled"
    spec = importlib.util.spec_from_file_location(full, _source(plain))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.jit = njit(cache=True)  # type: ignore[attr-defined]
    sys.modules[full] = module  # numba's cache looks functions up by the name of their module
    spec.loader.exec_module(module)
    return module
