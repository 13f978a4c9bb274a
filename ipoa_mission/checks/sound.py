"""What of a mission can be judged where some of its positions make no sense: the legs between the others."""

import math
from collections.abc import Iterable
from dataclasses import replace

from ipoa_mission.checks.finding import Finding, Severity
from ipoa_mission.checks.positions import home_elsewhere
from ipoa_mission.commands import TAKEOFFS, Command, Frame
from ipoa_mission.items import Item, Mission
from ipoa_mission.itinerary.legs import Leg

_NOWHERE = Item(Command.CONDITION_DELAY, Frame.MISSION)


def sound_part(mission: Mission, positions: Iterable[Finding]) -> tuple[Mission, frozenset[int]] | None:
    """The mission without what `positions`, the findings about its positions, call wrong; and which items are left out.

    Numbers of items stay. A take-off that names no place is one from home. None where home itself is wrong.
    """
    wrong = {finding.seq for finding in positions if finding.severity is Severity.ERROR}
    if 0 in wrong or home_elsewhere(mission):
        return None
    if None in wrong:  # the fence, or a rally point
        mission = replace(mission, fence=(), rally=())
    left_out: set[int] = set()
    items = list(mission.items)
    for seq in wrong - {None}:
        assert seq is not None
        item = items[seq - 1]
        if item.command in TAKEOFFS and not item.has_position and 0 < mission.altitude_above_home(item) < math.inf:
            home = mission.home
            items[seq - 1] = replace(item, latitude_deg=home.latitude_deg, longitude_deg=home.longitude_deg)
        else:
            items[seq - 1] = _NOWHERE
            left_out.add(seq)
    return replace(mission, items=tuple(items)), frozenset(left_out)


def between_sound(legs: tuple[Leg, ...], left_out: frozenset[int]) -> tuple[Leg, ...]:
    """The legs that neither lead to an item that is left out nor away from one."""
    after = {min((leg.seq for leg in legs if leg.seq > seq), default=seq) for seq in left_out}
    return tuple(leg for leg in legs if leg.seq not in after | left_out)
