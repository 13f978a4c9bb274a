"""Read the wind of a forecast (NetCDF or GRIB) as a profile above home."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipoa_mission.errors import BadInput, NotCovered, NothingThere
from ipoa_mission.files import read_bytes
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Plane
from ipoa_mission.maps.geoid import undulation
from ipoa_mission.maps.grib_winds import grib_winds
from ipoa_mission.maps.netcdf_winds import netcdf_winds
from ipoa_mission.maps.wind_levels import Datum, ForecastWind, ForecastWinds, Times, WindSamples
from ipoa_mission.unread import gathered
from ipoa_mission.wind import MAX_LEVELS, Wind

FLIGHT_DURATION = np.timedelta64(1, "h")  # as for zones
HIGHEST = 500.0  # above home [m]; one level above is read


def read_wind(path: Path, place: Geodetic, time: np.datetime64 | None) -> ForecastWind:
    """Return the wind from a time (UTC) on; `spread` is the greatest deviation of a member or hour.

    For heights of an unknown datum the one with the stronger wind counts.
    """
    is_grib = read_bytes(path, 4) == b"GRIB" or path.suffix.lower() in (".grib", ".grb", ".grib2", ".grb2")
    winds = grib_winds(path, place) if is_grib else netcdf_winds(path, place)
    if not winds.samples:
        unread = "".join(f"\n{thing.words}" for thing in gathered(winds.unread))
        words = "expected winds (east and north, or speed and direction) at heights in meters"
        raise BadInput(f"{words}{unread}", place=path)
    is_unknown = any(level.datum is Datum.UNKNOWN for level in winds.samples)
    assumed = (Datum.GROUND, Datum.SEA) if is_unknown else (Datum.GROUND,)
    strongest = max((_profile(winds, time, datum) for datum in assumed), key=_strength)
    return replace(strongest, unread=gathered((*winds.unread, *strongest.unread)))


def _strength(forecast: ForecastWind) -> tuple[float, float]:
    speeds = [forecast.wind.speed_at(height) + forecast.wind.spread for height in range(0, 160, 10)]
    return max(speeds), float(np.mean(speeds))


def _profile(winds: ForecastWinds, time: np.datetime64 | None, unknown: Datum) -> ForecastWind:
    levels = dict[float, list[WindSamples]]()
    remarks = list[str]()
    notes = ForecastWinds(winds.path, winds.place)
    for samples in winds.samples:
        datum = unknown if samples.datum is Datum.UNKNOWN else samples.datum
        at_home = _home_above(datum, winds)
        levels.setdefault(round(samples.height - at_home, 2) + 0.0, []).append(samples)
        if samples.datum is Datum.UNKNOWN:
            remedy = "set standard_name to height (above ground) or altitude (above the geoid)"
            notes.note(f"datum of its heights, taken as {datum}: {remedy}", "wind", f"{samples.height:g}")
        elif datum is not Datum.GROUND:
            remarks.append(f"{winds.path.name}: heights above {datum} taken less home's {at_home:g} m")
    heights = _flown_levels(sorted(levels), notes)
    winds_at = {height: _winds_at_time(height, levels[height], time, notes) for height in heights}
    means = {height: members.mean(axis=0) for height, members in winds_at.items()}
    picked = [heights[n] for n in np.linspace(0, len(heights) - 1, min(len(heights), MAX_LEVELS)).round().astype(int)]
    blowing = [Wind.of_velocity(*map(float, means[height])) for height in picked]
    wind = blowing[0]
    if len(picked) > 1:
        wind = Wind.of_profile(picked, [level.speed for level in blowing], [level.from_deg for level in blowing])
    means |= {height: np.array(wind.velocity(height)) for height in heights if height not in picked}
    spread = max(float(np.hypot(*(members - means[height]).T).max()) for height, members in winds_at.items())
    return ForecastWind(replace(wind, spread=spread), tuple(dict.fromkeys(remarks)), tuple(notes.unread))


def _home_above(datum: Datum, winds: ForecastWinds) -> float:
    if datum is Datum.GROUND:
        return 0.0
    home = winds.place
    if datum is Datum.SEA:
        return home.altitude
    try:
        return home.altitude + undulation(home.latitude_deg, home.longitude_deg, None, winds.path)[0]
    except BadInput as error:
        hint = "give the file heights above the ground or the geoid, or get the grid by `pyproj sync`"
        raise error.at(hint=hint) from error


def _flown_levels(heights: list[float], notes: ForecastWinds) -> list[float]:
    above = [height for height in heights if height >= 0]
    if not above:
        home = f"home, which is at {notes.place.altitude:g} m"
        raise NotCovered(f"expected winds above {home}; the highest are {-heights[-1]:g} m below it", place=notes.path)
    notes.note("wind below the ground at home", "height", f"{heights[0]:g}", count=len(heights) - len(above))
    flown = above[: sum(height < HIGHEST for height in above) + 1]
    if len(flown) < len(above):
        subject = f"wind more than {flown[-1]:g} m above home"
        notes.note(subject, "height", f"{above[len(flown)]:g}", count=len(above) - len(flown))
    return flown


def _winds_at_time(
    height: float, samples: Sequence[WindSamples], time: np.datetime64 | None, notes: ForecastWinds
) -> Plane:
    winds = np.concatenate([s.winds for s in samples])
    times = np.concatenate([s.times for s in samples])
    undated = np.isnat(times)
    if undated.any():
        notes.note("time of a wind, taken as the flight's", f"{height:g} m up")
    if not undated.all():
        winds = winds[undated | np.isin(times, _hours(np.unique(times[~undated]), time, notes.path))]
    known = winds[np.isfinite(winds).all(axis=1)]
    if not len(known):
        words = f"expected a wind at home, but there is none at the nearest point, {height:g} m up"
        raise NothingThere(words, place=notes.path)
    subject = f"wind of a member or time: {len(known)} others count"
    notes.note(subject, f"{height:g} m up", "missing", count=len(winds) - len(known))
    strongest = np.abs(known).max()
    if strongest > 150.0:  # [m/s], at a height without jet streams
        raise BadInput(f"expected winds, not {strongest:g} m/s, {height:g} m up", code="winds-absurd", place=notes.path)
    return np.asarray(known)


def _hours(times: Times, time: np.datetime64 | None, path: Path) -> Times:
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
