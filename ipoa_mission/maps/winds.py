"""Wind out of a weather forecast: NetCDF or GRIB by xarray, with what its members and hours say apart as the spread.

Winds are two variables, towards the east and the north, known by their standard names or as u and v; heights above the
ground are a coordinate in meters, or stand in the name, as in u10. Those at the nearest point of the grid count.
"""

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points
from ipoa_mission.wind import MOST_LEVELS, Wind
from ipoa_mission.world.frame import Geodetic

GRIB = (".grib", ".grb", ".grib2", ".grb2")
EASTWARD, NORTHWARD = re.compile(r"u(grd)?_?(\d+)?m?|(\d+)u"), re.compile(r"v(grd)?_?(\d+)?m?|(\d+)v")
STANDARD = {"eastward_wind": 0, "northward_wind": 1}
MEMBERS = {"number", "member", "ensemble", "realization"}
HEIGHTS = {"height", "heightAboveGround", "height_above_ground", "altitude", "z"}
FARTHEST_DEG = 0.5  # from the nearest point of the grid, in latitude or longitude
LASTS = np.timedelta64(1, "h")  # a flight, as for zones
HIGHEST = 500.0  # above the ground [m]: a level above it is not kept beside lower ones


def read_wind(path: Path, place: Geodetic, time: np.datetime64 | None) -> Wind:
    """The wind over a place from a time (UTC) on; its `spread`: how far a member or an hour is from the mean at most.

    Raises:
        BadInput: the file cannot be read, has no such winds, or is of another place or time.
        MissionError: a library that reads it is not installed.
    """
    levels = dict[float, list[Points]]()
    for data in _opened(path):
        for height, east, north in _winds(data):
            both = np.stack([_there(path, part, place, time) for part in (east, north)], axis=-1)
            levels.setdefault(height, []).append(both.reshape(-1, 2))
    heights = _thinned(sorted(levels))
    if not heights:
        raise BadInput(f"{path}: expected winds (eastward_wind and northward_wind, or u and v) at heights in meters")
    every = [np.concatenate(levels[height]) for height in heights]
    means = [part.mean(axis=0) for part in every]
    apart = max(float(np.hypot(*(part - mean).T).max()) for part, mean in zip(every, means, strict=True))
    winds = [Wind.towards_north_east(float(north), float(east)) for east, north in means]
    if len(winds) == 1:
        return Wind(winds[0].speed, winds[0].from_deg, spread=apart)
    return Wind.of_profile(heights, [wind.speed for wind in winds], [wind.from_deg for wind in winds], apart)


def _thinned(heights: list[float]) -> list[float]:
    low = [height for height in heights if height <= HIGHEST] or heights[:1]
    picked = np.linspace(0, len(low) - 1, min(len(low), MOST_LEVELS)).round().astype(int)
    return [low[n] for n in dict.fromkeys(picked.tolist())]


def _opened(path: Path) -> list[Any]:
    """The sets of variables in a file: one of NetCDF, one for each kind of level of GRIB."""
    hint = "pip install 'ipoa-mission[wind]'"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what the libraries say to each other
            if path.suffix.lower() in GRIB:
                import cfgrib

                return list(cfgrib.open_datasets(str(path), backend_kwargs={"indexpath": ""}))
            import xarray

            with xarray.open_dataset(path) as data:
                return [data.load()]
    except ImportError as error:
        raise MissionError(f"{path}: a forecast of winds needs {error.name}", hint=hint) from error
    except Exception as error:  # each library has its own
        raise BadInput(f"{path}: expected a forecast of winds in NetCDF or GRIB: {error}") from error


def _winds(data: Any) -> Iterator[tuple[float, Any, Any]]:
    """Height [m], and what it blows towards the east and the north, of every level."""
    found = dict[str, dict[int, Any]]()
    for name, variable in data.data_vars.items():
        name = str(name).lower()
        by_name = 0 if EASTWARD.fullmatch(name) else 1 if NORTHWARD.fullmatch(name) else None
        which = STANDARD.get(variable.attrs.get("standard_name", ""), by_name)
        if which is not None:
            found.setdefault("".join(re.findall(r"\d+", name)), {})[which] = variable
    for digits, parts in found.items():
        if len(parts) < 2:
            continue
        east, north = parts[0], parts[1]
        along = next((name for name in east.dims if name in HEIGHTS), None)
        if along is not None:
            for n, height in enumerate(np.asarray(east[along], float).tolist()):
                yield height, east.isel({along: n}), north.isel({along: n})
            continue
        if digits:
            yield float(digits), east, north
            continue
        alone = [float(east[name]) for name in HEIGHTS & set(map(str, east.coords)) if east[name].ndim == 0]
        yield from ((height, east, north) for height in alone[:1])


def _there(path: Path, part: Any, place: Geodetic, time: np.datetime64 | None) -> np.ndarray:
    """All members' and hours' values of one part of the wind at the nearest point, (n,) [m/s]."""
    for kind, wanted in (("lat", place.latitude_deg), ("lon", place.longitude_deg)):
        name = next((str(one) for one in part.coords if str(one).lower().startswith(kind)), None)
        if name is None or part[name].ndim > 1:
            raise BadInput(f"{path}: expected latitudes and longitudes as axes of the winds")
        degrees = np.atleast_1d(np.asarray(part[name], float))
        off = np.abs((degrees - wanted + 180.0) % 360.0 - 180.0)
        nearest = int(off.argmin())
        if off[nearest] > FARTHEST_DEG:
            raise BadInput(f"{path}: expected a forecast of home's place, {wanted:g} degrees of {name}")
        part = part.isel({name: nearest}) if part[name].ndim else part
    hours = next((name for name in ("valid_time", "time") if name in part.coords and part[name].ndim < 2), None)
    if hours is not None:
        which = _hours(path, np.atleast_1d(np.asarray(part[hours], "datetime64[s]")), time)
        part = part.isel({part[hours].dims[0]: which}) if part[hours].ndim else part
    strange = [str(name) for name in part.dims if name not in MEMBERS and name not in ("time", "step", "valid_time")]
    if strange:
        raise BadInput(f"{path}: expected winds by height, member and time, not by {', '.join(strange)}")
    values = np.asarray(part, float).ravel()
    if not np.isfinite(values).all():
        raise BadInput(f"{path}: expected a wind at home, but there is none at the nearest point")
    return values


def _hours(path: Path, times: np.ndarray, time: np.datetime64 | None) -> list[int]:
    """The numbers of the times that a flight meets: the last one before it, those in it, the first one after it."""
    if time is None:
        if len(times) == 1:
            return [0]
        raise BadInput(f"{path}: expected `time` in the scenario, for a forecast of {len(times)} times")
    begin = time.astype("datetime64[s]")
    if begin + LASTS < times.min() or begin - LASTS > times.max():
        raise BadInput(f"{path}: expected a forecast for {begin}, not of {times.min()} to {times.max()}")
    first = int(np.searchsorted(times, begin, side="right")) - 1
    last = int(np.searchsorted(times, begin + LASTS, side="left"))
    return list(range(max(first, 0), min(last, len(times) - 1) + 1))
