"""What reading or checking a mission has to say about it."""

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """An error keeps a mission on the ground; a warning is worth knowing before it flies."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """One thing found; `seq` is the item's number as in mission files (home is 0), None where no item is meant.

    `code` says which rule found it, by the same word in every version: docs/findings.md has them all. `hint` is what
    can be done about it, where that is known.
    """

    code: str
    severity: Severity
    seq: int | None
    message: str
    hint: str | None = None

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}"
