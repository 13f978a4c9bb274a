"""What the vehicle meets in flight, one visit after the other: jumps followed, positions in metres around home.

`up` is the height above home as the autopilot keeps it (a flat Earth), not the height over home's tangent plane.
"""

import math
from dataclasses import dataclass

import numpy as np

from ipoa_mission.commands import Command, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points
from ipoa_mission.items import LEVEL, Ground, Item, Mission
from ipoa_mission.itinerary.as_flown import as_flown
from ipoa_mission.world.frame import LocalFrame

#: ArduPilot's own bound on what a mission may hold, taken here as a bound on what a loop may unroll to.
MOST_VISITS = 20_000


LAST_NAV = 95  # MAV_CMD_NAV_LAST: higher numbers do not move the vehicle
#: Above it, but they take time all the same.
UNTIMED = frozenset({Command.NAV_SCRIPT_TIME, Command.NAV_ATTITUDE_TIME, Command.CONDITION_GATE})
#: They put off the commands after them, which the models take as done at once.
CONDITIONS = frozenset({Command.CONDITION_DELAY, Command.CONDITION_DISTANCE})
TAKEOFFS = frozenset({Command.NAV_TAKEOFF, Command.NAV_VTOL_TAKEOFF})


@dataclass(frozen=True)
class Visit:
    """An item as its turn comes; `seq` counts from 1 (home is 0)."""

    seq: int
    item: Item


@dataclass(frozen=True)
class Itinerary:
    """Visits in order, and for each where it lies: east, north, up (n, 3) [m]; NaN where an item names no place.

    Landings come down to the `ground`.
    """

    visits: tuple[Visit, ...]
    places: Points
    over_terrain: tuple[int, ...]
    ground: Ground = LEVEL


def itinerary(mission: Mission) -> Itinerary:
    """Unroll the mission's DO_JUMP loops and put its items into metres around home.

    Heights over terrain are taken as heights over home (the time model knows no terrain); `over_terrain` names them.

    Raises:
        BadInput: a jump leads nowhere or never ends.
    """
    mission = as_flown(mission)
    order = _followed(mission)
    places = _places(mission)
    over_terrain = tuple(
        n
        for n, item in enumerate(mission.items, 1)
        if item.frame in (Frame.GLOBAL_TERRAIN_ALT, Frame.GLOBAL_TERRAIN_ALT_INT) and item.has_position
    )
    visits = tuple(Visit(n + 1, mission.items[n]) for n in order)
    return Itinerary(visits, places[list(order)] if order else places[:0], over_terrain, mission.ground)


def flying_already(route: Itinerary) -> float | None:
    """The height over home [m] at which a mission without a take-off begins: that of its first place; else None."""
    for visit, place in zip(route.visits, route.places, strict=True):
        command = visit.item.command
        if command <= LAST_NAV and command != Command.NAV_DELAY:
            return None if command in TAKEOFFS or math.isnan(place[0]) else max(float(place[2]), 0.0)
    return None


def _followed(mission: Mission) -> list[int]:
    """Indices of the items in the order in which they come up, every DO_JUMP followed as often as it asks."""
    left: dict[int, int] = {}
    order: list[int] = []
    at = 0
    while at < len(mission.items):
        item = mission.items[at]
        if len(order) > MOST_VISITS:
            raise BadInput(f"items[{at}]: the mission's jumps make more than {MOST_VISITS} visits")
        if item.command != Command.DO_JUMP:
            order.append(at)
            at += 1
            continue
        target, repeats = int(item.params[0]), int(item.params[1])
        if not 1 <= target <= len(mission.items):
            raise BadInput(
                f"items[{at}].param1: expected an item from 1 to {len(mission.items)} to jump to, not {target}"
            )
        if repeats < 0:
            raise BadInput(f"items[{at}].param2: the jump never ends, so the flight has no time")
        remaining = left.setdefault(at, repeats)
        left[at] = remaining - 1
        at = target - 1 if remaining > 0 else at + 1
    return order


def _places(mission: Mission) -> Points:
    items = mission.items
    if not items:
        return np.zeros((0, 3))
    lat, lon = (np.array([getattr(item, name) for item in items]) for name in ("latitude_deg", "longitude_deg"))
    flat = LocalFrame(mission.home).to_local(lat, lon, np.full(len(items), mission.home.altitude))
    up = np.array([mission.altitude_above_home(item) for item in items])
    up = np.where(np.isnan(up), np.array([item.altitude for item in items]), up)
    placed = np.array([item.has_position for item in items])
    east, north = (np.where(placed, flat[:, axis], math.nan) for axis in (0, 1))
    return np.column_stack([east, north, up])
