"""A forecast's winds at home."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points
from ipoa_mission.unread import Unread
from ipoa_mission.wind import Wind

FARTHEST_DEG = 0.5  # to the nearest grid point
STRONGEST = 150.0  # below the jet streams [m/s]
Times = NDArray[np.datetime64]


class Datum(StrEnum):
    GROUND = "the ground"
    SEA = "the geoid"
    ELLIPSOID = "the ellipsoid"
    UNKNOWN = "an unknown datum"


@dataclass(frozen=True)
class WindSamples:
    """`winds`: east and north [m/s], (n, 2), NaN if missing; `times` (UTC), (n,), NaT if unknown."""

    height: float
    datum: Datum
    winds: Points
    times: Times


@dataclass
class ForecastWinds:
    file: str
    samples: list[WindSamples] = field(default_factory=list)
    unread: list[Unread] = field(default_factory=list)

    def note(self, what: str, place: str, example: object = "", may_limit: bool = False, count: int = 1) -> None:
        self.unread.append(Unread(self.file, what, place, str(example), count, may_limit))


@dataclass(frozen=True)
class ForecastWind:
    wind: Wind
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()
