"""Find the shipped machine code for this CPU and these sources.

A clone may shadow an installed package, whose machine code is used if its digest of the sources matches.
"""

import ctypes
import hashlib
import json
import os
import platform
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from ipoa_mission.compiled.native import Native
from ipoa_mission.files import copies

PACKAGE = Path(__file__).parent.parent
SOURCES = (
    "compiled/__init__.py",
    "compiled/native.py",
    "autopilot/commands.py",
    "vehicles/*/dynamics/*.py",
    "vehicles/*/parameter_table.py",
    "vehicles/*/limits.py",
    "autopilot/parameters.py",
    "geometry.py",
    "planning/_*.py",
    "survey/_*.py",
    "survey/times.py",
    "planning/banded.py",
    "planning/obstacle_grid.py",
    "routing/_*.py",
    "world/_*.py",
    "world/obstacles/_*.py",
    "world/obstacles/obstacle.py",
)
INDEX = "kernels.json"
#: Best first, with numpy's names of instruction sets.
CPUS: dict[str, dict[str, tuple[str, ...]]] = {
    "x86_64": {"x86-64-v4": ("X86_V4", "AVX512_SKX"), "x86-64-v3": ("X86_V3", "AVX2"), "x86-64": ("SSE2",)},
    "aarch64": {"generic": ("NEON",)},
}
NUMBA = "IPOA_MISSION_NUMBA"  # any value: always compile with numba


@lru_cache(maxsize=1)
def shipped() -> dict[str, Callable[..., Any]] | None:
    """Return the kernels by module and name, if any for this system and these sources."""
    if os.environ.get(NUMBA):
        return None
    here = PACKAGE / "compiled"
    return next((kernels for folder in (here, *copies("compiled")) if (kernels := load(folder)) is not None), None)


def load(folder: Path) -> dict[str, Callable[..., Any]] | None:
    try:
        index = json.loads((folder / INDEX).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    made: dict[str, str] | None = index.get("libraries")
    files = [file for cpu in these_cpus() if (file := folder / file_name(cpu)).is_file()]
    files = [file for file in files if made is None or made.get(file.name) == digest_of(file)]
    if index["sources"] != sources_digest() or not files:
        return None
    try:
        library = ctypes.CDLL(str(files[0]))
        return {name: Native(library, name, *types) for name, types in index["kernels"].items()}
    except (OSError, AttributeError):  # another system, or no exported symbols
        return None


def digest_of(library: Path) -> str:
    return hashlib.sha256(library.read_bytes()).hexdigest()


def file_name(cpu: str) -> str:
    """Avoid the suffix of a Python module."""
    return f"kernels-{platform.system()}-{cpu}.bin"


def sources_digest() -> str:
    digest = hashlib.sha256()
    for path in sorted(path for pattern in SOURCES for path in PACKAGE.glob(pattern)):
        digest.update(path.relative_to(PACKAGE).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def these_cpus() -> list[str]:
    from numpy._core._multiarray_umath import __cpu_features__ as has

    machine = platform.machine()
    cpus = CPUS.get({"AMD64": "x86_64", "arm64": "aarch64"}.get(machine, machine), {})
    return [cpu for cpu, names in cpus.items() if any(has.get(name) for name in names)]
