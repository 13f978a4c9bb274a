from dataclasses import dataclass
from enum import StrEnum

from ipoa_mission.errors import Remedy


class Severity(StrEnum):
    """An error keeps a mission on the ground; a warning informs."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """A finding of reading or checking.

    Attributes:
        code: the rule; docs/findings.md lists all.
        severity: error or warning.
        seq: item number as in mission files (home is 0), if any.
        message: the fault, with place and expected value.
        hint: the remedy, if known.
        remedies: changes of the scenario that may correct it.

    Example:
        >>> print(Finding("ends-in-the-air", Severity.WARNING, 2, "item 2: the mission ends in the air"))
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
