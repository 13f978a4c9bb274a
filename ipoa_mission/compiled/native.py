"""Calling machine code that numba made, without numba: arguments as its calling convention has them, in a row of words.

A number is handed on as itself, a tuple as its parts, an array as seven things: two that are of no concern here, its
size, the size of an element, the address of the first, its shape and its strides. What is returned is written where the
first argument says, in the same layout.

Types are strings, or lists of types for tuples: "float", "int", "bool", or an array's element and dimensions: "<f8 2",
of records "|V16 1".
"""

import ctypes
import struct
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import islice
from typing import Any

import numpy as np

Type = str | Sequence["Type"]
RETURNED, RETURNED_NONE = 0, -2  # numba's status codes
PACKED = 16  # named tuples whose numbers are kept, for the next call

_NUMBERS = {"float": "d", "int": "q", "bool": "q"}  # as `struct` has them


class Native:
    """A kernel of a library, called as the Python function of which it is made."""

    def __init__(self, library: ctypes.CDLL, name: str, arguments: Sequence[Type], result: Type | None) -> None:
        self._call, self._release = library[name], library["release"]
        self._name, self._arguments, self._result = name, arguments, result
        self._given, self._returned = (
            struct.Struct("=" + _layout(arguments)),
            struct.Struct("=" + _layout(result or [])),
        )
        self._room = ctypes.c_char * (self._returned.size + 8)  # the last word for what numba says of an error
        self._call.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
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
        room, packed = self._room(), list[Any]()
        for k, (kind, value) in enumerate(zip(self._arguments, values, strict=True)):
            packed += self._packed(k, kind, value)
        status = self._call(room, self._given.pack(*packed))
        if status not in {RETURNED, RETURNED_NONE}:
            raise RuntimeError(f"{self._name} ended with status {status}")
        return None if self._result is None else self._unpacked(self._result, iter(self._returned.unpack_from(room)))

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

    def _unpacked(self, kind: Type, words: Iterator[Any]) -> Any:
        """A returned value, from its words on."""
        if not isinstance(kind, str):
            return tuple([self._unpacked(one, words) for one in kind])
        if kind in _NUMBERS:
            return next(words)
        dtype, dimensions = _array(kind)
        memory, _, size, _, first, *shape = islice(words, 5 + dimensions)
        for _ in range(dimensions):  # strides
            next(words)
        value = np.empty(shape, dtype)
        ctypes.memmove(_address(value), first, size * dtype.itemsize)
        self._release(memory)
        return value


def _pack(kind: Type, value: Any) -> list[Any]:
    if not isinstance(kind, str):
        return [word for one, part in zip(kind, value, strict=True) for word in _pack(one, part)]
    if kind in _NUMBERS:
        return [value if kind == "float" else int(value)]
    dtype, dimensions = _array(kind)
    there = value.dtype
    if there is not dtype and (there.itemsize != dtype.itemsize or (there.names is None and there != dtype)):
        raise TypeError(f"expected an array of {kind}, not {there.str} {value.ndim}")
    if value.ndim != dimensions or not value.flags.c_contiguous:
        raise TypeError(f"expected a contiguous array of {kind}, not {there.str} {value.ndim}")
    return [0, 0, value.size, there.itemsize, _address(value), *value.shape, *value.strides]


def _address(array: Any) -> int:
    """Of the first element."""
    try:
        return ctypes.addressof(ctypes.c_char.from_buffer(array))
    except (TypeError, ValueError):  # what may only be read, or is empty; this way takes five times as long
        return int(array.ctypes.data)


@cache
def _array(kind: str) -> tuple[np.dtype[Any], int]:
    dtype, dimensions = kind.rsplit(" ", 1)
    return np.dtype(dtype), int(dimensions)


def words(kind: Type) -> int:
    """How many words of eight bytes a value takes."""
    return len(_layout(kind))


def _layout(kind: Type) -> str:
    """These words, as `struct` has them."""
    if not isinstance(kind, str):
        return "".join(map(_layout, kind))
    return _NUMBERS[kind] if kind in _NUMBERS else "q" * (5 + 2 * _array(kind)[1])
