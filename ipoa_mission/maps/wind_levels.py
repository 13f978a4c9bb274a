"""A forecast's winds at home."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from pyproj import CRS, Geod, Proj

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


def grid_north(grid: str | CRS | tuple[float, float], latitude_deg: float, longitude_deg: float) -> float:
    """Return the direction of a grid's y axis, clockwise from north [deg]; `grid`: projection or rotated north pole."""
    if isinstance(grid, tuple):
        return float(Geod(a=1.0, b=1.0).inv(longitude_deg, latitude_deg, grid[1], grid[0])[0])
    return float(Proj(grid).get_factors(longitude_deg, latitude_deg).meridian_convergence)


def to_east_north(along: Points, axis_deg: float) -> Points:
    """Return winds (n, 2) along the x and y axes, with y towards `axis_deg`, as east and north."""
    sin, cos = np.sin(np.radians(axis_deg)), np.cos(np.radians(axis_deg))
    return np.asarray(along @ np.array([[cos, -sin], [sin, cos]]))


@dataclass(frozen=True)
class ForecastWind:
    wind: Wind
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()
