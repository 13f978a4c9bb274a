"""CF attributes take precedence over names."""

import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from difflib import SequenceMatcher
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import CRS
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, MissionError, WrongFormat, imported
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.maps import wind_levels
from ipoa_mission.maps.wind_levels import Component, Datum, ForecastWinds

STANDARD_COMPONENTS = {
    **dict.fromkeys(("eastward_wind", "x_wind"), Component.EAST),
    **dict.fromkeys(("northward_wind", "y_wind"), Component.NORTH),
    "wind_speed": Component.SPEED,
    "wind_from_direction": Component.FROM,
    "wind_to_direction": Component.TO,
}
GEOGRAPHIC = ("eastward_wind", "northward_wind")
ALONG_AXES = ("x_wind", "y_wind")
AXES_GRID = "the grid of its axes"  # internal attribute
ALONE = {
    Component.EAST: "eastward wind without a northward one",
    Component.NORTH: "northward wind without an eastward one",
    Component.SPEED: "speed of a wind without its direction",
    **dict.fromkeys((Component.FROM, Component.TO), "direction of a wind without its speed"),
}
_LEVEL = r"[-_]?\d*_?(m|mabove\w*)?"
COMPONENT_NAMES = (
    (re.compile(rf"(u|ua|uas|ugrd|uwnd|u[-_]?wind|u[-_]component[-_]of[-_]wind){_LEVEL}|\d+u"), Component.EAST),
    (re.compile(rf"(v|va|vas|vgrd|vwnd|v[-_]?wind|v[-_]component[-_]of[-_]wind){_LEVEL}|\d+v"), Component.NORTH),
    (re.compile(rf"(si|ws|wspd|sfcwind|wind[-_]?speed){_LEVEL}|\d+si"), Component.SPEED),
    (re.compile(rf"(wd|wdir|wind[-_]?dir|wind[-_]?(from[-_]?)?direction){_LEVEL}|\d+wdir"), Component.FROM),
)
STANDARD_DATUMS = {
    "height": Datum.GROUND,
    "altitude": Datum.SEA,
    "height_above_mean_sea_level": Datum.SEA,
    "height_above_geopotential_datum": Datum.SEA,
    "geopotential_height": Datum.SEA,
    "height_above_reference_ellipsoid": Datum.ELLIPSOID,
}
# Without a standard name.
DATUM_WORDS = (
    (Datum.ELLIPSOID, re.compile(r"ellipsoid|wgs ?84|\bhae\b")),
    (Datum.SEA, re.compile(r"above[ _]?(the )?(mean[ _]?)?sea|\b(a?msl|asl)\b|altitude|geoid|geopotential")),
    (Datum.GROUND, re.compile(r"above[ _]?(the )?(ground|surface|terrain)|\bagl\b")),
)
HEIGHT_AXIS = re.compile(r"z|lev|levels?|heights?(_?\d+)?|alt|z?agl|msl|h(gt)?|zlev|height_levels?|elevation")


def netcdf_winds(path: Path, place: Geodetic) -> ForecastWinds:
    winds = ForecastWinds(path, place)
    with _open_dataset(path) as data:
        parts: dict[Component, dict[str, Any]] = {component: {} for component in Component}
        for variable in data.data_vars.values():
            component = _component(variable)
            if component is not None:
                parts[component][str(variable.name)] = variable.assign_attrs({AXES_GRID: _grid(data, variable)})
            elif re.search(r"wind|gust", " ".join([str(variable.name), *_descriptions(variable)]).lower()):
                winds.note("variable that may be a wind", str(variable.name), next(iter(_descriptions(variable)), ""))
        pairs = (Component.EAST, Component.NORTH), (Component.SPEED, Component.FROM), (Component.SPEED, Component.TO)
        for component, partner in pairs:
            for name, first in [*parts[component].items()]:
                second = _partner(first, parts[partner].values())
                if second is None:
                    continue
                del parts[component][name], parts[partner][str(second.name)]
                for height, datum, pair in _levels(first, second, winds):
                    winds.samples.append(_samples(height, datum, pair, winds, partner))
        for group in _groups(path):
            winds.note("group of variables", group)
        for component, variables in parts.items():
            for name, variable in variables.items():
                may_limit = component in (Component.EAST, Component.NORTH) or not winds.samples
                winds.note(ALONE[component], name, next(iter(_descriptions(variable)), ""), may_limit)
    return winds


@contextmanager
def _open_dataset(path: Path) -> Iterator[Any]:
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
    h5py: Any = import_module("h5py")
    if not h5py.is_hdf5(path):
        return []
    with h5py.File(path) as data:
        return [name for name, value in data.items() if isinstance(value, h5py.Group)]


def _component(variable: Any) -> Component | None:
    standard = _standard_name(variable)
    if standard is not None:
        return STANDARD_COMPONENTS.get(standard)
    name = str(variable.name).lower()
    return next((component for pattern, component in COMPONENT_NAMES if pattern.fullmatch(name)), None)


def _standard_name(variable: Any) -> Any:
    standard = variable.attrs.get("standard_name")
    return None if standard in ("", "unknown") else standard


def _descriptions(variable: Any) -> list[str]:
    return [str(variable.attrs[key]) for key in ("standard_name", "long_name") if key in variable.attrs]


def _partner(first: Any, others: Iterable[Any]) -> Any | None:
    alike = [each for each in others if each.dims == first.dims and set(each.coords) == set(first.coords)]
    name = str(first.name)
    return max(alike, key=lambda each: SequenceMatcher(None, name, str(each.name)).ratio(), default=None)


@dataclass(frozen=True)
class _Heights:
    coordinate: Any
    values: Any = None
    datum: Datum = Datum.UNKNOWN
    has_no_unit: bool = False


def _levels(east: Any, north: Any, winds: ForecastWinds) -> Iterator[tuple[float, Datum, tuple[Any, Any]]]:
    """Yield levels by axis, height in the name, or coordinate of one value."""
    name = str(east.name)
    verticals = [heights for each in east.coords.values() if (heights := _heights(winds.path, each)) is not None]
    axes = [heights for heights in verticals if heights.coordinate.ndim]
    single = [heights for heights in verticals if not heights.coordinate.ndim]
    named = None if axes else _height_in_name(name, str(east.attrs.get("long_name", "")))
    if named is not None and all(heights.values is not None for heights in single):
        yield *named, (east, north)
        return
    known = [heights for heights in axes or single if heights.values is not None]
    if not known:
        level = verticals[0].coordinate if verticals else None
        subject = "wind at no height" if level is None else f"wind at {level.name}, which is no height"
        winds.note(subject, name, "" if level is None else level.attrs.get("units", ""))
        return
    heights = min(known, key=lambda heights: heights.datum is Datum.UNKNOWN)
    if heights.has_no_unit:
        winds.note("unit of a height, taken as m", str(heights.coordinate.name))
    along = next(iter(heights.coordinate.dims), None)
    for n, height in enumerate(np.atleast_1d(heights.values).tolist()):
        pair = (east, north) if along is None else (east.isel({along: n}), north.isel({along: n}))
        yield height, heights.datum, pair


def _heights(path: Path, coordinate: Any) -> _Heights | None:
    """Return heights; refuse unknown units, and heights that count downwards."""
    name = str(coordinate.name)
    attributes = coordinate.attrs
    standard = _standard_name(coordinate)
    if {"grid_mapping_name", "crs_wkt"} & attributes.keys():
        return None
    unit = attributes.get("units")
    is_axis = attributes.get("axis") == "Z"
    text = f"{name} {attributes.get('long_name', '')} {unit or ''}".lower()
    by_words = [datum for datum, words in DATUM_WORDS if words.search(text)]
    is_named = by_words or HEIGHT_AXIS.fullmatch(name.lower()) or "positive" in attributes
    if not (standard in STANDARD_DATUMS or (standard is None and is_named) or is_axis):
        return _Heights(coordinate) if _is_pressure(name, unit, standard) else None
    if standard is not None and standard not in STANDARD_DATUMS:
        return _Heights(coordinate)
    datum = _datum(name, standard, by_words)
    factor = 1.0
    if unit is None and datum is Datum.UNKNOWN:
        return _Heights(coordinate)  # probably level numbers
    if unit is not None:
        bare = re.sub(r"\s*\b(agl|amsl|asl|msl|above .*)$", "", str(unit), flags=re.IGNORECASE).strip()
        is_number = re.fullmatch(r"1|-|level|levels|layer|count|none|", bare, re.IGNORECASE)
        if is_number or _is_pressure(name, bare, standard):
            return _Heights(coordinate)
        factor = wind_levels.unit_factor(bare, "m", f"{path}: {name}.units")
    if attributes.get("positive") == "down":
        raise BadInput("expected heights that grow upwards, not positive = 'down'", place=f"{path}: {name}")
    if coordinate.ndim > 1:
        return _Heights(coordinate, None, datum)
    return _Heights(coordinate, np.asarray(coordinate, float) * factor, datum, unit is None)


def _height_in_name(name: str, long_name: str) -> tuple[float, Datum] | None:
    """Read u10 and the like; an unusual name must have the unit m."""
    match = re.fullmatch(r"\D*(\d+)_?(mabove\w*|m(?![a-z]))?\D*", name.lower())
    is_pressure = re.search(r"\d ?(hpa|mb|mbar|millibars?|pa)\b", f"{long_name}\n{name}".lower())
    if match is None or is_pressure:
        return None
    height = float(match[1])
    unit = match[2]
    is_usual = any(pattern.fullmatch(name) for pattern, _ in COMPONENT_NAMES)
    if unit is None and (height > 200 or not is_usual):  # u250 to u1000 are hPa
        return None
    return height, Datum.SEA if unit and "sea" in unit else Datum.GROUND


def _datum(name: str, standard: str | None, by_words: list[Datum]) -> Datum:
    if standard is not None:
        stated = STANDARD_DATUMS[standard]
        return stated if not by_words or stated in by_words else Datum.UNKNOWN  # contradictory
    if by_words:
        return by_words[0] if len(by_words) == 1 else Datum.UNKNOWN
    return Datum.GROUND if re.fullmatch(r"heights?(_?\d+)?|z?agl", name.lower()) else Datum.UNKNOWN


def _is_pressure(name: str, unit: Any, standard: str | None) -> bool:
    if standard == "air_pressure" or re.search(r"isobaric|plev|pressure", name.lower()):
        return True
    return bool(re.fullmatch(r"(h|k|d)?pa|mb|millibars?|mbar|pascals?|hectopascals?", str(unit or "").lower()))


def _samples(
    height: float, datum: Datum, pair: tuple[Any, Any], winds: ForecastWinds, second: Component
) -> wind_levels.WindSamples:
    values = []
    for variable, target in zip(pair, ("m/s", "m/s" if second is Component.NORTH else "deg"), strict=True):
        unit = variable.attrs.get("units")
        if unit is None:
            winds.note(f"unit of a wind, taken as {target}", str(variable.name))
            unit = target
        factor = wind_levels.unit_factor(str(unit), target, f"{winds.path}: {variable.name}.units")
        at_home, axis_deg = _at_place(variable, winds)
        times, at_home = _valid_times(at_home, winds.path)
        values.append(np.asarray(at_home, float).ravel() * factor)
    if second is not Component.NORTH:
        values = [*wind_levels.towards(-values[0] if second is Component.TO else values[0], values[1])]
    components = np.stack(values, axis=-1)
    if axis_deg is not None:
        components = wind_levels.to_east_north(components, axis_deg)
    return wind_levels.WindSamples(height, datum, components, times)


def _grid(data: Any, variable: Any) -> CRS | tuple[float, float] | None:
    """Return the projection of a component along a grid's axes, or its rotated pole (CF); None if unknown."""
    mapping = data.variables.get(str(variable.attrs.get("grid_mapping", "")).partition(":")[0])
    kind = None if mapping is None else mapping.attrs.get("grid_mapping_name")
    if variable.attrs.get("standard_name") not in ALONG_AXES or kind in (None, "latitude_longitude"):
        return None
    with suppress(CRSError, KeyError, TypeError, ValueError):
        if kind == "rotated_latitude_longitude":
            return float(mapping.attrs["grid_north_pole_latitude"]), float(mapping.attrs["grid_north_pole_longitude"])
        return CRS.from_cf(mapping.attrs)
    return None


def _at_place(variable: Any, winds: ForecastWinds) -> tuple[Any, float | None]:
    """Return the value at the nearest point, and the direction of the y axis for a component along the axes."""
    latitude, longitude = (_degrees(variable, kind, winds.path) for kind in ("latitude", "longitude"))
    relative = variable.attrs.get("GRIB_uvRelativeToGrid")
    is_named = variable.attrs.get("standard_name") in GEOGRAPHIC
    # cfgrib calls winds along the axes eastward, too
    is_along = relative == 1 and variable.attrs.get("GRIB_gridType") != "mercator" if is_named else relative != 0
    is_along = is_along and latitude.ndim == 2 and _component(variable) in (Component.EAST, Component.NORTH)
    grid = variable.attrs.get(AXES_GRID)
    if is_along and grid is None:
        raise BadInput(
            "expected a wind towards the east or the north, not along the axes "
            f"{', '.join(map(str, latitude.dims))} of a turned grid",
            hint=f"set standard_name to {' or '.join(GEOGRAPHIC)}, and any GRIB_uvRelativeToGrid to 0; or to "
            f"{' or '.join(ALONG_AXES)}, with a grid_mapping; or take the GRIB file",
            place=f"{winds.path}: {variable.name}",
        )
    latitude, longitude = latitude.broadcast_like(longitude), longitude.broadcast_like(latitude)
    longitude = longitude.transpose(*latitude.dims)
    n, *point = wind_levels.nearest_point(latitude.values.ravel(), longitude.values.ravel(), winds)
    nearest = dict(zip(latitude.dims, np.unravel_index(n, latitude.shape), strict=True))
    return variable.isel(nearest), None if grid is None or not is_along else wind_levels.grid_north(grid, *point)


def _degrees(variable: Any, kind: str, path: Path) -> Any:
    for name, coordinate in variable.coords.items():
        standard = coordinate.attrs.get("standard_name")
        unit = coordinate.attrs.get("units", "degrees")
        is_named = standard == kind or (standard is None and str(name).lower() in (kind, kind[:3]))
        if is_named and str(unit).lower().startswith("deg"):
            return variable[name].astype(float)
    words = f"expected latitudes and longitudes [degrees] of a wind by {', '.join(map(str, variable.dims))}"
    raise BadInput(words, place=f"{path}: {variable.name}")


def _valid_times(variable: Any, path: Path) -> tuple[np.ndarray, Any]:
    times = _time_of(variable)
    known = {str(name) for name in (times.dims if times is not None else ())}
    strange = [str(name) for name in variable.dims if str(name) not in known and not _is_member(variable, str(name))]
    if strange:
        words = f"expected winds by height, member and time, not by {', '.join(strange)}"
        raise BadInput(words, place=f"{path}: {variable.name}")
    if times is None:
        return np.full(variable.size, np.datetime64("NaT", "s")), variable
    if times.dtype.kind != "M":
        raise BadInput("expected times of the usual calendar, with their unit", place=f"{path}: {times.name}")
    times, variable = times.broadcast_like(variable), variable.broadcast_like(times)
    return np.asarray(times.transpose(*variable.dims)).astype("datetime64[s]").ravel(), variable


def _time_of(variable: Any) -> Any | None:
    by_standard = {each.attrs.get("standard_name"): each for each in variable.coords.values()}
    by_name = {str(name).lower(): each for name, each in variable.coords.items()}
    names = ("step", "lead_time", "leadtime", "forecast_period", "prediction_timedelta")
    leads = (by_standard.get("forecast_period"), *map(by_name.get, names))
    lead = next((each for each in leads if each is not None), None)
    is_lead = lead is not None and lead.dtype.kind == "m"
    for valid in (by_name.get("valid_time"), by_standard.get("time"), by_name.get("time")):
        if valid is not None and valid.attrs.get("standard_name", "time") == "time":
            alone = lead is None or not lead.dims or bool(set(lead.dims) & set(valid.dims))
            return valid if alone or not is_lead else valid + lead
    run = by_standard.get("forecast_reference_time")
    return run if run is None or not is_lead else run + lead


def _is_member(variable: Any, name: str) -> bool:
    standard = variable[name].attrs.get("standard_name") if name in variable.coords else None
    names = {"number", "member", "ens", "ensemble", "ensemble_member", "realization"}
    return name.lower() in names or standard == "realization" or variable.sizes[name] == 1
