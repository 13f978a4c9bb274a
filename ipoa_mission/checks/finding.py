"""What a check has to say about an item of a mission."""

from typing import NamedTuple

from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.commands import command_name
from ipoa_mission.mission.items import Item, Mission


class Numbered(NamedTuple):
    """An item and its number, as in mission files."""

    seq: int
    item: Item

    def __str__(self) -> str:
        return f"item {self.seq} ({command_name(self.item.command)})"

    def error(self, code: str, message: str, hint: str | None = None) -> Finding:
        """An error about it."""
        return Finding(code, Severity.ERROR, self.seq, f"{self}: {message}", hint)

    def warning(self, code: str, message: str, hint: str | None = None) -> Finding:
        """A warning about it."""
        return Finding(code, Severity.WARNING, self.seq, f"{self}: {message}", hint)


def numbered(mission: Mission) -> list[Numbered]:
    """The items of a mission, the first one under number 1."""
    return [Numbered(seq, item) for seq, item in enumerate(mission.items, start=1)]


def item_of(mission: Mission, seq: int) -> Numbered:
    """The item with this number."""
    return Numbered(seq, mission.items[seq - 1])
