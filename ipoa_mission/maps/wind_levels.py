"""Hold a forecast's winds at home; convert units and axes."""

import re
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum, auto
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pyproj import CRS, Geod, Proj

from ipoa_mission.errors import BadInput, NotCovered, imported
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Plane
from ipoa_mission.unread import Unread
from ipoa_mission.wind import Wind

FARTHEST_DEG = 0.5  # to the nearest grid point
Times = NDArray[np.datetime64]


class Component(IntEnum):
    EAST = 0
    NORTH = auto()
    SPEED = auto()
    FROM = auto()
    TO = auto()


class Datum(StrEnum):
    GROUND = "the ground"
    SEA = "the geoid"
    ELLIPSOID = "the ellipsoid"
    UNKNOWN = "an unknown datum"


@dataclass(frozen=True)
class WindSamples:
    """`winds`: east and north [m/s], NaN if missing; `times` (UTC), (n,), NaT if unknown."""

    height: float
    datum: Datum
    winds: Plane
    times: Times


@dataclass
class ForecastWinds:
    path: Path
    place: Geodetic
    samples: list[WindSamples] = field(default_factory=list)
    unread: list[Unread] = field(default_factory=list)

    def note(self, subject: str, place: str, example: object = "", may_limit: bool = False, count: int = 1) -> None:
        """Note, unless the count is 0."""
        if count:
            self.unread.append(Unread(self.path.name, subject, place, str(example), count, may_limit))


@dataclass(frozen=True)
class ForecastWind:
    wind: Wind
    remarks: tuple[str, ...]
    unread: tuple[Unread, ...] = ()


def nearest_point(latitudes: Any, longitudes: Any, winds: ForecastWinds) -> tuple[int, float, float]:
    """Return the nearest grid point's number, latitude and longitude [deg]; raise NotCovered."""
    home = winds.place
    north = np.abs(latitudes - home.latitude_deg)
    east = np.abs((longitudes - home.longitude_deg + 180.0) % 360.0 - 180.0)
    away = np.hypot(north, east * np.cos(np.radians(home.latitude_deg)))
    n = int(np.where(np.isnan(away), np.inf, away).argmin())
    latitude, longitude = (float(values[n]) for values in (latitudes, longitudes))
    if not max(north[n], east[n]) <= FARTHEST_DEG:
        words = f"expected a forecast of home's place, {home.latitude_deg:g}, {home.longitude_deg:g}"
        nearest = f"the nearest point is {latitude:g}, {(longitude + 180.0) % 360.0 - 180.0:g}"
        raise NotCovered(f"{words}; {nearest}", place=winds.path)
    return n, latitude, longitude


def towards(speed: Any, from_deg: Any) -> tuple[Any, Any]:
    return -speed * np.sin(np.radians(from_deg)), -speed * np.cos(np.radians(from_deg))


def grid_north(grid: str | CRS | tuple[float, float], latitude_deg: float, longitude_deg: float) -> float:
    """Return the direction of a grid's y axis, clockwise from north [deg]; `grid`: projection or rotated north pole."""
    if isinstance(grid, tuple):
        return float(Geod(a=1.0, b=1.0).inv(longitude_deg, latitude_deg, grid[1], grid[0])[0])
    return float(Proj(grid).get_factors(longitude_deg, latitude_deg).meridian_convergence)


def to_east_north(along: Plane, axis_deg: float) -> Plane:
    """Return winds along the x and y axes, with y towards `axis_deg`, as east and north."""
    sin = np.sin(np.radians(axis_deg))
    cos = np.cos(np.radians(axis_deg))
    return np.asarray(along @ np.array([[cos, -sin], [sin, cos]]))


def unit_factor(unit: str, target: str, place: str) -> float:
    pint, registry = _unit_registry()
    for spelling in (unit, unit.lower()):
        try:
            return float(registry.Quantity(1.0, registry.parse_units(spelling)).to(target).magnitude)
        except (pint.PintError, ValueError, TypeError, AssertionError, AttributeError, RecursionError):
            continue
    raise BadInput(f"expected a unit that converts to {target}, not {unit!r}", place=place)


@cache
def _unit_registry() -> tuple[Any, Any]:
    pint = imported("pint", "units of a forecast need pint, which is not installed", "wind")
    registry = pint.UnitRegistry(preprocessors=[lambda text: re.sub(r"(?<=[A-Za-z])(?=-?\d)", "**", text)])  # s-1
    registry.define("geopotential_meter = meter = gpm")
    registry.define("feet_per_minute = foot / minute = fpm")
    return pint, registry
