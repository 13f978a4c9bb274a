"""What a firmware says to one item of a list that is uploaded to it, read in its source: taken, or why not.

An item is its command, frame, and seven values: param1 to param4, latitude, longitude (degrees; for a frame without a
place what x and y hold), altitude.
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
    """`result`: the name of the MAV_MISSION_RESULT; `param`: which of the seven it is for, or 0; `words`: why."""

    result: str
    param: int = 0
    words: str = ""


#: Why an item (command, frame, values) is refused; None where the firmware takes it.
Refusal: TypeAlias = Callable[[Firmware, int, int, Sequence[float]], Refused | None]


@dataclass(frozen=True)
class Refusals:
    """What it says to an item of each list; of a `mission` it also counts how many items there are on the wire."""

    mission: Callable[[Firmware, int, int, Sequence[float], int], Refused | None]
    fence: Refusal
    rally: Refusal


def param_name(n: int) -> str:
    """What one of the seven is called in a mission.

    >>> param_name(5)
    'latitude'
    """
    return PARAM_NAMES[n - 1]
