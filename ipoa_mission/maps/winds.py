"""Wind from a forecast (NetCDF or GRIB): a profile above home."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipoa_mission.errors import BadInput, NotCovered, NothingThere, Unreadable
from ipoa_mission.geometry import Points
from ipoa_mission.maps.geoid import undulation
from ipoa_mission.maps.grib_winds import grib_winds
from ipoa_mission.maps.netcdf_winds import netcdf_winds
from ipoa_mission.maps.wind_levels import STRONGEST, Datum, ForecastWind, ForecastWinds, Times, WindSamples
from ipoa_mission.unread import gathered
from ipoa_mission.wind import MAX_LEVELS, Wind
from ipoa_mission.world.frame import Geodetic

FLIGHT_DURATION = np.timedelta64(1, "h")  # as for zones
USUAL = range(0, 160, 10)  # [m]
HIGHEST = 500.0  # above home [m]; one level above is read
DATUM_REMEDY = "set standard_name to height (above ground) or altitude (above the geoid)"
DIGITS = 2  # of heights


def read_wind(path: Path, place: Geodetic, time: np.datetime64 | None) -> ForecastWind:
    """Return the wind from a time (UTC) on; `spread` is the greatest deviation of a member or hour."""
    found = grib_winds(path, place) if _is_grib(path) else netcdf_winds(path, place)
    if not found.samples:
        unread = "".join(f"\n{thing.words}" for thing in gathered(found.unread))
        words = "expected winds (east and north, or speed and direction) at heights in meters"
        raise BadInput(f"{words}{unread}", place=path)
    is_unknown = any(each.datum is Datum.UNKNOWN for each in found.samples)
    if not is_unknown:
        chosen = _profile(path, found, place, time, Datum.GROUND)
    else:
        chosen = max((_profile(path, found, place, time, each) for each in (Datum.GROUND, Datum.SEA)), key=_disturbance)
    return replace(chosen, unread=gathered((*found.unread, *chosen.unread)))


def _disturbance(forecast: ForecastWind) -> tuple[float, float]:
    speeds = [forecast.wind.at(height) + forecast.wind.spread for height in USUAL]
    return max(speeds), float(np.mean(speeds))


def _is_grib(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(4) == b"GRIB" or path.suffix.lower() in (".grib", ".grb", ".grib2", ".grb2")
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", place=path) from error


def _profile(
    path: Path, found: ForecastWinds, place: Geodetic, time: np.datetime64 | None, unknown: Datum
) -> ForecastWind:
    levels = dict[float, list[WindSamples]]()
    remarks, notes = list[str](), ForecastWinds(path.name)
    for each in found.samples:
        datum = unknown if each.datum is Datum.UNKNOWN else each.datum
        at_home = _datum_at_home(path, datum, place)
        levels.setdefault(round(each.height - at_home, DIGITS) + 0.0, []).append(each)
        if each.datum is Datum.UNKNOWN:
            notes.note(f"datum of its heights, taken as {datum}: {DATUM_REMEDY}", "wind", f"{each.height:g}")
        elif datum is not Datum.GROUND:
            remarks.append(f"{path.name}: heights above {datum} taken less home's {at_home:g} m")
    kept = _flown_levels(path, sorted(levels), place, notes)
    blowing = {height: _winds_at_time(path, height, levels[height], time, notes) for height in kept}
    means = {height: winds.mean(axis=0) for height, winds in blowing.items()}
    picked = [kept[n] for n in np.linspace(0, len(kept) - 1, min(len(kept), MAX_LEVELS)).round().astype(int)]
    towards = [Wind.towards_north_east(float(means[height][1]), float(means[height][0])) for height in picked]
    wind = Wind(towards[0].speed, towards[0].from_deg)
    if len(picked) > 1:
        wind = Wind.of_profile(picked, [one.speed for one in towards], [one.from_deg for one in towards])
    between = {height: np.array(wind.towards(height)) for height in kept if height not in picked}
    apart = (winds - (means | between)[height] for height, winds in blowing.items())
    spread = max(float(np.hypot(*each.T).max()) for each in apart)
    return ForecastWind(replace(wind, spread=spread), tuple(dict.fromkeys(remarks)), tuple(notes.unread))


def _datum_at_home(path: Path, datum: Datum, place: Geodetic) -> float:
    """Return height above a datum [m]."""
    if datum is Datum.GROUND:
        return 0.0
    if datum is Datum.SEA:
        return place.altitude
    try:
        return place.altitude + undulation(place.latitude_deg, place.longitude_deg, None, path)[0]
    except BadInput as error:
        hint = "give the file heights above the ground or the geoid, or get the grid by `pyproj sync`"
        raise error.at(hint=hint) from error


def _flown_levels(path: Path, heights: list[float], place: Geodetic, notes: ForecastWinds) -> list[float]:
    """Return the levels up to the first one above `HIGHEST`."""
    above = [height for height in heights if height >= 0]
    if not above:
        raise NotCovered(
            f"expected winds above home, which is at {place.altitude:g} m; the highest are {-heights[-1]:g} m below it",
            place=path,
        )
    if len(above) < len(heights):
        notes.note("wind below the ground at home", "height", f"{heights[0]:g}", count=len(heights) - len(above))
    low = [height for height in above if height < HIGHEST]
    kept = above[: len(low) + 1]
    if len(kept) < len(above):
        what = f"wind more than {kept[-1]:g} m above home"
        notes.note(what, "height", f"{above[len(kept)]:g}", count=len(above) - len(kept))
    return kept


def _winds_at_time(
    path: Path, height: float, samples: Sequence[WindSamples], time: np.datetime64 | None, notes: ForecastWinds
) -> Points:
    winds, times = np.concatenate([s.winds for s in samples]), np.concatenate([s.times for s in samples])
    undated = np.isnat(times)
    if undated.any():
        notes.note("time of a wind, taken as the flight's", f"{height:g} m up")
    if not undated.all():
        chosen = _hours(path, np.unique(times[~undated]), time)
        winds = winds[undated | np.isin(times, chosen)]
    there = np.isfinite(winds).all(axis=1)
    if not there.any():
        words = f"expected a wind at home, but there is none at the nearest point, {height:g} m up"
        raise NothingThere(words, place=path)
    if gaps := int((~there).sum()):
        what = f"wind of a member or time: {len(winds) - gaps} others count"
        notes.note(what, f"{height:g} m up", "missing", count=gaps)
    if (strange := np.abs(winds[there]).max()) > STRONGEST:
        raise BadInput(f"expected winds, not {strange:g} m/s, {height:g} m up", code="winds-absurd", place=path)
    return np.asarray(winds[there])


def _hours(path: Path, times: Times, time: np.datetime64 | None) -> Times:
    """Return the last time before the flight, those during it, the first after it."""
    if time is None:
        if len(times) == 1:
            return times
        words = f"expected `time` in the scenario, for a forecast of {len(times)} times"
        raise BadInput(words, code="time-missing", place=path)
    begin = time.astype("datetime64[s]")
    if begin + FLIGHT_DURATION < times[0] or begin - FLIGHT_DURATION > times[-1]:
        words = f"expected a forecast for {begin}, not of {times[0]} to {times[-1]}"
        raise BadInput(words, code="time-not-covered", place=path)
    first = int(np.searchsorted(times, begin, side="right")) - 1
    last = int(np.searchsorted(times, begin + FLIGHT_DURATION, side="left"))
    return times[max(first, 0) : min(last, len(times) - 1) + 1]
