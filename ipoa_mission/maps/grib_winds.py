import re
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ipoa_mission.errors import BadInput, NotCovered, NothingThere, Unreadable, WrongFormat, imported
from ipoa_mission.maps.units import unit_factor
from ipoa_mission.maps.wind_levels import FARTHEST_DEG, Datum, ForecastWinds, WindSamples, grid_north, to_east_north
from ipoa_mission.world.frame import Geodetic

EAST, NORTH, SPEED, FROM = "east", "north", "speed", "from"
NAMED = re.compile(r"(\d*)(u|v|si|ws|wdir)")  # eccodes' shortName: u, 10u, 100v, 10si, wdir
SHORT_NAMES = {"u": EAST, "v": NORTH, "si": SPEED, "ws": SPEED, "wdir": FROM}
NUMBERS = {0: FROM, 1: SPEED, 2: EAST, 3: NORTH}  # GRIB 2: discipline 0, category 2
MOMENTUM = (0, 2)
DATUMS = {"heightAboveGround": Datum.GROUND, "heightAboveSea": Datum.SEA}
# Axes to east and north.
NORTH_UP = ("regular_ll", "regular_gg", "reduced_ll", "reduced_gg", "mercator", "unstructured_grid")
PLAIN = {0, 1}  # templates: one forecast, one member
ALONG_AXES = 8  # of resolutionAndComponentFlags
MEAN = {0, 1}  # means of members


Nearest: TypeAlias = tuple[int, float, float]  # number of a grid point, its latitude and longitude [deg]
KnownPoints: TypeAlias = dict[str, Nearest]  # by grid


@dataclass(frozen=True)
class _Message:
    part: str
    height: float
    datum: Datum
    time: np.datetime64
    member: int
    value: float
    axis_deg: float | None  # of the grid's y axis, for a component along it


def grib_winds(path: Path, place: Geodetic) -> ForecastWinds:
    eccodes = imported("eccodes", f"{path}: a forecast of winds needs eccodes", "wind")
    found, nearest = ForecastWinds(path.name), KnownPoints()
    axes = dict[tuple[float, Datum, np.datetime64, int], float]()
    parts = defaultdict[tuple[float, Datum, np.datetime64, int], dict[str, list[float]]](lambda: defaultdict(list))
    for number, handle in enumerate(_messages(eccodes, path), 1):
        message = _read(eccodes, handle, path, f"message {number}", place, nearest, found)
        if message is not None:
            key = (message.height, message.datum, message.time, message.member)
            parts[key][message.part].append(message.value)
            if message.axis_deg is not None:
                axes[key] = message.axis_deg
    levels = defaultdict[tuple[float, Datum], list[tuple[np.datetime64, float, float]]](list)
    members = defaultdict[tuple[float, Datum, np.datetime64], set[int]](set)
    for (height, datum, time, member), both in parts.items():
        pairs = list(zip(both[EAST], both[NORTH], strict=False))
        if odd := len(both[EAST]) + len(both[NORTH]) - 2 * len(pairs):
            found.note("one component of a wind without the other", f"{height:g} m", str(time), True, odd)
        if pairs and (height, datum, time, member) in axes:
            pairs = to_east_north(np.array(pairs), axes[height, datum, time, member]).tolist()
        if not pairs:  # components take precedence
            polar = [*zip(both[SPEED], np.radians(both[FROM]), strict=False)]
            pairs = [(-speed * np.sin(angle), -speed * np.cos(angle)) for speed, angle in polar]
            if odd := len(both[SPEED]) + len(both[FROM]) - 2 * len(pairs):
                found.note("speed or direction of a wind without the other", f"{height:g} m", str(time), True, odd)
        if pairs:
            levels[height, datum] += [(time, *pair) for pair in pairs]
            members[height, datum, time].add(member)
    most = max(map(len, members.values()), default=0)
    if gaps := sum(len(each) < most for each in members.values()):
        what = f"members: {most} at some levels and times, fewer at {gaps} of {len(members)}"
        first = next(key for key, each in members.items() if len(each) < most)
        found.note(what, f"{first[0]:g} m, {first[2]}", len(members[first]))
    for (height, datum), rows in levels.items():
        winds = np.array([row[1:] for row in rows], float).reshape(-1, 2)
        found.samples.append(WindSamples(height, datum, winds, np.array([row[0] for row in rows])))
    return found


@contextmanager
def _several_fields(eccodes: Any) -> Iterator[None]:
    """Allow several fields in a message (NCEP)."""
    eccodes.codes_grib_multi_support_on()
    try:
        yield
    finally:
        eccodes.codes_grib_multi_support_off()


def _messages(eccodes: Any, path: Path) -> Iterator[Any]:
    count = 0
    try:
        with path.open("rb") as file, _several_fields(eccodes):
            while (handle := eccodes.codes_grib_new_from_file(file)) is not None:
                count += 1
                try:
                    yield handle
                finally:
                    eccodes.codes_release(handle)
    except eccodes.CodesInternalError as error:
        words = f"expected a forecast of winds in GRIB: {error}"
        raise WrongFormat(words, place=f"{path}: message {count + 1}") from error
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error
    if not count:
        raise NothingThere("expected a forecast of winds in GRIB, but the file has no message", place=path)


def _read(
    eccodes: Any, handle: Any, path: Path, where: str, place: Geodetic, nearest: KnownPoints, found: ForecastWinds
) -> _Message | None:
    def get(key: str, kind: type = str) -> Any:
        return eccodes.codes_get(handle, key, kind) if eccodes.codes_is_defined(handle, key) else None

    short, level_type = get("shortName"), get("typeOfLevel")
    named = NAMED.fullmatch(short)
    if get("edition", int) == 2:
        numbers = get("discipline", int), get("parameterCategory", int)
        part = NUMBERS.get(get("parameterNumber", int)) if numbers == MOMENTUM else None
        is_wind = numbers == MOMENTUM
    else:
        part = None if named is None else SHORT_NAMES[named[2]]
        is_wind = part is not None or "wind" in get("name").lower() or "gust" in get("name").lower()
    if part is None:
        if is_wind:
            found.note(f"{get('name')} at {level_type}", where, get("level"))
        return None
    above_ground = named is not None and named[1] and level_type == "surface"  # ECMWF's 10 m wind in GRIB 1
    datum = Datum.GROUND if above_ground else DATUMS.get(level_type)
    if datum is None:
        found.note(f"wind at {level_type}, which is no height", where, get("level"))
        return None
    if why := _no_single_forecast(get):
        found.note(f"{get('name')}, {why}", where, get("level"))
        return None
    index, *at = _nearest(eccodes, handle, path, place, nearest)
    # eccodes has no uvRelativeToGrid of polar stereographic and Lambert azimuthal grids
    is_along = get("uvRelativeToGrid", int) or (get("resolutionAndComponentFlags", int) or 0) & ALONG_AXES
    is_turned = part in (EAST, NORTH) and is_along and get("gridType") not in NORTH_UP
    axis_deg = grid_north(_grid(eccodes, get, path), *at) if is_turned else None
    unit = get("units")
    target = "deg" if part == FROM else "m/s"
    unit = {"Degree true": "deg"}.get(unit, unit)
    factor = 1.0 if unit in (None, "unknown") else unit_factor(unit, target, f"{path}: {short}.units")
    value = eccodes.codes_get_double_element(handle, "values", index)
    missing = bool(get("bitmapPresent", int)) and value == get("missingValue", float)
    height = float(named[1]) if above_ground and named is not None else get("level", float)
    return _Message(
        part, height, datum, _valid(get), get("number", int) or 0, np.nan if missing else value * factor, axis_deg
    )


def _grid(eccodes: Any, get: Any, path: Path) -> str | tuple[float, float]:
    """Return a grid's projection, or the north pole of its axes."""
    if get("gridType") == "rotated_ll" and not get("angleOfRotationInDegrees", float):
        return -get("latitudeOfSouthernPoleInDegrees", float), get("longitudeOfSouthernPoleInDegrees", float) + 180.0
    with suppress(eccodes.CodesInternalError):
        if projection := get("projTargetString"):
            return str(projection)
    words = f"expected winds towards the east and the north, not along the axes of a {get('gridType')} grid"
    raise BadInput(words, hint="turn them first, as `wgrib2 IN -new_grid_winds earth` does", place=path)


def _no_single_forecast(get: Any) -> str:
    """Describe averages, spreads and percentiles."""
    if get("stepType") not in (None, "instant"):
        return f"its {get('stepType')} over a time"
    template = get("productDefinitionTemplateNumber", int)
    if template in (None, *PLAIN) or get("derivedForecast", int) in MEAN:
        return ""
    return f"by product template {template}"


def _valid(get: Any) -> np.datetime64:
    date, clock = get("validityDate", int), get("validityTime", int)
    day = np.datetime64(f"{date // 10000:04d}-{date // 100 % 100:02d}-{date % 100:02d}", "s")
    return day + np.timedelta64(clock // 100 * 60 + clock % 100, "m")


def _nearest(eccodes: Any, handle: Any, path: Path, place: Geodetic, known: KnownPoints) -> Nearest:
    grid = eccodes.codes_get(handle, "md5GridSection")
    if grid not in known:
        latitudes, longitudes = (eccodes.codes_get_array(handle, key) for key in ("latitudes", "longitudes"))
        north = np.abs(latitudes - place.latitude_deg)
        east = np.abs((longitudes - place.longitude_deg + 180.0) % 360.0 - 180.0)
        index = int(np.hypot(north, east * np.cos(np.radians(place.latitude_deg))).argmin())
        if max(north[index], east[index]) > FARTHEST_DEG:
            raise NotCovered(
                f"expected a forecast of home's place, {place.latitude_deg:g}, {place.longitude_deg:g}; "
                f"the nearest point is {latitudes[index]:g}, {(longitudes[index] + 180.0) % 360.0 - 180.0:g}",
                place=path,
            )
        known[grid] = index, float(latitudes[index]), float(longitudes[index])
    return known[grid]
