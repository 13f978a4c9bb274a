from typing import NamedTuple

from ipoa_mission.autopilot.commands import command_name
from ipoa_mission.errors import Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.items import Item, Mission


class Numbered(NamedTuple):
    seq: int
    item: Item

    def __str__(self) -> str:
        return f"item {self.seq} ({command_name(self.item.command)})"

    def error(self, code: str, message: str, hint: str | None = None, remedies: tuple[Remedy, ...] = ()) -> Finding:
        return Finding(code, Severity.ERROR, self.seq, f"{self}: {message}", hint, remedies)

    def warning(self, code: str, message: str, hint: str | None = None) -> Finding:
        return Finding(code, Severity.WARNING, self.seq, f"{self}: {message}", hint)


def numbered_items(mission: Mission) -> list[Numbered]:
    return [Numbered(seq, item) for seq, item in enumerate(mission.items, start=1)]


def item_of(mission: Mission, seq: int) -> Numbered:
    return Numbered(seq, mission.items[seq - 1])
