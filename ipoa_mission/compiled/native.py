"""Calling machine code that numba made, without numba: arguments as its calling convention lays them out.

A number is handed on as itself, a tuple as its parts, an array as seven things: two that are of no concern here, its
size, the size of an element, the address of the first, its shape and its strides. What is returned is written where the
first argument says, in the same layout.

Types are strings, or lists of types for tuples: "float", "int", "bool", or an array's element and dimensions: "<f8 2",
of records "|V16 1".
"""

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

Type = str | Sequence["Type"]
RETURNED, RETURNED_NONE = 0, -2  # numba's status codes
PACKED = 16  # named tuples whose numbers are kept, for the next call

_NUMBERS = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_uint8}


class Native:
    """A kernel of a library, called as the Python function of which it is made."""

    def __init__(self, library: ctypes.CDLL, name: str, arguments: Sequence[Type], result: Type | None) -> None:
        self._call, self._release = library[name], library["release"]
        self._name, self._arguments, self._result = name, arguments, result
        self._words = _words(result) if result is not None else 0
        self._call.argtypes = [ctypes.c_void_p, ctypes.c_void_p, *_c_types(arguments)]
        self._call.restype = ctypes.c_int32
        self._release.argtypes = [ctypes.c_void_p]
        self._release.restype = None
        self._kept: dict[tuple[int, int], tuple[Any, list[Any]]] = {}

    def __call__(self, *values: Any) -> Any:
        """What the Python function would return; arrays are new ones.

        Raises:
            TypeError: an array is not of the type for which this was compiled.
            RuntimeError: the kernel gave up, as on an index out of range.
        """
        room = np.empty(self._words + 1, np.int64)  # the last for what numba says of an error
        first = _address(room)
        packed: list[Any] = []
        for k, (kind, value) in enumerate(zip(self._arguments, values, strict=True)):
            packed += self._packed(k, kind, value)
        status = self._call(first, first + 8 * self._words, *packed)
        if status not in {RETURNED, RETURNED_NONE}:
            raise RuntimeError(f"{self._name} ended with status {status}")
        return None if self._result is None else self._unpacked(self._result, room)[0]

    def _packed(self, k: int, kind: Type, value: Any) -> list[Any]:
        """A value as numbers; those of named tuples, which do not change, are kept."""
        if not hasattr(value, "_fields"):
            return _pack(kind, value)
        key = (k, id(value))
        kept = self._kept.get(key)
        if kept is None:
            if len(self._kept) >= PACKED:
                self._kept.clear()
            kept = self._kept[key] = value, _pack(kind, value)
        return kept[1]

    def _unpacked(self, kind: Type, words: Any) -> tuple[Any, Any]:
        """A returned value, and the words after it."""
        if kind == "float":
            return float(words[:1].view(np.float64)[0]), words[1:]
        if kind == "int":
            return int(words[0]), words[1:]
        if not isinstance(kind, str):
            parts = []
            for one in kind:
                part, words = self._unpacked(one, words)
                parts.append(part)
            return tuple(parts), words
        dtype, dimensions = _array(kind)
        memory, size, first = int(words[0]), int(words[2]), int(words[4])
        value = np.empty(words[5 : 5 + dimensions], dtype)
        ctypes.memmove(_address(value), first, size * dtype.itemsize)
        self._release(memory)
        return value, words[_words(kind) :]


def _pack(kind: Type, value: Any) -> list[Any]:
    if not isinstance(kind, str):
        return [word for one, part in zip(kind, value, strict=True) for word in _pack(one, part)]
    if kind == "float":
        return [float(value)]
    if kind in _NUMBERS:
        return [int(value)]
    dtype, dimensions = _array(kind)
    there = value.dtype
    if there is not dtype and (there.itemsize != dtype.itemsize or (there.names is None and there != dtype)):
        raise TypeError(f"expected an array of {kind}, not {there.str} {value.ndim}")
    if value.ndim != dimensions or not value.flags.c_contiguous:
        raise TypeError(f"expected a contiguous array of {kind}, not {there.str} {value.ndim}")
    return [0, 0, value.size, there.itemsize, _address(value), *value.shape, *value.strides]


def _address(array: Any) -> int:
    """Of the first element."""
    return int(array.ctypes.data)


@cache
def _array(kind: str) -> tuple[np.dtype[Any], int]:
    dtype, dimensions = kind.rsplit(" ", 1)
    return np.dtype(dtype), int(dimensions)


def _words(kind: Type) -> int:
    """How many words of eight bytes a value takes."""
    if not isinstance(kind, str):
        return sum(map(_words, kind))
    return 1 if kind in _NUMBERS else 5 + 2 * _array(kind)[1]


def _c_types(kind: Type) -> list[Any]:
    if not isinstance(kind, str):
        return [one for part in kind for one in _c_types(part)]
    if kind in _NUMBERS:
        return [_NUMBERS[kind]]
    dimensions = _array(kind)[1]
    return [ctypes.c_void_p] * 2 + [ctypes.c_int64] * 2 + [ctypes.c_void_p] + [ctypes.c_int64] * 2 * dimensions
