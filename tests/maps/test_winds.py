from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.checks.landings import check_unread
from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.maps.winds import read_wind
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.wind import Wind
from tests.refused import refuses

pytestmark = pytest.mark.skipif(find_spec("xarray") is None, reason="needs xarray")
HOME = Geodetic(47.4, 8.5, 400.0)
NOON = np.datetime64("2026-06-01T12:10")
HOURS = np.array(["2026-06-01T11:00", "2026-06-01T12:00", "2026-06-01T13:00", "2026-06-01T14:00"], "datetime64[ns]")


def forecast(heights: list[float], members: int = 1, longitudes: tuple[float, ...] = (8.0, 8.5, 9.0)) -> Any:
    """East 1 m/s for each 10 m of height, 1 m/s more each hour; north 2 m/s, members 0.5 m/s apart."""
    import xarray  # which takes a second

    dims = ("number", "time", "height", "latitude", "longitude")
    latitudes = (47.0, 47.4, 47.8)
    shape = (members, len(HOURS), len(heights), len(latitudes), len(longitudes))
    hours, up = np.arange(len(HOURS))[None, :, None, None, None], np.array(heights)[None, None, :, None, None]
    member = 0.5 * np.arange(members)[:, None, None, None, None]
    east, north = np.broadcast_to(up / 10.0 + hours, shape), np.broadcast_to(2.0 + member, shape)
    where = {"number": range(members), "time": HOURS, "height": heights, "latitude": list(latitudes)}
    variables = {
        "ua": (dims, east, {"standard_name": "eastward_wind"}),
        "va": (dims, north, {"standard_name": "northward_wind"}),
    }
    return xarray.Dataset(variables, where | {"longitude": list(longitudes)})


def test_a_profile_with_its_spread_is_read_at_home_and_at_the_hour(tmp_path: Path) -> None:
    path = tmp_path / "ensemble.nc"
    forecast([10.0, 100.0], members=3).to_netcdf(path, engine="h5netcdf")
    wind = read_wind(path, HOME, NOON).wind  # 12, 13 and 14 o'clock: 1, 2 and 3 m/s more
    assert wind.velocity(10.0) == pytest.approx((3.0, 2.5))
    assert wind.velocity(100.0) == pytest.approx((12.0, 2.5))
    assert wind.spread == pytest.approx(np.hypot(1.0, 0.5))
    alone = read_wind(path, HOME, np.datetime64("2026-06-01T14:00")).wind
    assert alone.velocity(10.0)[0] == pytest.approx(4.0)


def test_a_classic_file_with_named_heights_and_longitudes_to_360_is_read(tmp_path: Path) -> None:
    data = forecast([10.0], longitudes=(8.0, 8.5, 9.0)).isel(height=0, number=0, time=[0], drop=True)
    data = data.rename(ua="u10", va="v10").assign_coords(longitude=[351.0, 351.5, 352.0])
    for name in ("u10", "v10"):
        data[name].attrs = {}
    path = tmp_path / "classic.nc"
    data.to_netcdf(path, engine="scipy")
    wind = read_wind(path, Geodetic(47.4, -8.5, 0.0), None).wind
    assert (wind.east, wind.north) == pytest.approx((1.0, 2.0))
    assert (wind.levels, wind.spread) == ((), 0.0)


def test_grib_is_read(tmp_path: Path) -> None:
    eccodes = pytest.importorskip("eccodes")
    path = tmp_path / "wind.grib2"
    with path.open("wb") as out:
        for level in (10, 100):
            for name, speed in (("u", level / 20.0), ("v", -1.0)):
                message = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
                keys = {"dataDate": 20260601, "dataTime": 1200, "shortName": {("u", 10): "10u", ("v", 10): "10v",
                        ("u", 100): "100u", ("v", 100): "100v"}[name, level]}  # fmt: skip
                for key, value in keys.items():
                    eccodes.codes_set(message, key, value)
                eccodes.codes_set_values(message, np.full(eccodes.codes_get(message, "numberOfValues"), speed))
                eccodes.codes_write(message, out)
                eccodes.codes_release(message)
    with refuses("time-not-covered", "wind.grib2", "2026-06-03", kind=BadInput):
        read_wind(path, Geodetic(46.0, 8.0, 0.0), np.datetime64("2026-06-03T12:00"))
    wind = read_wind(path, Geodetic(46.0, 8.0, 0.0), np.datetime64("2026-06-01T12:00")).wind
    assert wind.velocity(10.0) == pytest.approx((0.5, -1.0), abs=0.01)
    assert wind.velocity(100.0) == pytest.approx((5.0, -1.0), abs=0.01)


PLACES = """
home = { latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }
start = { east = 0.0, north = 0.0, up = 15.0 }
goal = { east = 90.0, north = 0.0, up = 15.0 }
wind = { file = "ensemble.nc" }
"""


def read(text: str, folder: Path) -> Scenario:
    return parse_scenario(text + PLACES, folder / "here.toml")


def test_a_scenario_has_the_wind_of_its_forecast_and_errors_name_the_file(tmp_path: Path) -> None:
    forecast([10.0, 100.0]).to_netcdf(tmp_path / "ensemble.nc", engine="h5netcdf")
    scenario = read("time = 2026-06-01T12:10:00Z\n", tmp_path)
    assert scenario.wind.air().velocity(100.0) == pytest.approx((12.0, 2.0))
    assert scenario.wind.strongest == pytest.approx(np.hypot(12.0, 2.0) + 1.0)
    with refuses("time-missing", "ensemble.nc", kind=BadInput):
        read("", tmp_path)
    with refuses("time-not-covered", "ensemble.nc", "2026-06-02", kind=BadInput):
        read("time = 2026-06-02T12:10:00Z\n", tmp_path)
    with refuses("not-covered", "ensemble.nc"):
        read_wind(tmp_path / "ensemble.nc", Geodetic(40.0, 8.5, 0.0), NOON)
    (tmp_path / "ensemble.nc").write_bytes(b"no forecast")
    with refuses("wrong-format", "ensemble.nc"):
        read("time = 2026-06-01T12:10:00Z\n", tmp_path)
    with refuses("bad-input", "here.toml: wind"):
        parse_scenario(PLACES.replace('"ensemble.nc"', '"ensemble.nc", speed = 3.0'), tmp_path / "here.toml")


def test_a_copy_for_another_time_or_home_has_its_own_wind(tmp_path: Path) -> None:
    forecast([10.0, 100.0]).to_netcdf(tmp_path / "ensemble.nc", engine="h5netcdf")
    first = read("time = 2026-06-01T11:00:00Z\n", tmp_path)
    last = read("time = 2026-06-01T14:00:00Z\n", tmp_path)
    assert first.wind.air() != last.wind.air()
    assert first.model_copy(update={"time": last.time}).wind.air() == last.wind.air()
    assert first.model_copy(update={"name": "same"}).wind is first.wind
    with refuses("time-not-covered", "ensemble.nc"):
        first.model_copy(update={"time": datetime(2026, 6, 3, tzinfo=UTC)})
    with refuses("not-covered", "ensemble.nc"):
        first.model_copy(update={"home": first.home.model_copy(update={"latitude_deg": 40.0})})
    assert first.in_wind(Wind(3.0)).model_copy(update={"time": last.time}).wind.air() == Wind(3.0)


def test_unread_parts_of_a_forecast_are_named_by_its_scenario(tmp_path: Path) -> None:
    data = forecast([10.0, 100.0]).rename(height="z")
    alone = data.ua.isel(z=0, drop=True) * 5.0
    units = {name: {**data[name].attrs, "units": "m s-1"} for name in ("ua", "va")}
    data = data.assign({name: data[name].assign_attrs(units[name]) for name in units})
    data = data.assign_coords(z=("z", [410.0, 500.0], {"units": "m"}), u80=alone.assign_attrs(units["ua"]))
    data.reset_coords("u80").to_netcdf(tmp_path / "ensemble.nc", engine="h5netcdf")
    scenario = read("time = 2026-06-01T12:10:00Z\n", tmp_path)
    assert [(level.height, round(level.east, 6)) for level in scenario.wind.air().levels] == [
        (10.0, 3.0),
        (100.0, 12.0),
    ]
    odd, datum = scenario.unread
    assert (odd.words, odd.may_limit) == (
        'ensemble.nc: not read: eastward wind without a northward one: u80 ("eastward_wind")',
        True,
    )
    assert datum.what.startswith("datum of its heights, taken as the geoid")
    assert [str(finding.code) for finding in check_unread(scenario.unread)] == ["not-read"]
    assert {odd.words, datum.words} <= set(scenario.remarks)
    assert scenario.in_wind(Wind(3.0)).unread == ()
