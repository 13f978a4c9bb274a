"""A firmware's answer to one item of an uploaded list, read in its source.

An item is its command, frame, and seven values: param1 to param4, latitude, longitude, altitude. Latitude and longitude
are in degrees, or x and y in a frame without a place.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.mission.commands import Command
from ipoa_mission.vehicles.firmware_tables import Firmware

POLYGON = frozenset({Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION})
PARAM_NAMES = ("param1", "param2", "param3", "param4", "latitude", "longitude", "altitude")


@dataclass(frozen=True)
class Refused:
    """`result`: name of the MAV_MISSION_RESULT. `param`: number of the wrong value, or 0. `words`: the reason."""

    result: str
    param: int = 0
    words: str = ""


#: Returns the refusal of an item (command, frame, values); None if accepted.
Refusal: TypeAlias = Callable[[Firmware, int, int, Sequence[float]], Refused | None]


@dataclass(frozen=True)
class Refusals:
    """Checks for an item of each list; `mission` also takes the number of items on the wire."""

    mission: Callable[[Firmware, int, int, Sequence[float], int], Refused | None]
    fence: Refusal
    rally: Refusal


def param_name(n: int) -> str:
    """Return the name of a value by its number, from 1.

    >>> param_name(5)
    'latitude'
    """
    return PARAM_NAMES[n - 1]
