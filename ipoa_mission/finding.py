"""Findings of reading or checking a mission."""

from dataclasses import dataclass
from enum import StrEnum

from ipoa_mission.errors import Remedy


class Severity(StrEnum):
    """An error keeps a mission on the ground; a warning informs before the flight."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """One finding of a check.

    Attributes:
        code: the rule, the same in each version; docs/findings.md lists all.
        severity: an error or a warning.
        seq: the item's number as in mission files (home is 0); None without an item.
        message: the fault, with its place and the expected value.
        hint: the remedy, if known.
        remedies: changes of the scenario that may correct it.

    Example:
        >>> print(Finding("ends-in-air", Severity.WARNING, 2, "item 2: the mission ends in the air"))
        warning: item 2: the mission ends in the air
    """

    code: str
    severity: Severity
    seq: int | None
    message: str
    hint: str | None = None
    remedies: tuple[Remedy, ...] = ()

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}"
