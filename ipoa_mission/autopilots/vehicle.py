"""What flies: the autopilot family, and its parameters by the autopilot's own names and units."""

from collections.abc import Mapping
from enum import StrEnum
from typing import TypeAlias

Parameters: TypeAlias = Mapping[str, float]
NO_PARAMETERS: Parameters = {}
SINGLE_MAX = 3.4e38  # what MAVLink's floats can carry


class Autopilot(StrEnum):
    """The two firmware families that the package speaks, writes and estimates for."""

    PX4 = "px4"
    ARDUPILOT = "ardupilot"
