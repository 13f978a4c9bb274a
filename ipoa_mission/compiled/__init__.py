"""Kernels as machine code: compiled when the package was built, or else by numba when they are first needed.

A kernel is one Python function, decorated with `njit`. A wheel carries its machine code, which `tools/machine_code`
makes: it loads in a millisecond and needs neither numba nor a writable folder. Where the sources, the system or the
CPU differ from those that it was made for, numba compiles, as it does in a checkout.
"""

from collections.abc import Callable
from typing import Any

from ipoa_mission.compiled.library import PACKAGE, shipped
from ipoa_mission.errors import MissionError


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
            raise MissionError(
                f"{PACKAGE}: there is no machine code of these sources for this system, and numba is not installed",
                hint="pip install numba; or, where sources were changed, pip install that folder again",
            ) from None
        try:
            return numba.njit(**options)(function)
        except RuntimeError:  # nowhere to keep it
            return numba.njit(**options | {"cache": False})(function)

    return decorated
