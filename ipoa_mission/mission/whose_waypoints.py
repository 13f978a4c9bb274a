"""Find the autopilot of a `.waypoints` file, which does not name it."""

import math
from collections.abc import Iterator, Sequence

from ipoa_mission.mission.commands import TAKEOFFS, command_name
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.autopilot import Autopilot, registered


def only_taker(items: Sequence[Item]) -> tuple[Autopilot, str] | None:
    """Find the one autopilot that takes all items, and why no other does; None if none or several do."""
    against = {one: next(_unlike(items, one), None) for one in registered()}
    takers = [one for one, why in against.items() if why is None]
    if len(takers) != 1:
        return None
    return takers[0], next(why for why in against.values() if why is not None)


def _unlike(items: Sequence[Item], autopilot: Autopilot) -> Iterator[str]:
    """Yield differences from a mission for this autopilot."""
    own = autopilot.firmware()
    for seq, item in enumerate(items, start=1):
        at, placed = f"item {seq} ({command_name(item.command)})", item.command in own.placed
        if not own.takes(item.command):
            yield f"{at}: {own.name} does not take it"
        elif placed and item.frame not in own.frames:
            yield f"{at}: {own.name} does not take frame {item.frame}"
        elif item.command in TAKEOFFS and (item.latitude_deg, item.longitude_deg) == (0.0, 0.0):
            if not item.is_here(autopilot):
                yield f"{at}: {own.name} would take off to latitude 0, longitude 0"
        elif any(map(math.isnan, item.params)) and not own.nan_holds:
            yield f"{at}: files for {own.name} hold no NaN"
