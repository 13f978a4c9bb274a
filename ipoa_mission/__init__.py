"""Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, and know how long it will fly.

    from ipoa_mission import plan_flight, read_scenario

    flight = plan_flight(read_scenario("missions/campus.toml"), seed=7)
    flight.write("out")
    print(flight.estimate.total_s)

Names are imported when they are first used, so that `import ipoa_mission` costs nothing. docs/api.md shows them all.
In a notebook, `%load_ext ipoa_mission` lets missions, plans, estimates and flights be seen as tables.
"""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_WHERE = {name: module for module, name in re.findall(r"^from (ipoa_mission\S*) import (\w+)", _STUB, re.MULTILINE)}

__all__ = sorted(_WHERE)


def __getattr__(name: str) -> object:
    if name == "__version__":
        return import_module("importlib.metadata").version("ipoa-mission")
    if name in _WHERE:
        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'ipoa_mission' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__


def load_ipython_extension(shell: Any) -> None:
    """What `%load_ext ipoa_mission` calls."""
    from ipoa_mission.report.notebook import show_in

    show_in(shell)
