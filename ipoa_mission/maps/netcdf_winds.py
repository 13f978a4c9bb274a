"""Attributes (CF) take precedence over names."""

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from difflib import SequenceMatcher
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import CRS
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, MissionError, NotCovered, WrongFormat, imported
from ipoa_mission.maps.units import unit_factor
from ipoa_mission.maps.vertical import height_in_name, vertical_of
from ipoa_mission.maps.wind_levels import FARTHEST_DEG, Datum, ForecastWinds, WindSamples, grid_north, to_east_north
from ipoa_mission.world.frame import Geodetic

EAST, NORTH, SPEED, FROM, TO = range(5)
PAIRS = ((EAST, NORTH), (SPEED, FROM), (SPEED, TO))  # that define a wind
STANDARD = {"eastward_wind": EAST, "x_wind": EAST, "northward_wind": NORTH, "y_wind": NORTH}
STANDARD |= {"wind_speed": SPEED, "wind_from_direction": FROM, "wind_to_direction": TO}
ALONE = (
    "eastward wind without a northward one",
    "northward wind without an eastward one",
    "speed of a wind without its direction",
    *("direction of a wind without its speed",) * 2,
)
TRUE, ALONG = ("eastward_wind", "northward_wind"), ("x_wind", "y_wind")
GRID = "the grid of its axes"  # internal attribute
_HEIGHT = r"[-_]?\d*_?(m|mabove\w*)?"
EASTWARD = re.compile(rf"(u|ua|uas|ugrd|uwnd|u[-_]?wind|u[-_]component[-_]of[-_]wind){_HEIGHT}|\d+u")
NORTHWARD = re.compile(rf"(v|va|vas|vgrd|vwnd|v[-_]?wind|v[-_]component[-_]of[-_]wind){_HEIGHT}|\d+v")
SPEEDS = re.compile(rf"(si|ws|wspd|sfcwind|wind[-_]?speed){_HEIGHT}|\d+si")
FROMS = re.compile(rf"(wd|wdir|wind[-_]?dir|wind[-_]?(from[-_]?)?direction){_HEIGHT}|\d+wdir")
NAMES = ((EASTWARD, EAST), (NORTHWARD, NORTH), (SPEEDS, SPEED), (FROMS, FROM))
MEMBERS = {"number", "member", "ens", "ensemble", "ensemble_member", "realization"}
LEADS = {"step", "lead_time", "leadtime", "forecast_period", "prediction_timedelta"}
DEGREES = {"lat": "degrees_north", "lon": "degrees_east"}


def netcdf_winds(path: Path, place: Geodetic) -> ForecastWinds:
    found = ForecastWinds(path.name)
    with _opened(path) as data:
        winds: dict[int, list[Any]] = {which: [] for which in range(5)}
        for name, variable in data.data_vars.items():
            which = _component(str(name), variable)
            if which is not None:
                winds[which].append(variable.assign_attrs({GRID: _grid(data, variable)}))
            elif _is_wind(str(name), variable):
                found.note("variable that may be a wind", str(name), _said(variable))
        for one, other in PAIRS:
            for first in [*winds[one]]:
                if (second := _partner(first, winds[other])) is None:
                    continue
                winds[one].remove(first)
                winds[other].remove(second)
                for height, datum, parts in _levels(path, first, second, found):
                    found.samples.append(_samples(path, height, datum, parts, place, found, other))
        for group in _groups(path):
            found.note("group of variables", group)
        for part in (part for parts in winds.values() for part in parts):
            which = _component(str(part.name), part) or EAST
            found.note(ALONE[which], str(part.name), _said(part), which <= NORTH or not found.samples)
    return found


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    xarray = imported("xarray", f"{path}: a forecast of winds needs xarray", "wind")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # among the libraries
            with xarray.open_dataset(path, decode_timedelta=True) as data:
                yield data
    except MissionError:
        raise
    except Exception as error:  # each library has its own
        raise WrongFormat(f"expected a forecast of winds in NetCDF or GRIB: {error}", place=path) from error


def _groups(path: Path) -> list[str]:
    """Return groups, which xarray skips."""
    h5py: Any = import_module("h5py")
    if not h5py.is_hdf5(path):
        return []
    with h5py.File(path) as data:
        return [name for name, value in data.items() if isinstance(value, h5py.Group)]


def _component(name: str, variable: Any) -> int | None:
    standard = variable.attrs.get("standard_name")
    if standard not in (None, "", "unknown"):
        return STANDARD.get(standard)
    return next((which for pattern, which in NAMES if pattern.fullmatch(name.lower())), None)


def _is_wind(name: str, variable: Any) -> bool:
    words = " ".join(str(variable.attrs.get(key, "")) for key in ("standard_name", "long_name"))
    return bool(re.search(r"wind|gust", f"{name} {words}".lower()))


def _said(variable: Any) -> str:
    return next((str(variable.attrs[key]) for key in ("standard_name", "long_name") if key in variable.attrs), "")


def _partner(first: Any, others: Sequence[Any]) -> Any | None:
    """Return the other component on the same axes, by name."""
    alike = [each for each in others if each.dims == first.dims and set(each.coords) == set(first.coords)]
    name = str(first.name)
    return max(alike, key=lambda each: SequenceMatcher(None, name, str(each.name)).ratio(), default=None)


def _levels(path: Path, east: Any, north: Any, found: ForecastWinds) -> Iterator[tuple[float, Datum, tuple[Any, Any]]]:
    """Yield all levels.

    Precedence: axis, height in the name, coordinate of one value, which xarray attaches to all variables.
    """
    name = str(east.name)
    given = [vertical for each in east.coords.values() if (vertical := vertical_of(path, each)) is not None]
    axes = [each for each in given if each.coordinate.ndim]
    single = [each for each in given if not each.coordinate.ndim]
    is_usual = any(each.fullmatch(name) for each, _ in NAMES)
    named = None if axes else height_in_name(name, str(east.attrs.get("long_name", "")), is_usual)
    if named is not None and all(each.values is not None for each in single):
        yield *named, (east, north)
        return
    heights = [each for each in axes or single if each.values is not None]
    if not heights:
        level = given[0].coordinate if given else None
        what = "wind at no height" if level is None else f"wind at {level.name}, which is no height"
        found.note(what, name, "" if level is None else level.attrs.get("units", ""))
        return
    vertical = min(heights, key=lambda each: each.datum is Datum.UNKNOWN)
    if vertical.has_no_unit:
        found.note("unit of a height, taken as m", str(vertical.coordinate.name))
    along = next(iter(vertical.coordinate.dims), None)
    for n, height in enumerate(np.atleast_1d(vertical.values).tolist()):
        parts = (east, north) if along is None else (east.isel({along: n}), north.isel({along: n}))
        yield height, vertical.datum, parts


def _samples(
    path: Path, height: float, datum: Datum, parts: tuple[Any, Any], place: Geodetic, found: ForecastWinds, second: int
) -> WindSamples:
    values = []
    for part, target in zip(parts, ("m/s", "m/s" if second == NORTH else "deg"), strict=True):
        unit = part.attrs.get("units")
        if unit is None:
            found.note(f"unit of a wind, taken as {target}", str(part.name))
        factor = 1.0 if unit is None else unit_factor(str(unit), target, f"{path}: {part.name}.units")
        there, axis_deg = _there(path, part, place)
        times, there = _valid_times(path, there)
        values.append(np.asarray(there, float).ravel() * factor)
    if second != NORTH:
        speed, angle = values[0] if second == TO else -values[0], np.radians(values[1])
        values = [speed * np.sin(angle), speed * np.cos(angle)]
    winds = np.stack(values, axis=-1)
    return WindSamples(height, datum, winds if axis_deg is None else to_east_north(winds, axis_deg), times)


def _grid(data: Any, part: Any) -> CRS | tuple[float, float] | None:
    """Return the projection of a component along a grid's axes, or its rotated pole (CF); None if unknown."""
    about = data.variables.get(str(part.attrs.get("grid_mapping", "")).partition(":")[0])
    kind = None if about is None else about.attrs.get("grid_mapping_name")
    if part.attrs.get("standard_name") not in ALONG or kind in (None, "latitude_longitude"):
        return None
    with suppress(CRSError, KeyError, TypeError, ValueError):
        if kind == "rotated_latitude_longitude":
            return float(about.attrs["grid_north_pole_latitude"]), float(about.attrs["grid_north_pole_longitude"])
        return CRS.from_cf(about.attrs)
    return None


def _there(path: Path, part: Any, place: Geodetic) -> tuple[Any, float | None]:
    """Return a component at the nearest grid point, and the direction of the grid's y axis if it is along the axes."""
    axes = ", ".join(map(str, part.dims))
    degrees = []
    for kind in ("lat", "lon"):
        name = next((key for key, each in part.coords.items() if _counts_degrees(str(key), each, kind)), None)
        if name is None:
            words = f"expected latitudes and longitudes [degrees] of a wind by {axes}"
            raise BadInput(words, place=f"{path}: {part.name}")
        degrees.append(part[name])
    latitude, longitude = degrees
    is_along = _component(str(part.name), part) in (EAST, NORTH) and part.attrs.get("standard_name") not in TRUE
    is_along = is_along and latitude.ndim == 2 and part.attrs.get("GRIB_uvRelativeToGrid") != 0
    grid = part.attrs.get(GRID)
    if is_along and grid is None:
        raise BadInput(
            "expected a wind towards the east or the north, not along the axes "
            f"{', '.join(map(str, latitude.dims))} of a turned grid",
            hint=f"set standard_name to {' or '.join(TRUE)}; or to {' or '.join(ALONG)}, with a grid_mapping",
            place=f"{path}: {part.name}",
        )
    north = np.asarray(latitude, float) - place.latitude_deg
    east = (np.asarray(longitude, float) - place.longitude_deg + 180.0) % 360.0 - 180.0
    if latitude.dims == longitude.dims:
        away = np.nan_to_num(np.hypot(north, east * np.cos(np.radians(place.latitude_deg))), nan=np.inf)
        nearest = np.unravel_index(int(away.argmin()), away.shape)
        at = dict(zip(latitude.dims, map(int, nearest), strict=True))
        off = np.abs(north[nearest]), np.abs(east[nearest])
    else:
        axes_of = ((latitude, np.abs(north)), (longitude, np.abs(east)))
        at = {axis.dims[0]: int(far.argmin()) for axis, far in axes_of if axis.ndim}
        off = np.abs(north).min(), np.abs(east).min()
    if not max(off) <= FARTHEST_DEG:
        raise NotCovered(
            f"expected a forecast of home's place, {place.latitude_deg:g}, {place.longitude_deg:g}; "
            f"the nearest {latitude.name} and {longitude.name} are {off[0]:g} and {off[1]:g} degrees away",
            place=path,
        )
    here = (float(each.isel({name: at[name] for name in each.dims})) for each in degrees)
    return part.isel(at), None if grid is None or not is_along else grid_north(grid, *here)


def _counts_degrees(name: str, coordinate: Any, kind: str) -> bool:
    """Find an unrotated latitude (`lat`) or longitude (`lon`)."""
    standard, unit = coordinate.attrs.get("standard_name"), str(coordinate.attrs.get("units", DEGREES[kind]))
    whole = {"lat": "latitude", "lon": "longitude"}[kind]
    is_named = standard == whole or (standard is None and name.lower() in (kind, whole))
    return is_named and unit.lower().startswith("deg")


def _valid_times(path: Path, part: Any) -> tuple[np.ndarray, Any]:
    """Return times (n,), and values on the same axes."""
    times = _time_of(part)
    known = {str(name) for name in (times.dims if times is not None else ())}
    strange = [str(name) for name in part.dims if str(name) not in known and not _is_member(part, str(name))]
    if strange:
        words = f"expected winds by height, member and time, not by {', '.join(strange)}"
        raise BadInput(words, place=f"{path}: {part.name}")
    if times is None:
        return np.full(part.size, np.datetime64("NaT", "s")), part
    if times.dtype.kind != "M":
        raise BadInput("expected times of the usual calendar, with their unit", place=f"{path}: {times.name}")
    both, part = times.broadcast_like(part), part.broadcast_like(times)
    return np.asarray(both.transpose(*part.dims)).astype("datetime64[s]").ravel(), part


def _time_of(part: Any) -> Any | None:
    """Take the standard name, or run time plus step."""
    by_standard = {each.attrs.get("standard_name"): each for each in part.coords.values()}
    named = {str(name).lower(): each for name, each in part.coords.items()}
    lead = by_standard.get("forecast_period")
    lead = lead if lead is not None else next((named[name] for name in LEADS if name in named), None)
    is_lead = lead is not None and lead.dtype.kind == "m"
    for valid in (named.get("valid_time"), by_standard.get("time"), named.get("time")):
        if valid is not None and valid.attrs.get("standard_name", "time") == "time":
            alone = lead is None or not lead.dims or bool(set(lead.dims) & set(valid.dims))
            return valid if alone or not is_lead else valid + lead
    run = by_standard.get("forecast_reference_time")
    return run if run is None or not is_lead else run + lead


def _is_member(part: Any, name: str) -> bool:
    standard = part[name].attrs.get("standard_name") if name in part.coords else None
    return name.lower() in MEMBERS or standard == "realization" or part.sizes[name] == 1
