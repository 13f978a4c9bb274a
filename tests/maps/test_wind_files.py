from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.maps.winds import read_wind
from tests.refused import refuses

pytestmark = pytest.mark.skipif(find_spec("xarray") is None, reason="needs xarray")
HOME = Geodetic(47.4, 8.5, 488.0)
TEN = np.datetime64("2026-11-22T10:00")


def netcdf(
    path: Path, heights: dict[str, Any], unit: str | None = "m s-1", speeds: tuple[float, ...] = (2.0, 8.0, 12.0, 15.0)
) -> Path:
    """West winds at four heights; `heights`: name, values, attributes of the vertical coordinate."""
    import xarray

    name, values = heights["name"], heights["values"]
    dims, shape = ("time", name, "latitude", "longitude"), (2, len(values), 3, 3)
    east = np.broadcast_to(np.array(speeds[: len(values)])[None, :, None, None], shape)
    units = {} if unit is None else {"units": unit}
    variables = {
        "u": (dims, east, {"standard_name": "eastward_wind", **units}),
        "v": (dims, 0.0 * east, {"standard_name": "northward_wind", **units}),
    }
    times = np.array(["2026-11-22T10:00", "2026-11-22T11:00"], "datetime64[ns]")
    where = {"time": times, "latitude": [47.0, 47.4, 47.8], "longitude": [8.0, 8.5, 9.0]}
    data = xarray.Dataset(variables, where | {name: (name, values, heights.get("attributes", {}))})
    data.to_netcdf(path, engine="h5netcdf")
    return path


def levels(path: Path, home: Geodetic = HOME, time: np.datetime64 | None = TEN) -> Any:
    wind = read_wind(path, home, time).wind
    return np.array([(level.height, np.hypot(level.east, level.north)) for level in wind.levels])


ABOVE_SEA = [490.0, 550.0, 700.0, 1000.0]
OVER_HOME = np.array([(2.0, 2.0), (62.0, 8.0), (212.0, 12.0), (512.0, 15.0)])


@pytest.mark.parametrize(
    ("name", "values", "attributes"),
    [
        ("altitude", ABOVE_SEA, {"standard_name": "altitude", "units": "m"}),
        ("altitude", ABOVE_SEA, {"units": "m"}),
        ("z", ABOVE_SEA, {"standard_name": "altitude", "units": "meters"}),
        ("lev", [h / 1000 for h in ABOVE_SEA], {"long_name": "height above mean sea level", "units": "km"}),
        ("height", [h / 0.3048 for h in ABOVE_SEA], {"standard_name": "height_above_mean_sea_level", "units": "ft"}),
        ("heightAboveSea", ABOVE_SEA, {"units": "m"}),
        ("altitude_above_msl", ABOVE_SEA, {"units": "m", "positive": "up"}),
        ("z", ABOVE_SEA, {"standard_name": "geopotential_height", "units": "gpm"}),
        ("height", [2.0, 62.0, 212.0, 512.0], {"units": "m"}),
        ("height", [2.0, 62.0, 212.0, 512.0], {}),
        ("z", [h / 0.3048 for h in (2.0, 62.0, 212.0, 512.0)], {"standard_name": "height", "units": "feet"}),
        ("level", [2.0, 62.0, 212.0, 512.0], {"long_name": "height above ground", "units": "m"}),
        ("level", [2.0, 62.0, 212.0, 512.0], {"units": "m AGL"}),
        ("level", ABOVE_SEA, {"units": "m above mean sea level"}),
    ],
)
def test_heights_are_read_by_unit_and_datum(
    tmp_path: Path, name: str, values: list[float], attributes: dict[str, str]
) -> None:
    path = netcdf(tmp_path / "wind.nc", {"name": name, "values": values, "attributes": attributes})
    assert levels(path) == pytest.approx(OVER_HOME, abs=0.01)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("knots", 1852 / 3600), ("kt", 1852 / 3600), ("kts", 1852 / 3600), ("km/h", 1 / 3.6), ("km h-1", 1 / 3.6),
     ("mph", 0.44704), ("ft/s", 0.3048), ("m s**-1", 1.0), ("metres per second", 1.0), ("cm s-1", 0.01),
     ("Knots", 1852 / 3600)],
)  # fmt: skip
def test_speeds_are_converted(tmp_path: Path, unit: str, factor: float) -> None:
    path = netcdf(tmp_path / "wind.nc", {"name": "height", "values": [10.0], "attributes": {"units": "m"}}, unit)
    assert read_wind(path, HOME, TEN).wind.speed == pytest.approx(2.0 * factor)


@pytest.mark.parametrize("unit", ["beaufort", "Pa", "furlongs", "1", "m"])
def test_an_unknown_unit_is_refused(tmp_path: Path, unit: str) -> None:
    path = netcdf(tmp_path / "wind.nc", {"name": "height", "values": [10.0], "attributes": {"units": "m"}}, unit)
    with refuses("bad-input", "wind.nc: u.units"):
        read_wind(path, HOME, TEN)
    path = netcdf(tmp_path / "heights.nc", {"name": "height", "values": [10.0], "attributes": {"units": "bananas"}})
    with refuses("bad-input", "heights.nc: height.units"):
        read_wind(path, HOME, TEN)


def test_a_missing_unit_is_named(tmp_path: Path) -> None:
    path = netcdf(tmp_path / "wind.nc", {"name": "height", "values": [10.0, 50.0]}, unit=None)
    words = [thing.words for thing in read_wind(path, HOME, TEN).unread]
    assert "wind.nc: not read: unit of a wind, taken as m/s: 4 times, first u" in words
    assert "wind.nc: not read: unit of a height, taken as m: height" in words


def test_an_unknown_datum_is_the_worse_one_and_named(tmp_path: Path) -> None:
    path = netcdf(tmp_path / "wind.nc", {"name": "z", "values": ABOVE_SEA, "attributes": {"units": "m"}})
    assert levels(path) == pytest.approx(OVER_HOME, abs=0.01)
    assert any("datum of its heights, taken as the geoid" in thing.what for thing in read_wind(path, HOME, TEN).unread)
    slowing = netcdf(
        tmp_path / "slowing.nc", {"name": "z", "values": ABOVE_SEA, "attributes": {"units": "m"}}, speeds=(15, 8, 4, 2)
    )
    read = read_wind(slowing, HOME, TEN)
    assert [level.height for level in read.wind.levels] == [490.0, 550.0]
    assert any("datum of its heights, taken as the ground" in thing.what for thing in read.unread)
    contrary = {"units": "m", "standard_name": "height", "long_name": "altitude above mean sea level"}
    path = netcdf(tmp_path / "contrary.nc", {"name": "z", "values": ABOVE_SEA, "attributes": contrary})
    assert levels(path) == pytest.approx(OVER_HOME, abs=0.01)


def test_levels_below_home_and_far_above_are_counted(tmp_path: Path) -> None:
    attributes = {"standard_name": "altitude", "units": "m"}
    path = netcdf(tmp_path / "wind.nc", {"name": "altitude", "values": [100.0, 500.0, 1600.0, 3000.0],
                                         "attributes": attributes})  # fmt: skip
    read = read_wind(path, HOME, TEN)
    assert [level.height for level in read.wind.levels] == [12.0, 1112.0]
    counted = {thing.what: thing.count for thing in read.unread}
    assert counted == {"wind below the ground at home": 1, "wind more than 1112 m above home": 1}
    with refuses("not-covered", "wind.nc", "4000", "1000"):
        read_wind(path, Geodetic(47.4, 8.5, 4000.0), TEN)


def test_pressure_levels_ocean_currents_and_gusts_are_no_winds_at_heights(tmp_path: Path) -> None:
    import xarray

    path = tmp_path / "many.nc"
    data = xarray.open_dataset(netcdf(tmp_path / "w.nc", {"name": "height", "values": [10.0, 80.0]})).load()
    level = data.rename(height="plev", u="u_pl", v="v_pl").assign_coords(plev=("plev", [1e5, 5e4], {"units": "Pa"}))
    flat = data.isel(height=0, drop=True)
    current = {"standard_name": "eastward_sea_water_velocity", "units": "m s-1"}
    gust = {"standard_name": "wind_speed_of_gust", "units": "m s-1"}
    more = {"U250": (flat.u.dims, flat.u.values + 40, {"long_name": "eastward_wind_at_250_hPa", "units": "m s-1"}),
            "uo": (flat.u.dims, flat.u.values + 60, current), "fg": (flat.u.dims, flat.u.values + 9, gust)}  # fmt: skip
    data.merge(level).assign(more).to_netcdf(path, engine="h5netcdf")
    read = read_wind(path, HOME, TEN)
    assert [(level.height, level.east) for level in read.wind.levels] == [(10.0, 2.0), (80.0, 8.0)]
    named = {(thing.what, thing.place) for thing in read.unread}
    assert ("wind at plev, which is no height", "u_pl") in named
    assert ("variable that may be a wind", "fg") in named
    assert any(place == "U250" for _, place in named)
    assert not any(place == "uo" for _, place in named)  # water


def test_a_component_without_its_partner_is_an_error(tmp_path: Path) -> None:
    import xarray

    data = xarray.open_dataset(netcdf(tmp_path / "w.nc", {"name": "height", "values": [10.0]})).load()
    data.assign(u80=data.u.isel(height=0, drop=True) * 9).to_netcdf(tmp_path / "odd.nc", engine="h5netcdf")
    (odd,) = [thing for thing in read_wind(tmp_path / "odd.nc", HOME, TEN).unread if thing.may_limit]
    assert (odd.what, odd.place) == ("eastward wind without a northward one", "u80")


def test_groups_of_a_file_are_named(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    path = netcdf(tmp_path / "wind.nc", {"name": "height", "values": [10.0], "attributes": {"units": "m"}})
    with h5py.File(path, "a") as data:
        data.create_group("upper_air")
    assert [thing.words for thing in read_wind(path, HOME, TEN).unread] == [
        "wind.nc: not read: group of variables: upper_air"
    ]


def test_values_that_are_no_wind_are_refused(tmp_path: Path) -> None:
    path = netcdf(tmp_path / "wind.nc", {"name": "height", "values": [10.0]}, speeds=(9999.0,))
    with refuses("winds-absurd", "wind.nc", "9999", "10", kind=BadInput):
        read_wind(path, HOME, TEN)


def test_members_with_gaps_count_as_far_as_they_are_there(tmp_path: Path) -> None:
    import xarray

    dims, shape = ("number", "time", "latitude", "longitude"), (3, 2, 2, 2)
    east = np.broadcast_to(np.array([4.0, 6.0, 40.0])[:, None, None, None], shape).copy()
    east[2] = np.nan
    times = np.array(["2026-11-22T10:00", "2026-11-22T11:00"], "datetime64[ns]")
    where = {"number": range(3), "time": times, "latitude": [47.4, 47.0], "longitude": [8.5, 9.0]}
    attributes = {"units": "m s-1"}
    data = xarray.Dataset({"u10": (dims, east, attributes), "v10": (dims, 0 * east, attributes)}, where)
    data.to_netcdf(tmp_path / "gaps.nc", engine="h5netcdf")
    read = read_wind(tmp_path / "gaps.nc", HOME, TEN)
    assert (read.wind.east, read.wind.spread) == pytest.approx((5.0, 1.0))
    assert read.unread[0].words == (
        'gaps.nc: not read: wind of a member or time: 4 others count: 2 times, first 10 m up ("missing")'
    )


# --- GRIB -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def eccodes() -> Any:
    return pytest.importorskip("eccodes")


def write_grib(eccodes: Any, path: Path, messages: list[dict[str, Any]], area: tuple[float, ...], step: float) -> Path:
    """Write components of each `wind`, a function of latitude and longitude; `area` is N, W, S, E."""
    north, west, south, east = area
    ni, nj = round(((east - west) % 360) / step) + 1, round((north - south) / step) + 1
    grid: dict[str, Any] = {"numberOfDataPoints": ni * nj, "Ni": ni, "Nj": nj}
    grid |= {f"latitudeOf{end}GridPointInDegrees": degrees for end, degrees in (("First", north), ("Last", south))}
    grid |= {f"longitudeOf{end}GridPointInDegrees": degrees for end, degrees in (("First", west), ("Last", east))}
    grid |= {f"{axis}DirectionIncrementInDegrees": step for axis in "ij"}
    with path.open("wb") as out:
        for message in messages:
            keys = {**message}
            wind = keys.pop("wind")
            for number in (2, 3):
                handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
                if "number" in keys:
                    eccodes.codes_set(handle, "productDefinitionTemplateNumber", 1)
                about = {"discipline": 0, "parameterCategory": 2, "parameterNumber": number, "bitsPerValue": 24}
                for key, value in {**about, "typeOfFirstFixedSurface": 103, "level": 10, **grid, **keys}.items():
                    eccodes.codes_set(handle, key, value)
                latitudes, longitudes = (eccodes.codes_get_array(handle, k) for k in ("latitudes", "longitudes"))
                values = wind(latitudes, longitudes) if number == 2 else np.zeros(len(latitudes))
                eccodes.codes_set_values(handle, np.broadcast_to(values, latitudes.shape).astype(float))
                eccodes.codes_write(handle, out)
                eccodes.codes_release(handle)
    return path


def nearest(eccodes: Any, path: Path, home: Geodetic) -> Iterator[float]:
    """Return eastward winds nearest to home, by eccodes."""
    with path.open("rb") as file:
        while (handle := eccodes.codes_grib_new_from_file(file)) is not None:
            if eccodes.codes_get(handle, "parameterNumber", int) == 2:
                yield eccodes.codes_grib_find_nearest(handle, home.latitude_deg, home.longitude_deg % 360)[0].value
            eccodes.codes_release(handle)


NOON: dict[str, Any] = {"dataDate": 20261122, "dataTime": 1200}
AT_NOON = np.datetime64("2026-11-22T12:00")


@pytest.mark.parametrize(
    ("area", "home"),
    [
        ((52.0, 350.0, 50.0, 0.0), (51.477, -0.05)),
        ((52.0, 350.0, 50.0, 359.75), (51.477, -0.3)),
        ((52.0, 350.0, 50.0, 10.0), (51.477, 0.05)),
        ((52.0, 0.0, 50.0, 359.75), (51.477, -0.1)),
        ((-16.0, 175.0, -19.0, 185.0), (-17.7, -179.9)),
        ((-16.0, 170.0, -19.0, 180.0), (-17.7, 179.95)),
        ((-16.0, 180.0, -19.0, 190.0), (-17.7, -179.95)),
        ((90.0, 0.0, 85.0, 359.75), (89.9, 100.0)),
    ],
)
def test_the_nearest_grid_point_is_that_of_eccodes(
    eccodes: Any, tmp_path: Path, area: tuple[float, ...], home: tuple[float, float]
) -> None:
    def wind(latitude: Any, longitude: Any) -> Any:  # another at every point
        return 2.0 + (longitude % 360) / 36.0 + latitude / 100.0

    path = write_grib(eccodes, tmp_path / "edge.grib2", [NOON | {"wind": wind}], area, 0.25)
    place = Geodetic(*home, 10.0)
    (value,) = nearest(eccodes, path, place)
    assert read_wind(path, place, AT_NOON).wind.east == pytest.approx(value, abs=1e-4)


def test_two_runs_of_several_steps_are_times(eccodes: Any, tmp_path: Path) -> None:
    runs: list[dict[str, Any]] = [{**NOON, "dataTime": run, "forecastTime": step, "wind": lambda *_, s=speed: s}
            for run, step, speed in ((0, 0, 2.0), (0, 6, 4.0), (1200, 0, 10.0), (1200, 6, 20.0))]  # fmt: skip
    path = write_grib(eccodes, tmp_path / "runs.grib2", runs, (48.0, 8.0, 47.0, 9.0), 0.25)
    for clock, mean, spread in (("06:00", 7.0, 3.0), ("01:00", 3.0, 1.0), ("18:00", 20.0, 0.0), ("12:00", 15.0, 5.0)):
        wind = read_wind(path, HOME, np.datetime64(f"2026-11-22T{clock}")).wind
        assert (wind.east, wind.spread) == pytest.approx((mean, spread), abs=1e-3)
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("cfgrib")
    data = xarray.open_dataset(path, engine="cfgrib", backend_kwargs={"indexpath": ""}, decode_timedelta=True)
    assert data.valid_time.ndim == 2
    data.load().to_netcdf(tmp_path / "runs.nc", engine="h5netcdf")
    del data["valid_time"]
    data.to_netcdf(tmp_path / "steps.nc", engine="h5netcdf")
    for name in ("runs.nc", "steps.nc"):
        wind = read_wind(tmp_path / name, HOME, np.datetime64("2026-11-22T06:00")).wind
        assert (wind.east, wind.spread) == pytest.approx((7.0, 3.0), abs=1e-3)


def test_grib_levels_above_the_sea_count_less_home(eccodes: Any, tmp_path: Path) -> None:
    messages = [NOON | {"level": 10, "wind": lambda *_: 3.0}] + [
        NOON | {"typeOfFirstFixedSurface": 102, "level": level, "wind": lambda *_, s=level / 50: s}
        for level in (400, 500, 700)
    ]
    path = write_grib(eccodes, tmp_path / "amsl.grib2", messages, (48.0, 8.0, 47.0, 9.0), 0.25)
    read = read_wind(path, HOME, AT_NOON)
    assert [(level.height, round(level.east, 3)) for level in read.wind.levels] == [
        (10.0, 3.0),
        (12.0, 10.0),
        (212.0, 14.0),
    ]
    assert [thing.what for thing in read.unread] == ["wind below the ground at home"]


def test_members_that_a_level_lacks_and_what_is_no_plain_wind_are_named(eccodes: Any, tmp_path: Path) -> None:
    messages = [NOON | {"number": n, "wind": lambda *_, s=speed: s} for n, speed in ((1, 4.0), (2, 6.0))]
    messages += [NOON | {"number": 1, "level": 100, "wind": lambda *_: 9.0}]
    messages += [NOON | {"productDefinitionTemplateNumber": 2, "derivedForecast": 4, "wind": lambda *_: 1.5}]
    messages += [NOON | {"typeOfFirstFixedSurface": 100, "level": 85000, "wind": lambda *_: 30.0}]
    path = write_grib(eccodes, tmp_path / "members.grib2", messages, (48.0, 8.0, 47.0, 9.0), 0.25)
    read = read_wind(path, HOME, AT_NOON)
    assert [(level.height, round(level.east, 3)) for level in read.wind.levels] == [(10.0, 5.0), (100.0, 9.0)]
    assert read.wind.spread == pytest.approx(1.0, abs=1e-3)
    whats = {thing.what: thing.count for thing in read.unread}
    assert whats["members: 2 at some levels and times, fewer at 1 of 2"] == 1
    assert any("by product template 2" in name for name in whats)
    assert sum(count for name, count in whats.items() if name.startswith("wind at isobaric")) == 2


def test_both_components_in_one_message_are_read_and_a_cut_file_is_refused(eccodes: Any, tmp_path: Path) -> None:
    path = write_grib(eccodes, tmp_path / "two.grib2", [NOON | {"wind": lambda *_: 7.0}], (48.0, 8.0, 47.0, 9.0), 0.25)
    with path.open("rb") as file:
        handles = [eccodes.codes_grib_new_from_file(file) for _ in range(2)]
    several = eccodes.codes_grib_multi_new()
    for handle in handles:
        eccodes.codes_grib_multi_append(handle, 4, several)
    with (tmp_path / "multi.grib2").open("wb") as out:
        eccodes.codes_grib_multi_write(several, out)
    eccodes.codes_grib_multi_release(several)
    assert read_wind(tmp_path / "multi.grib2", HOME, AT_NOON).wind.east == pytest.approx(7.0, abs=1e-3)
    data = path.read_bytes()
    path.write_bytes(data[:-20])
    with refuses("wrong-format", "two.grib2: message 2"):
        read_wind(path, HOME, AT_NOON)


def test_the_forecasts_of_others_are_read_rightly(field4: Path) -> None:
    home = Geodetic(47.397742, 8.545594, 488.0)
    assert levels(field4 / "f4-34-wind-altitude-amsl.nc", home) == pytest.approx(OVER_HOME, abs=0.01)
    for name, speed in (("f4-35-wind-knots", 10.2889), ("f4-35c-wind-kmh", 10.0)):
        assert read_wind(field4 / f"{name}.nc", home, TEN).wind.speed == pytest.approx(speed, abs=1e-3)
    read = read_wind(field4 / "f4-36b-grib-amsl-levels.grib2", Geodetic(37.4, -122.1, 300.0), TEN)
    assert [(level.height, level.east) for level in read.wind.levels] == [(10.0, 3.0), (200.0, 12.0)]


def test_components_of_several_heights_are_paired_in_any_order(tmp_path: Path) -> None:
    import xarray

    degrees = {"units": "degrees_north"}, {"units": "degrees_east"}
    where = {"latitude": ("latitude", [47.2, 47.4], degrees[0]), "longitude": ("longitude", [8.5, 8.7], degrees[1])}
    speeds = {"u10": 3.0, "v100": 8.0, "v10": 4.0, "u100": 6.0}
    variables = {
        name: (("latitude", "longitude"), np.full((2, 2), s), {"units": "m s-1"}) for name, s in speeds.items()
    }
    xarray.Dataset(variables, where).to_netcdf(tmp_path / "w.nc", engine="h5netcdf")
    assert levels(tmp_path / "w.nc", time=None).tolist() == [[10.0, 5.0], [100.0, 10.0]]
