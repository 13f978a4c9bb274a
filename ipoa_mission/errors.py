"""Errors that a user can correct."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from typing import Any, Self


@dataclass(frozen=True)
class Remedy:
    """A change of the scenario that may correct an error; value None: remove the field."""

    field: tuple[str | int, ...]
    value: Any = None

    def __str__(self) -> str:
        """Return it in a scenario's notation: `vehicle.cruise_speed = 3`."""
        value = f"{self.value:g}" if isinstance(self.value, float) else json.dumps(self.value)
        return f"{'.'.join(map(str, self.field))} = {value}"


class MissionError(Exception):
    """The job could not be done (exit code 1).

    Attributes:
        code: by default of the class.
        place: in a file, the scenario or the options; begins the message.
        hint: advice to the user.
        remedies: changes of the scenario.
        known: data for machines.
    """

    exit_code = 1
    code = "mission-error"

    def __init_subclass__(cls, code: str = "") -> None:
        cls.code = code or cls.code

    def __init__(
        self,
        message: str,
        hint: str | None = None,
        *,
        code: str | None = None,
        place: object = None,
        remedies: tuple[Remedy, ...] = (),
        known: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(message)
        self.code = code or self.code
        self.place = None if place is None else str(place)
        self.hint = hint
        self.remedies = remedies
        self.known: dict[str, object] = dict(known or {})

    def __str__(self) -> str:
        return super().__str__() if self.place is None else f"{self.place}: {self.args[0]}"

    def at(self, place: object = None, hint: str | None = None) -> Self:
        """Return the error with an outer place before its own."""
        other = self._copied()
        other.place = ": ".join(str(part) for part in (place, self.place) if part is not None) or None
        other.hint = hint or self.hint
        return other

    def _copied(self) -> Self:
        other = type(self).__new__(type(self), *self.args)
        vars(other).update(vars(self))
        return other

    def followed_by(self, *lines: str) -> Self:
        other = self._copied()
        other.args = ("\n".join([self.args[0], *lines]),)
        return other

    def as_json(self) -> dict[str, object]:
        changes = [{"field": list(remedy.field), "value": remedy.value} for remedy in self.remedies]
        about = {"error": str(self), "code": self.code, "place": self.place, "hint": self.hint, "remedies": changes}
        return about | {"exit_code": self.exit_code} | self.known


class BadInput(MissionError, code="bad-input"):
    """The user's input is wrong (exit code 2)."""

    exit_code = 2


class DamagedFile(BadInput, code="damaged-file"):
    """A file of the right format is incomplete."""


class EndlessFlight(BadInput, code="endless-flight"): ...


class InvalidRing(BadInput, code="invalid-ring"): ...


class NoCoordinateSystem(BadInput, code="no-coordinate-system"): ...


class NotCovered(BadInput, code="not-covered"): ...


class NothingThere(BadInput, code="nothing-there"):
    """A file has none of the expected content."""


class OptionConflict(BadInput, code="option-conflict"):
    """An option needs another one, or excludes it."""


class TooFar(BadInput, code="too-far"): ...


class TooLarge(BadInput, code="too-large"): ...


class UnknownName(BadInput, code="unknown-name"): ...


class Unreadable(BadInput, code="unreadable"): ...


class Unwritable(BadInput, code="unwritable"): ...


class WrongFormat(BadInput, code="wrong-format"): ...


class WrongSuffix(BadInput, code="wrong-suffix"): ...


class LogUseless(MissionError, code="log-useless"): ...


class NotModeled(MissionError, code="not-modeled"): ...


class Unsafe(MissionError, code="unsafe"):
    """The checks found errors; the message has one line for each."""


def imported(module: str, needed: str, extra: str, wrong: type[MissionError] = MissionError) -> Any:
    """Import a library of an extra, or raise `wrong` with the message `needed`."""
    try:
        return import_module(module)
    except ImportError as error:
        raise wrong(needed, hint=f"pip install 'ipoa-mission[{extra}]'", code="package-missing") from error


def hint_of(name: str, known: Iterable[str], sureness: float = 0.6) -> str | None:
    """Ask for the most similar name."""
    originals = {each.casefold(): each for each in known}
    near = get_close_matches(name.casefold(), sorted(originals), n=1, cutoff=sureness)
    return f"did you mean {originals[near[0]]}?" if near else None
