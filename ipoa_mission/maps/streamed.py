"""Read JSON block by block."""

import codecs
import json
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from ipoa_mission.errors import Unreadable
from ipoa_mission.files import read_text

BLOCK = 1 << 20  # [bytes]
# The end of a feature, in nearly all files.
_BORDER = re.compile(r'\}\s*(?=,\s*\{\s*"type"\s*:\s*"Feature")|"Feature"\s*\}\s*(?=,\s*\{)')
_blank = re.compile(r"[ \t\n\r\x1e]*").match  # RFC 8142: \x1e
_scan = json.JSONDecoder().scan_once  # type: ignore[attr-defined]


def read_document(path: Path, document: dict[str, Any]) -> Iterator[tuple[int, list[Any]]]:
    """Yield batches of `features`, each with the number of its first; `document` gets the other members.

    Raises:
        json.JSONDecodeError: it is not JSON.
        Unstreamed: it is no object, or `features` is no list or is repeated.
    """
    text = _Text(_blocks(path))
    if not text.next_is("{"):
        raise Unstreamed
    yield from _members(text, document)
    if after := text.mark():
        if after == "{":
            raise Unstreamed
        raise text.wrong("Extra data")


def read_values(path: Path) -> Iterator[Any]:
    text = _Text(iter([read_text(path)]) if path.is_fifo() else _blocks(path))
    yield text.value()
    while after := text.mark():
        if after != "{":
            raise text.wrong("Extra data")
        yield text.value()


class Unstreamed(Exception):
    """A document that must be read as a whole."""


class _Text:
    def __init__(self, blocks: Iterator[str]) -> None:
        self._blocks, self._text, self._at, self._line = blocks, "", 0, 1
        self._tried = False  # was the buffered part parsed whole

    def mark(self) -> str:
        while True:
            self._at = _blank(self._text, self._at).end()  # type: ignore[union-attr]
            if self._at < len(self._text) or not self._more():
                return self._text[self._at : self._at + 1]

    def next_is(self, mark: str) -> bool:
        here = self.mark() == mark
        self._at += here
        return here

    def value(self) -> Any:
        self.mark()
        while True:
            try:
                value, end = _scan(self._text, self._at)
                if end < len(self._text) or not self._more():  # a number may continue
                    self._at = end
                    return value
            except StopIteration as error:
                if not self._more():
                    raise self.wrong("Expecting value", error.value) from None
            except json.JSONDecodeError as error:
                if not self._more():
                    raise self.wrong(error.msg, error.pos) from None

    def values(self) -> list[Any]:
        self.mark()
        if not self._tried:
            self._tried = True
            begin = max(self._at, len(self._text) - (1 << 15))
            end = max((border.end() for border in _BORDER.finditer(self._text, begin)), default=self._at)
            with suppress(ValueError, RecursionError):  # `value` reports where
                values: list[Any] = json.loads(f"[{self._text[self._at : end]}]")  # or the begin of a list
                self._at = end
                return values or [self.value()]
        return [self.value()]

    def wrong(self, words: str, at: int | None = None) -> json.JSONDecodeError:
        error = json.JSONDecodeError(words, self._text, self._at if at is None else at)
        error.lineno += self._line - 1
        return error

    def _more(self) -> bool:
        """Read as much again, to limit repeated attempts."""
        pieces, size = [self._text[self._at :]], 0
        for block in self._blocks:
            pieces.append(block)
            size += len(block)
            if size > len(pieces[0]):
                break
        if size:
            self._line += self._text.count("\n", 0, self._at)
            self._text, self._at, self._tried = "".join(pieces), 0, False
        return size > 0


def _members(text: _Text, document: dict[str, Any]) -> Iterator[tuple[int, list[Any]]]:
    if text.next_is("}"):
        return
    while True:
        if text.mark() != '"':
            raise text.wrong("Expecting property name enclosed in double quotes")
        key = text.value()
        if not text.next_is(":"):
            raise text.wrong("Expecting ':' delimiter")
        if key != "features":
            document[key] = text.value()
        elif key in document or not text.next_is("["):
            raise Unstreamed
        else:
            document[key] = None
            yield from _elements(text)
        if text.next_is("}"):
            return
        if not text.next_is(","):
            raise text.wrong("Expecting ',' delimiter")


def _elements(text: _Text) -> Iterator[tuple[int, list[Any]]]:
    if text.next_is("]"):
        return
    number = 0
    while True:
        values = text.values()
        yield number, values
        number += len(values)
        if text.next_is("]"):
            return
        if not text.next_is(","):
            raise text.wrong("Expecting ',' delimiter")


def _blocks(path: Path) -> Iterator[str]:
    decoder = codecs.getincrementaldecoder("utf-8-sig")()
    try:
        with path.open("rb") as file:
            while block := file.read(BLOCK):
                if text := decoder.decode(block):
                    yield text
            decoder.decode(b"", True)
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error
    except UnicodeDecodeError:
        yield read_text(path)[:0]  # names the place
