"""Find the shipped machine code for this CPU and these sources, and call it without numba.

A clone also finds that of an installed package of the same sources.

Numba's calling convention: a tuple is packed as its parts; an array as two unused words, size, item size, address,
shape and strides. The result is written to the first argument in the same layout.

Types: "float", "int", "bool", an array's element type and dimensions ("<f8 2"; "|V16 1" for records), or lists for
tuples.
"""

import ctypes
import hashlib
import json
import os
import platform
import struct
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.files import copies

Type = str | Sequence["Type"]
RETURNED = 0
RETURNED_NONE = -2  # numba's status codes
CACHED_TUPLES = 4  # cached per argument

_NUMBERS = {"float": "d", "int": "q", "bool": "q"}  # of `struct`
PACKAGE = Path(__file__).parent.parent
SOURCES = (
    "compiled/__init__.py",
    "compiled/library.py",
    "autopilot/commands.py",
    "vehicles/*/dynamics/*.py",
    "vehicles/*/limits.py",
    "vehicles/*/braking.py",
    "autopilot/parameters.py",
    "geometry.py",
    "wind.py",
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


class Native:
    """A kernel, called like its Python function."""

    def __init__(self, library: ctypes.CDLL, name: str, arguments: Sequence[Type], result: Type | None) -> None:
        self._call = library[name]
        self._name = name
        self._call.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
        self._call.restype = ctypes.c_int32
        self._arguments = [_packer(kind) if isinstance(kind, str) else _CachedPacker(kind) for kind in arguments]
        release = library["release"]
        release.argtypes = [ctypes.c_void_p]
        release.restype = None
        self._returned = struct.Struct("@" + _struct(result or []))
        self._result = None if result is None else _unpacker(result, release)
        self._room = ctypes.c_char * (8 * words(result or []) + 8)  # last: numba's error information

    def __call__(self, *values: Any) -> Any:
        """Return new arrays. Raise TypeError for an array of another type, RuntimeError where the kernel fails."""
        room = self._room()
        given = b"".join([packed(value) for packed, value in zip(self._arguments, values, strict=True)])
        status = self._call(room, given)
        if status not in {RETURNED, RETURNED_NONE}:
            raise RuntimeError(f"{self._name} ended with status {status}")
        return None if self._result is None else self._result(iter(self._returned.unpack_from(room)))


class _CachedPacker:
    """Cache the words of named tuples, which are immutable."""

    def __init__(self, kind: Sequence[Type]) -> None:
        self._packed = _packer(kind)
        self._kept: dict[int, tuple[Any, bytes]] = {}

    def __call__(self, value: Any) -> bytes:
        kept = self._kept.get(id(value))
        if kept is not None:
            return kept[1]
        words = self._packed(value)
        if hasattr(value, "_fields"):
            if len(self._kept) >= CACHED_TUPLES:
                self._kept.clear()
            self._kept[id(value)] = value, words
        return words


def _packer(kind: Type) -> Callable[[Any], bytes]:
    if not isinstance(kind, str):
        if all(one == "float" for one in kind):  # most records: three times as quick
            numbers = struct.Struct(f"={len(kind)}d").pack
            return lambda value: numbers(*value)
        parts = [_packer(one) for one in kind]
        return lambda value: b"".join([packed(part) for packed, part in zip(parts, value, strict=True)])
    if kind in _NUMBERS:
        number = struct.Struct("=" + _NUMBERS[kind]).pack
        return number if kind == "float" else lambda value: number(int(value))
    dtype, dimensions = _array(kind)
    row = struct.Struct("=" + _layout(kind)).pack
    item = dtype.itemsize

    def packed(value: Any) -> bytes:
        there, shape = value.dtype, value.shape
        if there is not dtype and (there.itemsize != item or (there.names is None and there != dtype)):
            raise TypeError(f"expected an array of {kind}, not {there.str} {value.ndim}")
        if len(shape) != dimensions or not value.flags.c_contiguous:
            raise TypeError(f"expected a contiguous array of {kind}, not {there.str} {value.ndim}")
        return row(0, 0, value.size, item, _address(value), *shape, *value.strides)

    return packed


def _unpacker(kind: Type, release: Callable[[int], None]) -> Callable[[Iterator[Any]], Any]:
    if not isinstance(kind, str):
        if all(isinstance(one, str) and one in _NUMBERS for one in kind):
            return lambda words: tuple(islice(words, len(kind)))
        parts = [_unpacker(one, release) for one in kind]
        return lambda words: tuple([unpacked(words) for unpacked in parts])
    if kind in _NUMBERS:
        return next
    dtype, dimensions = _array(kind)

    def unpacked(words: Iterator[Any]) -> Any:
        memory, _, _, _, first, *sides = islice(words, 5 + 2 * dimensions)  # shape and strides
        value = np.empty(sides[:dimensions], dtype)
        ctypes.memmove(_address(value), first, value.nbytes)
        release(memory)
        return value

    return unpacked


def _address(array: Any) -> int:
    if array.dtype.names is None:  # ctypes would write out a record's fields
        try:
            return ctypes.addressof(ctypes.c_char.from_buffer(array))
        except (TypeError, ValueError):  # read-only or empty
            pass
    return int(array.ctypes.data)  # takes twice as long


def _array(kind: str) -> tuple[np.dtype[Any], int]:
    dtype, dimensions = kind.rsplit(" ", 1)
    return np.dtype(dtype), int(dimensions)


def words(kind: Type) -> int:
    return len(_layout(kind))


def _struct(kind: Type) -> str:
    if not isinstance(kind, str):
        return f"0q{''.join(map(_struct, kind))}0q"  # aligned
    return "?" if kind == "bool" else _layout(kind)


def _layout(kind: Type) -> str:
    if not isinstance(kind, str):
        return "".join(map(_layout, kind))
    return _NUMBERS[kind] if kind in _NUMBERS else "q" * (5 + 2 * _array(kind)[1])
