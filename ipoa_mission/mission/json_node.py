"""A JSON document whose values know their place."""

import json
import math
import re
import sys
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from ipoa_mission.errors import BadInput, WrongFormat
from ipoa_mission.files import reading
from ipoa_mission.finding import Finding, Severity


@dataclass(frozen=True)
class Node:
    """One value of a document; `place` is like `mission.items[3].params`, empty for the whole.

    Shared by all: `findings`, faults that did not stop the reading, and `asked`, the keys asked for by place.
    """

    file: str
    place: str
    value: Any
    findings: list[Finding] = field(default_factory=list, compare=False)
    asked: dict[str, tuple[dict[str, Any], set[str]]] = field(default_factory=dict, compare=False)

    @property
    def where(self) -> str:
        return f"{self.file}: {self.place}" if self.place else self.file

    def wrong(self, expected: str, hint: str | None = None) -> BadInput:
        return BadInput(f"expected {expected}, not {_describe(self.value)}", hint, place=self.where)

    def note(self, message: str, severity: Severity = Severity.WARNING) -> None:
        self.findings.append(Finding("file", severity, None, f"{self.place}: {message}" if self.place else message))

    def __getitem__(self, key: str) -> "Node":
        child = self.get(key)
        if child is None:
            raise BadInput(f'expected "{key}", but there is none', code="missing", place=self.where)
        return child

    def get(self, key: str) -> "Node | None":
        if not isinstance(self.value, dict):
            raise self.wrong("an object")
        self.asked.setdefault(self.place, (self.value, set()))[1].add(key)
        place = f"{self.place}.{key}" if self.place else key
        return replace(self, place=place, value=self.value[key]) if key in self.value else None

    def given(self, key: str) -> "Node | None":
        """Return the value of a key; None also for null."""
        child = self.get(key)
        return None if child is None or child.value is None else child

    def usual(self, key: str, otherwise: str) -> "Node | None":
        """Return the value of a key that QGroundControl always writes; note the assumption if the key is missing."""
        child = self.get(key)
        if child is None:
            replace(self, place=f"{self.place}.{key}".lstrip(".")).note(f"missing: {otherwise}")
        return child

    def array(self, length: int | None = None, of: str = "values") -> list["Node"]:
        if not isinstance(self.value, list):
            raise self.wrong("a list" if length is None else f"{length} {of}")
        if length is not None and len(self.value) != length:
            raise BadInput(f"expected {length} {of}, not {len(self.value)}", place=self.where)
        return [replace(self, place=f"{self.place}[{i}]", value=value) for i, value in enumerate(self.value)]

    def number(self, expected: str = "a number", most: float = sys.float_info.max) -> float:
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or not abs(self.value) <= most:
            raise self.wrong(expected)
        return float(self.value)

    def degrees(self, limit: int = 180) -> float:
        """`check` reports a latitude beyond 90."""
        return self.number(f"degrees from -{limit} to {limit}", limit)

    def whole(self, expected: str = "", least: int = 0, most: int = 65535) -> int:
        expected = expected or f"a whole number from {least} to {most}"
        value = self.number(expected)
        if not (value.is_integer() and least <= value <= most):
            raise self.wrong(expected)
        return int(value)

    def flag(self) -> bool:
        if not isinstance(self.value, bool):
            raise self.wrong("true or false")
        return self.value

    def text(self, expected: str = "a text") -> str:
        if not isinstance(self.value, str):
            raise self.wrong(expected)
        return self.value


def parse_document(path: Path, text: str) -> Node:
    reject_constant = partial(_reject_constant, path, text)
    with reading(path, text):
        document = json.loads(text, parse_constant=reject_constant, object_pairs_hook=partial(_unique, path))
    return Node(str(path), "", document)


def _unique(path: Path, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) < len(pairs):
        keys = [key for key, _ in pairs]
        duplicate = next(key for key in keys if keys.count(key) > 1)
        raise WrongFormat(f'expected each key of an object once, not "{duplicate}" twice', place=path)
    return values


def _reject_constant(path: Path, text: str, name: str) -> NoReturn:
    match = re.search(rf"^.*[\s:,\[]{re.escape(name)}\b", text, re.MULTILINE)
    line = text.count("\n", 0, match.end()) + 1 if match else 1
    words = f"expected JSON, which has no {name}"
    raise WrongFormat(words, hint='write null for "not a number"', place=f"{path}: line {line}")


def _describe(value: Any) -> str:
    match value:
        case dict():
            return "an object"
        case list():
            return f"a list of {len(value)}"
        case str() if len(value) > 40:
            return f'"{value[:37]}..."'
        case _:
            words = json.dumps(value, ensure_ascii=False)
            return words if len(words) <= 40 else f"a number of {len(words)} digits"


def tidy(value: float) -> float | int | None:
    """As QGroundControl: whole numbers without a point, NaN as null."""
    if math.isnan(value):
        return None
    return int(value) if abs(value) < 1e15 and value == int(value) else value


def finite(place: str, *values: float) -> list[float | int | None]:
    """Return tidy numbers; raise BadInput."""
    for value in values:
        if not math.isfinite(value):
            raise BadInput(f"expected a finite number, not {value}", place=place)
    return list(map(tidy, values))
