"""Hold the winds of a forecast at home by height and vertical datum, before they become a profile."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points
from ipoa_mission.unread import Unread
from ipoa_mission.wind import Wind

FARTHEST_DEG = 0.5  # distance to the nearest grid point, in latitude or longitude
STRONGEST = 150.0  # any component of a wind below the jet streams is weaker [m/s]
Times = NDArray[np.datetime64]


class Datum(StrEnum):
    """The zero of a forecast's heights."""

    GROUND = "the ground"
    SEA = "the geoid"
    ELLIPSOID = "the ellipsoid"
    UNKNOWN = "an unknown datum"


@dataclass(frozen=True)
class WindSamples:
    """Values at one height [m], of all members and times.

    `winds` are east and north [m/s], (n, 2), NaN if missing. `times` are their valid times (UTC), (n,), NaT if unknown.
    """

    height: float
    datum: Datum
    winds: Points
    times: Times


@dataclass
class ForecastWinds:
    """The winds of the forecast `file` at home, and its unread parts."""

    file: str
    samples: list[WindSamples] = field(default_factory=list)
    unread: list[Unread] = field(default_factory=list)

    def note(self, what: str, place: str, example: object = "", may_limit: bool = False, count: int = 1) -> None:
        """Note a part that is not read or not understood."""
        self.unread.append(Unread(self.file, what, place, str(example), count, may_limit))


@dataclass(frozen=True)
class ForecastWind:
    """The wind of a forecast, with remarks and unread parts."""

    wind: Wind
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()
