from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import CRS, Transformer

from ipoa_mission.geodesy import Geodetic
from ipoa_mission.maps.winds import read_wind
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
NOON = np.datetime64("2026-11-22T12:00")
LATITUDES, LONGITUDES = [47.0, 47.4, 47.8], [8.0, 8.5, 9.0]
LAMBERT = "+proj=lcc +lat_1=38.5 +lat_0=38.5 +lon_0=-97.5 +R=6371229"  # of HRRR


@pytest.fixture
def xarray() -> Any:
    pytest.importorskip("h5netcdf")
    return pytest.importorskip("xarray")


@pytest.fixture
def eccodes() -> Any:
    return pytest.importorskip("eccodes")


def plain(xarray: Any, path: Path, parts: dict[str, tuple[float, dict[str, str]]], **heights: Any) -> Path:
    where = {"latitude": LATITUDES, "longitude": LONGITUDES}
    fields = {name: (tuple(where), np.full((3, 3), value), about) for name, (value, about) in parts.items()}
    xarray.Dataset(fields, where | heights).to_netcdf(path, engine="h5netcdf")
    return path


@pytest.mark.parametrize(
    ("parts", "towards"),
    [
        ({"wind_speed_10m": (8.0, {}), "wind_direction_10m": (270.0, {})}, (8.0, 0.0)),
        ({"ws10": (5.0, {"units": "m/s"}), "wdir10": (180.0, {"units": "degree"})}, (0.0, 5.0)),
        ({"si10": (10.0, {"units": "knots"}), "wdir10": (np.pi / 2, {"units": "radian"})}, (-5.14444, 0.0)),
        ({"a10m": (5.0, {"standard_name": "wind_speed"}), "b10m": (0.0, {"standard_name": "wind_from_direction"})},
         (0.0, -5.0)),
        ({"a10m": (5.0, {"standard_name": "wind_speed"}), "b10m": (0.0, {"standard_name": "wind_to_direction"})},
         (0.0, 5.0)),
    ],
)  # fmt: skip
def test_speed_and_direction_make_a_wind(xarray: Any, tmp_path: Path, parts: Any, towards: tuple[float, float]) -> None:
    path = plain(xarray, tmp_path / "polar.nc", parts)
    wind = read_wind(path, HOME, None).wind
    assert (wind.east, wind.north) == pytest.approx(towards, abs=1e-4)


def test_a_speed_without_its_direction_is_no_wind(xarray: Any, tmp_path: Path) -> None:
    path = plain(xarray, tmp_path / "speed.nc", {"wind_speed_10m": (8.0, {})})
    with refuses("bad-input", "speed.nc", "wind_speed_10m"):
        read_wind(path, HOME, None)
    both = plain(xarray, tmp_path / "both.nc", {"u10": (1.0, {}), "v10": (0.0, {}), "si10": (1.0, {})})
    read = read_wind(both, HOME, None)
    assert [(thing.place, thing.may_limit) for thing in read.unread if "without" in thing.what] == [("si10", False)]


def turned(xarray: Any, path: Path, names: tuple[str, str], standards: tuple[str, str]) -> Path:
    """A Lambert conformal grid about 30 km wide in Colorado, another wind at every point."""
    to_degrees = Transformer.from_crs(LAMBERT, "EPSG:4326", always_xy=True)
    x, y = np.meshgrid(np.arange(-670_000.0, -640_000.0, 3000.0), np.arange(175_000.0, 205_000.0, 3000.0))
    longitude, latitude = to_degrees.transform(x, y)
    values = 5.0 + np.arange(x.size).reshape(x.shape) / 100.0
    fields = {
        name: (("y", "x"), values if n == 0 else np.full(x.shape, 90.0), {"standard_name": standard, "units": unit})
        for n, (name, standard, unit) in enumerate(
            zip(names, standards, ("m/s", "degree" if "direction" in standards[1] else "m/s"), strict=True)
        )
    }
    where = {"latitude": (("y", "x"), latitude), "longitude": (("y", "x"), longitude)}
    xarray.Dataset(fields, where).to_netcdf(path, engine="h5netcdf")
    return path


COLORADO = Geodetic(40.0, -105.2, 1600.0)


def test_nearest_point_counts_on_a_turned_grid(xarray: Any, tmp_path: Path) -> None:
    for standards in (("eastward_wind", "northward_wind"), ("wind_speed", "wind_from_direction")):
        path = turned(xarray, tmp_path / f"{standards[0]}.nc", ("a10m", "b10m"), standards)
        x, y = Transformer.from_crs("EPSG:4326", LAMBERT, always_xy=True).transform(-105.2, 40.0)
        column, row = round((x + 670_000.0) / 3000.0), round((y - 175_000.0) / 3000.0)
        assert 0 < column < 9
        assert 0 < row < 9
        expected = 5.0 + (10 * row + column) / 100.0
        assert abs(read_wind(path, COLORADO, None).wind.east) == pytest.approx(expected, abs=1e-6)
    with refuses("not-covered", ".nc"):
        read_wind(path, HOME, None)


def test_winds_along_the_axes_of_a_known_grid_are_turned(xarray: Any, tmp_path: Path) -> None:
    """Rotated as PROJ's own axes are; along the grid's axes they would be 5.0 m/s and more off."""
    path = turned(xarray, tmp_path / "a.nc", ("u10", "v10"), ("x_wind", "y_wind"))
    with xarray.open_dataset(path) as data:
        for name in ("u10", "v10"):
            data[name].attrs["grid_mapping"] = "lambert"
        along = [float(data[name].values.flat[0]) for name in ("u10", "v10")]
        data["u10"].values[:], data["v10"].values[:] = along
        data.assign(lambert=((), 0, CRS(LAMBERT).to_cf())).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
        data.assign_coords(lambert=((), 0, {"grid_mapping_name": "rotated_latitude_longitude"})).to_netcdf(
            tmp_path / "c.nc", engine="h5netcdf"
        )
    wind = read_wind(tmp_path / "b.nc", COLORADO, None).wind
    assert (wind.east, wind.north) == pytest.approx(by_a_step_north(LAMBERT, along), abs=0.05)
    assert abs(wind.east - along[0]) > 5.0
    with refuses("bad-input", "c.nc: u10", "axes y, x"):
        read_wind(tmp_path / "c.nc", COLORADO, None)


@pytest.mark.parametrize("relative", [0, 1])
@pytest.mark.parametrize("standards", [("", ""), ("eastward_wind", "northward_wind")])
def test_cfgrib_says_whether_winds_are_along_a_grid(
    xarray: Any, tmp_path: Path, relative: int, standards: tuple[str, str]
) -> None:
    """blaylockbk/Herbie #368: only `GRIB_uvRelativeToGrid` tells."""
    path = turned(xarray, tmp_path / "a.nc", ("u10", "v10"), standards)
    with xarray.open_dataset(path) as data:
        for name in ("u10", "v10"):
            data[name].attrs["GRIB_uvRelativeToGrid"] = relative
        data.to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    if relative:
        with refuses("bad-input", "b.nc: u10", "axes y, x"):
            read_wind(tmp_path / "b.nc", COLORADO, None)
    else:
        assert read_wind(tmp_path / "b.nc", COLORADO, None).wind.north == pytest.approx(90.0)


@pytest.mark.parametrize("standards", [("x_wind", "y_wind"), ("", "")])
def test_winds_along_the_axes_of_a_turned_grid_are_refused(
    xarray: Any, tmp_path: Path, standards: tuple[str, str]
) -> None:
    path = turned(xarray, tmp_path / "turned.nc", ("u10", "v10"), standards)
    with refuses("bad-input", "turned.nc: u10", "axes y, x"):
        read_wind(path, COLORADO, None)


def test_a_grid_without_latitudes_names_its_axes(xarray: Any, tmp_path: Path) -> None:
    path = turned(xarray, tmp_path / "a.nc", ("u10", "v10"), ("eastward_wind", "northward_wind"))
    with xarray.open_dataset(path) as data:
        data.drop_vars(["latitude", "longitude"]).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    with refuses("bad-input", "b.nc: u10", "by y, x"):
        read_wind(tmp_path / "b.nc", COLORADO, None)


def grib(eccodes: Any, path: Path, parts: dict[int, float], **keys: Any) -> Path:
    """One message for each parameter of category 2 (momentum), 10 m above the ground."""
    with path.open("wb") as out:
        for number, value in parts.items():
            handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
            about = {"discipline": 0, "parameterCategory": 2, "parameterNumber": number, "bitsPerValue": 24}
            about |= {"dataDate": 20261122, "dataTime": 1200, "typeOfFirstFixedSurface": 103, "level": 10}
            for key, key_value in (about | keys).items():
                eccodes.codes_set(handle, key, key_value)
            count = eccodes.codes_get(handle, "numberOfDataPoints")
            eccodes.codes_set_values(handle, value + np.arange(count) / 1e4)
            eccodes.codes_write(handle, out)
            eccodes.codes_release(handle)
    return path


ABOVE = Geodetic(46.0, 8.0, 0.0)


def nearest(eccodes: Any, path: Path, place: Geodetic) -> list[float]:
    """The values of all messages at the nearest point, by eccodes itself."""
    values = []
    with path.open("rb") as file:
        while (handle := eccodes.codes_grib_new_from_file(file)) is not None:
            values.append(eccodes.codes_grib_find_nearest(handle, place.latitude_deg, place.longitude_deg)[0].value)
            eccodes.codes_release(handle)
    return values


def by_a_step_north(grid: str, along: Sequence[float], home: Geodetic = COLORADO) -> tuple[float, float]:
    """A wind along a grid's axes as east and north: the axes' directions by the places a step north and east."""
    to_grid = Transformer.from_pipeline(f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step {grid}")
    at, north, east = (
        np.array(to_grid.transform(home.longitude_deg + dx, home.latitude_deg + dy))
        for dx, dy in ((0, 0), (0, 1e-4), (1e-4, 0))
    )
    blows = np.array(along)
    return tuple(float(blows @ (step - at) / np.hypot(*(step - at))) for step in (east, north))  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("kind", "place", "keys"),
    [
        ("polar_stereographic", Geodetic(60.0, 20.0, 0.0), {
            "LaDInDegrees": 60, "orientationOfTheGridInDegrees": 0, "DxInMetres": 9000, "DyInMetres": 9000,
            "latitudeOfFirstGridPointInDegrees": 59.8, "longitudeOfFirstGridPointInDegrees": 19.5}),
        ("rotated_ll", Geodetic(50.1, 20.0, 0.0), {
            "latitudeOfSouthernPoleInDegrees": -40, "longitudeOfSouthernPoleInDegrees": 10,
            "latitudeOfFirstGridPointInDegrees": 0, "longitudeOfFirstGridPointInDegrees": 6,
            "latitudeOfLastGridPointInDegrees": 1.1, "longitudeOfLastGridPointInDegrees": 7.1,
            "iDirectionIncrementInDegrees": 0.1, "jDirectionIncrementInDegrees": 0.1}),
    ],
)  # fmt: skip
def test_grib_along_the_axes_of_other_grids(
    eccodes: Any, tmp_path: Path, kind: str, place: Geodetic, keys: dict[str, Any]
) -> None:
    """PROJ draws the same grid otherwise: a step north in it gives the axes."""
    size = {"Ni": 12, "Nj": 12} if kind == "rotated_ll" else {"Nx": 12, "Ny": 12}
    about = {"gridType": kind, **size, **keys, "numberOfDataPoints": 144, "shapeOfTheEarth": 6, "jScansPositively": 1}
    path = grib(eccodes, tmp_path / "a.grib2", {2: 9.0, 3: -4.0}, **about, resolutionAndComponentFlags=56)
    grid = "+proj=stere +lat_0=90 +lat_ts=60 +lon_0=0 +R=6371229"
    if kind == "rotated_ll":
        grid = "+proj=ob_tran +o_proj=eqc +o_lat_p=40 +o_lon_p=0 +lon_0=10 +R=6371229"
    wind = read_wind(path, place, NOON).wind
    assert (wind.east, wind.north) == pytest.approx(
        by_a_step_north(grid, nearest(eccodes, path, place), place), abs=0.06
    )
    assert abs(wind.east - 9.0) > 0.5


def test_grib_speed_and_direction_make_a_wind(eccodes: Any, tmp_path: Path) -> None:
    path = grib(eccodes, tmp_path / "polar.grib2", {1: 6.0, 0: 270.0})
    speed, from_deg = nearest(eccodes, path, ABOVE)
    wind = read_wind(path, ABOVE, NOON).wind
    assert wind.east == pytest.approx(-speed * np.sin(np.radians(from_deg)), abs=1e-3)
    assert wind.north == pytest.approx(-speed * np.cos(np.radians(from_deg)), abs=1e-3)
    assert wind.east > 5.9
    both = read_wind(grib(eccodes, tmp_path / "both.grib2", {1: 6.0, 0: 270.0, 2: 1.0, 3: 2.0}), ABOVE, NOON)
    assert (both.wind.east, both.wind.north) == pytest.approx((1.0, 2.0), abs=0.1)
    assert both.unread == ()
    with refuses("bad-input", "speed.grib2", "10 m"):
        read_wind(grib(eccodes, tmp_path / "speed.grib2", {1: 6.0}), ABOVE, NOON)


def test_grib_on_a_lambert_grid(eccodes: Any, tmp_path: Path) -> None:
    """East and north by eccodes' own coordinates; refused along the grid's axes."""
    keys = {
        "gridType": "lambert", "Nx": 12, "Ny": 12, "latitudeOfFirstGridPointInDegrees": 39.9, "LaDInDegrees": 38.5,
        "longitudeOfFirstGridPointInDegrees": 254.6, "LoVInDegrees": 262.5, "DxInMetres": 3000, "DyInMetres": 3000,
        "Latin1InDegrees": 38.5, "Latin2InDegrees": 38.5, "numberOfDataPoints": 144, "shapeOfTheEarth": 6,
        "jScansPositively": 1,
    }  # fmt: skip
    path = grib(eccodes, tmp_path / "earth.grib2", {2: 3.0, 3: 1.0}, **keys, uvRelativeToGrid=0)
    wind = read_wind(path, COLORADO, NOON).wind
    assert (wind.east, wind.north) == pytest.approx(nearest(eccodes, path, COLORADO), abs=1e-3)
    along = grib(eccodes, tmp_path / "grid.grib2", {2: 3.0, 3: 1.0}, **keys, uvRelativeToGrid=1)
    wind = read_wind(along, COLORADO, NOON).wind
    assert (wind.east, wind.north) == pytest.approx(
        by_a_step_north(LAMBERT, nearest(eccodes, along, COLORADO)), abs=0.02
    )
    assert abs(wind.east - 3.0) > 0.05
    west = Geodetic(34.24517, -117.985, 0.0)  # of open-meteo/open-meteo #2043
    keys |= {"latitudeOfFirstGridPointInDegrees": 34.1, "longitudeOfFirstGridPointInDegrees": 241.9}
    cone = np.sin(np.radians(38.5)) * np.radians(west.longitude_deg + 97.5)  # of Lambert's cone
    path = grib(eccodes, tmp_path / "west.grib2", {2: 3.0, 3: 1.0}, **keys, uvRelativeToGrid=1)
    wind, (u, v) = read_wind(path, west, NOON).wind, nearest(eccodes, path, west)
    expected = u * np.cos(cone) + v * np.sin(cone), v * np.cos(cone) - u * np.sin(cone)
    assert (wind.east, wind.north) == pytest.approx(expected, abs=2e-3)
    assert np.degrees(cone) == pytest.approx(-12.75, abs=0.01)
    polar = grib(eccodes, tmp_path / "polar.grib2", {1: 6.0, 0: 270.0}, **keys, uvRelativeToGrid=1)
    assert read_wind(polar, west, NOON).wind.east == pytest.approx(6.0, abs=0.1)
