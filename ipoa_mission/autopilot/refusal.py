"""A firmware's answer to an uploaded item, read in its source.

Its values: param1 to param4, latitude, longitude [degrees; or x, y], altitude.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.firmware_tables import Firmware

POLYGON = frozenset({Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION})
PARAM_NAMES = ("param1", "param2", "param3", "param4", "latitude", "longitude", "altitude")


@dataclass(frozen=True)
class Refused:
    """MAV_MISSION_RESULT, number of the wrong value or 0, reason."""

    result: str
    param: int = 0
    words: str = ""


Refusal: TypeAlias = Callable[[Firmware, int, int, Sequence[float]], Refused | None]


@dataclass(frozen=True)
class Refusals:
    """Checks of each list; `mission` takes the number of items on the wire."""

    mission: Callable[[Firmware, int, int, Sequence[float], int], Refused | None]
    fence: Refusal
    rally: Refusal


def param_name(n: int) -> str:
    """Name a value, from 1.

    >>> param_name(5)
    'latitude'
    """
    return PARAM_NAMES[n - 1]
