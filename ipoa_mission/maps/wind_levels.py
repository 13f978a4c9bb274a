"""Winds of a forecast at home, by height and vertical datum, before they become a profile."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points
from ipoa_mission.unread import Unread
from ipoa_mission.wind import Wind

FARTHEST_DEG = 0.5  # from the nearest point of the grid, in latitude or longitude
STRONGEST = 150.0  # a component of any wind below the jet streams is weaker [m/s]
Times = NDArray[np.datetime64]


class Datum(StrEnum):
    """What the heights of a forecast count from."""

    GROUND = "the ground"
    SEA = "the geoid"
    ELLIPSOID = "the ellipsoid"
    UNKNOWN = "an unknown datum"


@dataclass(frozen=True)
class WindSamples:
    """Values at one height [m], of all members and times.

    `winds` are east and north [m/s], (n, 2), NaN where the file has none; `times` are when they blow (UTC), (n,), NaT
    where the file does not say.
    """

    height: float
    datum: Datum
    winds: Points
    times: Times


@dataclass
class ForecastWinds:
    """What the forecast `file` holds at home, and what of it was not read."""

    file: str
    samples: list[WindSamples] = field(default_factory=list)
    unread: list[Unread] = field(default_factory=list)

    def leave(self, what: str, place: str, example: object = "", may_limit: bool = False, count: int = 1) -> None:
        """Name something that is not read, or not understood."""
        self.unread.append(Unread(self.file, what, place, str(example), count, may_limit))


@dataclass(frozen=True)
class ForecastWind:
    """The wind in a forecast, remarks on how it was read, and what of it was not."""

    wind: Wind
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()
