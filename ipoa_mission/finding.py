"""What reading or checking a mission has to say about it."""

from dataclasses import dataclass
from enum import StrEnum

from ipoa_mission.errors import Remedy


class Severity(StrEnum):
    """An error keeps a mission on the ground; a warning is worth knowing before it flies."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """One thing that a check found.

    Attributes:
        code: which rule found it, by the same word in every version: docs/findings.md has them all.
        severity: an error or a warning.
        seq: the item's number as in mission files (home is 0); None where no item is meant.
        message: what is wrong, with the place and what was expected there.
        hint: what can be done about it, where that is known.
        remedies: changes of the scenario that may mend it.

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
