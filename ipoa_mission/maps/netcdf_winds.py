"""Read winds out of NetCDF by xarray, at the nearest grid point: what its attributes say goes before its names (CF)."""

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from difflib import SequenceMatcher
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.errors import BadInput, MissionError, NotCovered, WrongFormat, imported
from ipoa_mission.maps.units import unit_factor
from ipoa_mission.maps.vertical import height_in_name, vertical_of
from ipoa_mission.maps.wind_levels import FARTHEST_DEG, Datum, ForecastWinds, WindSamples
from ipoa_mission.world.frame import Geodetic

STANDARD = {"eastward_wind": 0, "x_wind": 0, "northward_wind": 1, "y_wind": 1}
_HEIGHT = r"[-_]?\d*_?(m|mabove\w*)?"
EASTWARD = re.compile(rf"(u|ua|uas|ugrd|uwnd|u[-_]?wind|u[-_]component[-_]of[-_]wind){_HEIGHT}|\d+u")
NORTHWARD = re.compile(rf"(v|va|vas|vgrd|vwnd|v[-_]?wind|v[-_]component[-_]of[-_]wind){_HEIGHT}|\d+v")
MEMBERS = {"number", "member", "ens", "ensemble", "ensemble_member", "realization"}
LEADS = {"step", "lead_time", "leadtime", "forecast_period", "prediction_timedelta"}
DEGREES = {"lat": "degrees_north", "lon": "degrees_east"}


def netcdf_winds(path: Path, place: Geodetic) -> ForecastWinds:
    """The winds at the nearest grid point.

    Raises:
        BadInput: the file is damaged, of another place, or in units that are unknown.
        MissionError: xarray is not installed.
    """
    found = ForecastWinds(path.name)
    with _opened(path) as data:
        winds: tuple[list[Any], list[Any]] = ([], [])
        for name, variable in data.data_vars.items():
            which = _component(str(name), variable)
            if which is not None:
                winds[which].append(variable)
            elif _is_wind(str(name), variable):
                found.leave("variable that may be a wind", str(name), _said(variable))
        for east in winds[0]:
            north = _partner(east, winds[1])
            if north is None:
                found.leave("eastward wind without a northward one", str(east.name), _said(east), True)
                continue
            winds[1].remove(north)
            for height, datum, parts in _levels(path, east, north, found):
                found.samples.append(_samples(path, height, datum, parts, place, found))
        for group in _groups(path):
            found.leave("group of variables", group)
        for north in winds[1]:
            found.leave("northward wind without an eastward one", str(north.name), _said(north), True)
    return found


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    xarray = imported("xarray", f"{path}: a forecast of winds needs xarray", "wind")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what the libraries say to each other
            with xarray.open_dataset(path, decode_timedelta=True) as data:
                yield data
    except MissionError:
        raise
    except Exception as error:  # each library has its own
        raise WrongFormat(f"expected a forecast of winds in NetCDF or GRIB: {error}", place=path) from error


def _groups(path: Path) -> list[str]:
    """The groups of a NetCDF-4 file, of which xarray reads none."""
    h5py: Any = import_module("h5py")
    if not h5py.is_hdf5(path):
        return []
    with h5py.File(path) as data:
        return [name for name, value in data.items() if isinstance(value, h5py.Group)]


def _component(name: str, variable: Any) -> int | None:
    """0 towards the east, 1 towards the north, None for anything else: a standard name goes before the name."""
    standard = variable.attrs.get("standard_name")
    if standard not in (None, "", "unknown"):
        return STANDARD.get(standard)
    return 0 if EASTWARD.fullmatch(name.lower()) else 1 if NORTHWARD.fullmatch(name.lower()) else None


def _is_wind(name: str, variable: Any) -> bool:
    words = " ".join(str(variable.attrs.get(key, "")) for key in ("standard_name", "long_name"))
    return bool(re.search(r"wind|gust", f"{name} {words}".lower()))


def _said(variable: Any) -> str:
    """What a variable is by its own attributes."""
    return next((str(variable.attrs[key]) for key in ("standard_name", "long_name") if key in variable.attrs), "")


def _partner(east: Any, norths: Sequence[Any]) -> Any | None:
    """The northward wind on the same axes whose name is most alike."""
    alike = [each for each in norths if each.dims == east.dims and set(each.coords) == set(east.coords)]
    name = str(east.name)
    return max(alike, key=lambda each: SequenceMatcher(None, name, str(each.name)).ratio(), default=None)


def _levels(path: Path, east: Any, north: Any, found: ForecastWinds) -> Iterator[tuple[float, Datum, tuple[Any, Any]]]:
    """Height, datum and both components at every level; levels that have no height are counted.

    An axis goes before a height in the name, and that before a coordinate of one value: xarray hands these to all
    variables.
    """
    name = str(east.name)
    given = [vertical for each in east.coords.values() if (vertical := vertical_of(path, each)) is not None]
    axes = [each for each in given if each.coordinate.ndim]
    single = [each for each in given if not each.coordinate.ndim]
    named = None if axes else height_in_name(name, str(east.attrs.get("long_name", "")), bool(EASTWARD.fullmatch(name)))
    if named is not None and all(each.values is not None for each in single):
        yield *named, (east, north)
        return
    heights = [each for each in axes or single if each.values is not None]
    if not heights:
        level = given[0].coordinate if given else None
        what = "wind at no height" if level is None else f"wind at {level.name}, which is no height"
        found.leave(what, name, "" if level is None else level.attrs.get("units", ""))
        return
    vertical = min(heights, key=lambda each: each.datum is Datum.UNKNOWN)
    if vertical.has_no_unit:
        found.leave("unit of a height, taken as m", str(vertical.coordinate.name))
    along = next(iter(vertical.coordinate.dims), None)
    for n, height in enumerate(np.atleast_1d(vertical.values).tolist()):
        parts = (east, north) if along is None else (east.isel({along: n}), north.isel({along: n}))
        yield height, vertical.datum, parts


def _samples(
    path: Path, height: float, datum: Datum, parts: tuple[Any, Any], place: Geodetic, found: ForecastWinds
) -> WindSamples:
    values = []
    for part in parts:
        unit = part.attrs.get("units")
        if unit is None:
            found.leave("unit of a wind, taken as m/s", str(part.name))
        factor = 1.0 if unit is None else unit_factor(str(unit), "m/s", f"{path}: {part.name}.units")
        there = _there(path, part, place)
        times, there = _valid_times(path, there)
        values.append(np.asarray(there, float).ravel() * factor)
    return WindSamples(height, datum, np.stack(values, axis=-1), times)


def _there(path: Path, part: Any, place: Geodetic) -> Any:
    """A component at the nearest grid point."""
    for kind, wanted in (("lat", place.latitude_deg), ("lon", place.longitude_deg)):
        name = next((key for key, each in part.coords.items() if _counts_degrees(str(key), each, kind)), None)
        if name is None or part[name].ndim > 1:
            raise BadInput(
                "expected latitudes and longitudes [degrees] as axes of the winds", place=f"{path}: {part.name}"
            )
        degrees = np.atleast_1d(np.asarray(part[name], float))
        off = np.abs((degrees - wanted + 180.0) % 360.0 - 180.0)
        nearest = int(off.argmin())
        if not off[nearest] <= FARTHEST_DEG:
            raise NotCovered(f"expected a forecast of home's place, {wanted:g} degrees of {name}", place=path)
        part = part.isel({part[name].dims[0]: nearest}) if part[name].ndim else part
    return part


def _counts_degrees(name: str, coordinate: Any, kind: str) -> bool:
    """Whether a coordinate is the latitude (`lat`) or longitude (`lon`), in degrees of a grid that is not turned."""
    standard, unit = coordinate.attrs.get("standard_name"), str(coordinate.attrs.get("units", DEGREES[kind]))
    whole = {"lat": "latitude", "lon": "longitude"}[kind]
    is_named = standard == whole or (standard is None and name.lower() in (kind, whole))
    return is_named and unit.lower().startswith("deg")


def _valid_times(path: Path, part: Any) -> tuple[np.ndarray, Any]:
    """When each value blows, (n,), and the values over the same axes: a run and its step make a time."""
    times = _time_of(part)
    known = {str(name) for name in (times.dims if times is not None else ())}
    strange = [str(name) for name in part.dims if str(name) not in known and not _is_member(part, str(name))]
    if strange:
        raise BadInput(
            f"expected winds by height, member and time, not by {', '.join(strange)}", place=f"{path}: {part.name}"
        )
    if times is None:
        return np.full(part.size, np.datetime64("NaT", "s")), part
    if times.dtype.kind != "M":
        raise BadInput("expected times of the usual calendar, with their unit", place=f"{path}: {times.name}")
    both, part = times.broadcast_like(part), part.broadcast_like(times)
    return np.asarray(both.transpose(*part.dims)).astype("datetime64[s]").ravel(), part


def _time_of(part: Any) -> Any | None:
    """When it blows: what is the time by its standard name, or run and step together."""
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
