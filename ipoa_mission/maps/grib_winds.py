import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ipoa_mission.errors import BadInput, NothingThere, WrongFormat, imported
from ipoa_mission.files import reading
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.maps import wind_levels
from ipoa_mission.maps.wind_levels import Component, Datum, ForecastWinds, WindSamples

SHORT_NAME = re.compile(r"(\d*)(u|v|si|ws|wdir)")  # of eccodes: u, 10u, 100v, 10si, wdir
SHORT_NAMES = {
    "u": Component.EAST,
    "v": Component.NORTH,
    "si": Component.SPEED,
    "ws": Component.SPEED,
    "wdir": Component.FROM,
}
# GRIB 2, of discipline 0 and category 2.
WIND_PARAMETERS = {0: Component.FROM, 1: Component.SPEED, 2: Component.EAST, 3: Component.NORTH}
ALONG_AXES = 8  # of resolutionAndComponentFlags

Nearest: TypeAlias = tuple[int, float, float]  # number of a grid point, its latitude and longitude [deg]


class _Moment(NamedTuple):
    height: float
    datum: Datum
    time: np.datetime64
    member: int


def grib_winds(path: Path, place: Geodetic) -> ForecastWinds:
    eccodes = imported("eccodes", f"{path}: a forecast of winds needs eccodes", "wind")
    winds = ForecastWinds(path, place)
    nearest = dict[str, Nearest]()
    axes = dict[_Moment, float]()
    parts = defaultdict[_Moment, dict[Component, list[float]]](lambda: defaultdict(list))
    for number, handle in enumerate(_messages(eccodes, path), 1):
        for moment, component, value, axis_deg in _read(eccodes, handle, f"message {number}", winds, nearest):
            parts[moment][component].append(value)
            if axis_deg is not None:
                axes[moment] = axis_deg

    members = defaultdict[tuple[float, Datum, np.datetime64], set[int]](set)
    for moment, values in parts.items():
        samples = _samples(moment, values, axes.get(moment), winds)
        if len(samples.winds):
            winds.samples.append(samples)
            members[moment.height, moment.datum, moment.time].add(moment.member)
    most = max(map(len, members.values()), default=0)
    fewer = {key: len(numbers) for key, numbers in members.items() if len(numbers) < most}
    if fewer:
        subject = f"members: {most} at some levels and times, fewer at {len(fewer)} of {len(members)}"
        (height, _, time), count = next(iter(fewer.items()))
        winds.note(subject, f"{height:g} m, {time}", count)
    return winds


def _samples(
    moment: _Moment, values: Mapping[Component, list[float]], axis_deg: float | None, winds: ForecastWinds
) -> WindSamples:
    east, north, speeds, directions = (values.get(component, []) for component in list(Component)[:4])
    where = (f"{moment.height:g} m", str(moment.time), True)
    pairs = list(zip(east, north, strict=False))
    winds.note("one component of a wind without the other", *where, len(east) + len(north) - 2 * len(pairs))
    if pairs and axis_deg is not None:
        pairs = wind_levels.to_east_north(np.array(pairs), axis_deg).tolist()
    if not pairs:
        pairs = [wind_levels.towards(*polar) for polar in zip(speeds, directions, strict=False)]
        odd = len(speeds) + len(directions) - 2 * len(pairs)
        winds.note("speed or direction of a wind without the other", *where, odd)
    components = np.array(pairs, float).reshape(-1, 2)
    return WindSamples(moment.height, moment.datum, components, np.full(len(pairs), moment.time))


def _messages(eccodes: Any, path: Path) -> Iterator[Any]:
    count = 0
    eccodes.codes_grib_multi_support_on()  # several fields in a message (NCEP)
    try:
        with reading(path), path.open("rb") as file:
            while (handle := eccodes.codes_grib_new_from_file(file)) is not None:
                count += 1
                try:
                    yield handle
                finally:
                    eccodes.codes_release(handle)
    except eccodes.CodesInternalError as error:
        words = f"expected a forecast of winds in GRIB: {error}"
        raise WrongFormat(words, place=f"{path}: message {count + 1}") from error
    finally:
        eccodes.codes_grib_multi_support_off()
    if not count:
        raise NothingThere("expected a forecast of winds in GRIB, but the file has no message", place=path)


def _read(
    eccodes: Any, handle: Any, where: str, winds: ForecastWinds, nearest: dict[str, Nearest]
) -> Iterator[tuple[_Moment, Component, float, float | None]]:
    """Yield a component [m/s, deg], and the y axis' direction if along the axes."""

    def get(key: str, kind: type = str) -> Any:
        return eccodes.codes_get(handle, key, kind) if eccodes.codes_is_defined(handle, key) else None

    name = get("shortName")
    level_type = get("typeOfLevel")
    short = SHORT_NAME.fullmatch(name)
    if get("edition", int) == 2:
        is_wind = (get("discipline", int), get("parameterCategory", int)) == (0, 2)
        component = WIND_PARAMETERS.get(get("parameterNumber", int)) if is_wind else None
    else:
        component = None if short is None else SHORT_NAMES[short[2]]
        is_wind = component is not None or "wind" in get("name").lower() or "gust" in get("name").lower()
    if component is None:
        if is_wind:
            winds.note(f"{get('name')} at {level_type}", where, get("level"))
        return
    above_ground = short is not None and short[1] and level_type == "surface"  # ECMWF's 10 m wind in GRIB 1
    data = {"heightAboveGround": Datum.GROUND, "heightAboveSea": Datum.SEA}
    datum = Datum.GROUND if above_ground else data.get(level_type)
    if datum is None:
        winds.note(f"wind at {level_type}, which is no height", where, get("level"))
        return
    aggregation = _aggregation(get)
    if aggregation:
        winds.note(f"{get('name')}, {aggregation}", where, get("level"))
        return
    grid = get("md5GridSection")
    if grid not in nearest:
        latitudes, longitudes = (eccodes.codes_get_array(handle, key) for key in ("latitudes", "longitudes"))
        nearest[grid] = wind_levels.nearest_point(latitudes, longitudes, winds)
    index, *place = nearest[grid]
    axis_deg = _axis_deg(eccodes, get, winds.path, *place) if component in (Component.EAST, Component.NORTH) else None
    target = "deg" if component is Component.FROM else "m/s"
    unit = get("units")
    unit = "deg" if unit == "Degree true" else unit
    factor = 1.0 if unit in (None, "unknown") else wind_levels.unit_factor(unit, target, f"{winds.path}: {name}.units")
    value = eccodes.codes_get_double_element(handle, "values", index)
    missing = bool(get("bitmapPresent", int)) and value == get("missingValue", float)
    height = float(short[1]) if above_ground and short is not None else get("level", float)
    moment = _Moment(height, datum, _valid_time(get), get("number", int) or 0)
    yield moment, component, np.nan if missing else value * factor, axis_deg


def _axis_deg(eccodes: Any, get: Any, path: Path, latitude_deg: float, longitude_deg: float) -> float | None:
    # eccodes has no uvRelativeToGrid of polar stereographic and Lambert azimuthal grids
    is_along = get("uvRelativeToGrid", int) or (get("resolutionAndComponentFlags", int) or 0) & ALONG_AXES
    kind = get("gridType")
    north_up = "regular_ll regular_gg reduced_ll reduced_gg mercator unstructured_grid"
    if not is_along or kind in north_up.split():
        return None
    if kind == "rotated_ll" and not get("angleOfRotationInDegrees", float):
        south = get("latitudeOfSouthernPoleInDegrees", float), get("longitudeOfSouthernPoleInDegrees", float)
        return wind_levels.grid_north((-south[0], south[1] + 180.0), latitude_deg, longitude_deg)
    with suppress(eccodes.CodesInternalError):
        projection = get("projTargetString")
        if projection:
            return wind_levels.grid_north(str(projection), latitude_deg, longitude_deg)
    words = f"expected winds towards the east and the north, not along the axes of a {kind} grid"
    raise BadInput(words, hint="turn them first, as `wgrib2 IN -new_grid_winds earth` does", place=path)


def _aggregation(get: Any) -> str:
    if get("stepType") not in (None, "instant"):
        return f"its {get('stepType')} over a time"
    template = get("productDefinitionTemplateNumber", int)
    is_single = template in (None, 0, 1) or get("derivedForecast", int) in (0, 1)
    return "" if is_single else f"by product template {template}"


def _valid_time(get: Any) -> np.datetime64:
    date = str(get("validityDate", int)).zfill(8)
    clock = get("validityTime", int)
    day = np.datetime64(f"{date[:4]}-{date[4:6]}-{date[6:]}", "s")
    return day + np.timedelta64(clock // 100 * 60 + clock % 100, "m")
