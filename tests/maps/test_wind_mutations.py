from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.maps import netcdf_winds
from ipoa_mission.maps.winds import read_wind

xarray = pytest.importorskip("xarray")
HOME = Geodetic(47.4, 8.5, 488.0)
TEN = np.datetime64("2026-11-22T10:00")
HEIGHTS, SPEEDS = np.array([10.0, 60.0, 120.0, 300.0]), np.array([3.0, 6.0, 9.0, 14.0])
USUAL = range(0, 160, 10)

SPEED_UNITS = {"m s-1": 1.0, "m/s": 1.0, "knots": 1852 / 3600, "km/h": 1 / 3.6, "mph": 0.44704, "ft/s": 0.3048,
               "beaufort": 1.0, None: 1.0, "K": 1.0}  # fmt: skip
HEIGHT_UNITS = {"m": 1.0, "feet": 0.3048, "km": 1000.0, "hPa": 1.0, None: 1.0, "level": 1.0}
NAMES = {
    ("u", "v"): True, ("ugrd", "vgrd"): True, ("ua", "va"): True, ("u-component_of_wind", "v-component_of_wind"): True,
    ("uwnd", "vwnd"): True, ("UGRD", "VGRD"): True, ("wind_east", "wind_north"): False, ("a", "b"): False,
}  # fmt: skip
LEVELS = ["height", "altitude", "z", "lev", "heightAboveGround", "heightAboveSea", "height_above_ground2"]
STANDARD_HEIGHTS = [None, "height", "altitude", "height_above_mean_sea_level", "geopotential_height", "air_pressure"]
LONG_NAMES = [None, "height above ground", "altitude above mean sea level", "geometric height", "model level"]


@st.composite
def forecasts(draw: st.DrawFn) -> Any:
    """Return the same wind in some spelling and units."""
    unit, height_unit = draw(st.sampled_from([*SPEED_UNITS])), draw(st.sampled_from([*HEIGHT_UNITS]))
    names, level = draw(st.sampled_from([*NAMES])), draw(st.sampled_from(LEVELS))
    standard, long_name = draw(st.sampled_from(STANDARD_HEIGHTS)), draw(st.sampled_from(LONG_NAMES))
    above_sea = draw(st.booleans())
    heights = (HEIGHTS + above_sea * HOME.altitude) / HEIGHT_UNITS[height_unit]
    dims = draw(st.permutations(["time", level, "latitude", "longitude"]))
    shape = {"time": 2, level: len(HEIGHTS), "latitude": 3, "longitude": 3}
    east = np.broadcast_to((SPEEDS / SPEED_UNITS[unit])[None, :, None, None], (2, len(HEIGHTS), 3, 3))
    order = ["time", level, "latitude", "longitude"]
    east = np.transpose(east, [order.index(name) for name in dims])
    assert east.shape == tuple(shape[name] for name in dims)
    units = {"units": unit} if unit else {}
    with_standard = draw(st.booleans())
    parts = [units | ({"standard_name": name} if with_standard else {}) for name in ("eastward_wind", "northward_wind")]
    about = {"units": height_unit, "standard_name": standard, "long_name": long_name}
    longitudes = np.array([8.0, 8.5, 9.0]) + draw(st.sampled_from([0.0, 360.0, -360.0]))
    coordinates = {
        "time": np.array(["2026-11-22T10:00", "2026-11-22T11:00"], "datetime64[ns]"),
        "latitude": draw(st.sampled_from([[47.0, 47.4, 47.8], [47.8, 47.4, 47.0]])),
        "longitude": longitudes,
        level: (level, heights, {key: value for key, value in about.items() if value}),
    }
    data = xarray.Dataset(
        {names[0]: (dims, east, parts[0]), names[1]: (dims, np.zeros_like(east), parts[1])}, coordinates
    )
    if draw(st.booleans()):
        data = data.drop_vars(draw(st.sampled_from(["time", level, names[1], "latitude"])))
    tells = standard or long_name or level not in ("z", "lev")
    return data, bool(tells and _right(above_sea, level, standard, long_name))


def _right(above_sea: bool, level: str, standard: str | None, long_name: str | None) -> bool:
    """Return whether the file's datum is true: a wrong one cannot be seen."""
    of_sea = ("altitude", "heightAboveSea", "height_above_mean_sea_level", "geopotential_height")
    words = [word for word in (standard, long_name, level) if word]
    sea = [word in of_sea or "sea level" in word for word in words if word not in ("z", "lev", "model level")]
    return all(each is above_sea for each in sea)


@given(forecasts())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_no_spelling_of_a_wind_is_lost_quietly(monkeypatch: pytest.MonkeyPatch, spelled: tuple[Any, bool]) -> None:
    data, is_right = spelled

    @contextmanager
    def opened(_: Path) -> Iterator[Any]:
        yield data

    monkeypatch.setattr(netcdf_winds, "_open_dataset", opened)
    try:
        read = read_wind(Path(__file__), HOME, TEN)
    except BadInput:
        return
    if read.unread or not is_right:
        return
    for height in USUAL:
        assert read.wind.speed_at(height) >= np.interp(height, HEIGHTS, SPEEDS) - 0.01
