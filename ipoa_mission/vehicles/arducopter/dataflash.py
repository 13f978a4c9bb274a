"""Reader of ArduPilot's log (`.bin`) by the layouts of its FMT records.

pymavlink's reader takes a second per megabyte, and hours for a file of zeros.
"""

import struct
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ipoa_mission.errors import Unreadable, WrongFormat

HEAD = b"\xa3\x95"
FMT = 0x80
BYTES = "bytes"
_FMT = struct.Struct("<BB4s16s64s")


def _words(raw: bytes) -> str:
    return raw.split(b"\0")[0].decode("utf-8", "replace")


def _centi(value: float) -> float:
    return value / 100


#: By format letter: struct's code and the conversion.
_UNCHANGED: Callable[[Any], Any] = lambda value: value  # noqa: E731
_LETTERS: Mapping[str, tuple[str, Callable[[Any], Any]]] = {
    **{letter: (letter, _UNCHANGED) for letter in "bBhHiIfd"},
    "q": ("q", _UNCHANGED),
    "Q": ("Q", _UNCHANGED),
    "g": ("e", _UNCHANGED),
    "M": ("B", _UNCHANGED),
    "a": ("64s", _UNCHANGED),
    "n": ("4s", _words),
    "N": ("16s", _words),
    "Z": ("64s", _words),
    "c": ("h", _centi),
    "C": ("H", _centi),
    "e": ("i", _centi),
    "E": ("I", _centi),
    "L": ("i", lambda value: value / 1e7),
}


@dataclass(frozen=True)
class RecordKind:
    """A record kind: name, struct layout, columns and their conversions."""

    name: str
    layout: struct.Struct
    columns: tuple[str, ...]
    made_by: tuple[Callable[[Any], Any], ...]

    def read(self, data: bytes, at: int) -> dict[str, Any]:
        """In degrees, meters and unscaled units."""
        values = self.layout.unpack_from(data, at)
        return {name: make(value) for name, make, value in zip(self.columns, self.made_by, values, strict=True)}


def read_records(
    path: Path, wanted: frozenset[str], torn: Counter[str] | None = None
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Read the wanted kinds of records in order, as (kind, values by column).

    Damaged bytes are skipped; `torn` counts them, by kind or in bytes.

    Raises:
        BadInput: the file cannot be read, or is no log.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise Unreadable(f"cannot be read as an ArduPilot log: {error.strerror}", place=path) from error
    if not data.startswith(HEAD + bytes((FMT,))):
        raise WrongFormat("expected an ArduPilot log, but it does not start like one", place=path)
    lengths: dict[int, int] = {FMT: 3 + _FMT.size}
    kinds: dict[int, RecordKind] = {}
    torn = Counter() if torn is None else torn
    at = ends = 0
    while (at := data.find(HEAD, at)) >= 0 and at + 3 <= len(data):
        number = data[at + 2]
        length = lengths.get(number)
        if length is None or at + length > len(data):
            at += 1
            continue
        torn[BYTES] += at - ends
        ends = at + length
        if number == FMT:
            described, size, *texts = _FMT.unpack_from(data, at + 3)
            name, letters, columns = map(_words, texts)
            kind = _kind(name, letters, columns)
            if size >= 3 and described != FMT:
                lengths[described] = size
                kinds.pop(described, None)
                if kind is not None and name in wanted and kind.layout.size == size - 3:
                    kinds[described] = kind
                elif name in wanted:
                    torn[name] += 1
        elif number in kinds:
            yield kinds[number].name, kinds[number].read(data, at + 3)
        at += length
    torn[BYTES] += len(data) - ends


def _kind(name: str, letters: str, columns: str) -> RecordKind | None:
    names = tuple(columns.split(","))
    if len(names) != len(letters) or not set(letters) <= set(_LETTERS):
        return None
    made = [_LETTERS[letter] for letter in letters]
    return RecordKind(
        name, struct.Struct("<" + "".join(code for code, _ in made)), names, tuple(make for _, make in made)
    )
