from typing import NamedTuple

from ipoa_mission.autopilot.commands import command_name
from ipoa_mission.errors import Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.itinerary.flown_legs import Leg, Phase
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


def leg_name(leg: Leg) -> str:
    """Return the name of a leg; after a jump with its begin."""
    names = {Phase.CRUISE: "the leg to it", Phase.RETURN: "the way home", Phase.TAKEOFF: "the climb"}
    name = names.get(leg.phase, "the descent")
    if leg.jumped_from < 0:
        return name
    return f"{name} from {f'item {leg.jumped_from}' if leg.jumped_from else 'home'}, after a jump"
