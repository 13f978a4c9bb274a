"""What a check has to say about a mission."""

from dataclasses import dataclass
from enum import StrEnum

from ipoa_mission.commands import command_name
from ipoa_mission.items import Item


class Severity(StrEnum):
    """An error keeps a mission on the ground; a warning is worth knowing before it flies."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """One thing found; `seq` is the item's number as in mission files (home is 0), None where no item is meant.

    `hint` is what can be done about it, where that is known.
    """

    severity: Severity
    seq: int | None
    message: str
    hint: str | None = None

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}"


def error(seq: int, item: Item, message: str, hint: str | None = None) -> Finding:
    """An error about an item."""
    return Finding(Severity.ERROR, seq, f"item {seq} ({command_name(item.command)}): {message}", hint)


def warning(seq: int, item: Item, message: str) -> Finding:
    """A warning about an item."""
    return Finding(Severity.WARNING, seq, f"item {seq} ({command_name(item.command)}): {message}")
