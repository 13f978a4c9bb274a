from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Transformer

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.elevation import local_grid
from ipoa_mission.maps.geoid import ElevationRules
from tests.examples import some
from tests.refused import refuses

rasterio = pytest.importorskip("rasterio")
pymap3d = pytest.importorskip("pymap3d")

HOME = Geodetic(47.0, 8.0, 500.0)
AREA = (-300.0, -200.0), (400.0, 350.0)
#: Sizes of a pixel in each system's unit.
SYSTEMS = {"EPSG:4326": 1 / 3600, "EPSG:32632": 25.0, "EPSG:2056": 12.0, "EPSG:3857": 30.0, "EPSG:3035": 25.0}

Heights = Callable[[Any, Any], Any]  # of latitude and longitude, above mean sea level
Write = Callable[..., Path]


def hills(latitude: Any, longitude: Any) -> Any:
    """Ground that is 500 m high at home, within 10 m."""
    return 500 + 9 * np.sin((latitude - 47) * 1500) * np.cos((longitude - 8) * 900)


def tilted(latitude: Any, longitude: Any) -> Any:
    """Ground that rises evenly by 30 m a kilometer northward."""
    return 500 + (latitude - 47) * 3000 + 0 * longitude


@pytest.fixture
def write_model(tmp_path: Path) -> Write:
    """Writes an elevation model round home, `heights` of the places of its posts."""

    def write(
        heights: Heights = hills, crs: str | None = "EPSG:4326", size: int = 80, name: str = "model.tif", **profile: Any
    ) -> Path:
        pixel = SYSTEMS.get(crs or "", 1 / 3600)
        unit = profile.pop("unit", "")
        there = Transformer.from_crs("EPSG:4326", crs or "EPSG:4326", always_xy=True)
        x, y = there.transform(8.0, 47.0)
        # Home is not on a post: a third of a pixel off.
        left, top = x - (size / 2 + 1 / 3) * pixel, y + (size / 2 + 1 / 3) * pixel
        columns, rows = np.meshgrid(left + pixel * (np.arange(size) + 0.5), top - pixel * (np.arange(size) + 0.5))
        longitude, latitude = there.transform(columns, rows, direction="INVERSE")
        data = np.asarray(heights(latitude, longitude))
        options = {"driver": "GTiff", "dtype": "float64", "crs": crs, "count": 1} | profile
        transform = rasterio.Affine(pixel, 0, left, 0, -pixel, top)
        path = tmp_path / name
        with rasterio.open(path, "w", width=size, height=size, transform=transform, **options) as file:
            for band in file.indexes:
                file.write(data.astype(options["dtype"]), band)
            if unit:
                file.units = (unit,)
        return path

    return write


def read(path: Path, home: Geodetic = HOME, area: Any = AREA, **rules: Any) -> tuple[Any, tuple[str, ...]]:
    return local_grid(path, ElevationRules(**rules), LocalFrame(home), *area)


def ground_at(grid: Any, latitude: Any, longitude: Any, height: Any) -> tuple[Any, Any]:
    """Return the grid's heights and true ones above home's plane, by pymap3d."""
    east, north, up = pymap3d.geodetic2enu(latitude, longitude, height, HOME.latitude_deg, HOME.longitude_deg, 500.0)
    return grid.height(np.column_stack([east, north])), up


@pytest.mark.parametrize("crs", SYSTEMS)
def test_the_ground_is_where_the_model_has_it_in_every_coordinate_system(write_model: Write, crs: str) -> None:
    grid, _ = read(write_model(tilted, crs))
    rng = np.random.default_rng(1)
    latitude, longitude = 47 + rng.uniform(-0.0017, 0.003, 300), 8 + rng.uniform(-0.0038, 0.005, 300)
    ground, expected = ground_at(grid, latitude, longitude, tilted(latitude, longitude))
    np.testing.assert_allclose(ground, expected, atol=5e-3)  # a plane in degrees bends by millimeters between posts


@pytest.mark.parametrize("crs", SYSTEMS)
@pytest.mark.parametrize("spacing", some(1, [7.0, None, 90.0]))
def test_no_post_lies_above_the_ground(write_model: Write, crs: str, spacing: float | None) -> None:
    path = write_model(hills, crs)
    grid, _ = read(path, spacing=spacing)
    with rasterio.open(path) as model:
        rows, columns = np.mgrid[0 : model.height, 0 : model.width]
        (left, top), (right, down) = model.xy(0, 0), model.xy(1, 1)
        x, y = left + columns.ravel() * (right - left), top + rows.ravel() * (down - top)
        longitude, latitude = Transformer.from_crs(crs, "EPSG:4326", always_xy=True).transform(x, y)
        heights = model.read(1).ravel()
    east, north, _ = pymap3d.geodetic2enu(latitude, longitude, heights, HOME.latitude_deg, HOME.longitude_deg, 500.0)
    inside = (east > AREA[0][0]) & (east < AREA[1][0]) & (north > AREA[0][1]) & (north < AREA[1][1])
    ground, posts = ground_at(grid, latitude[inside], longitude[inside], heights[inside])
    assert inside.sum() > 300
    assert (ground - posts).min() > -1e-3
    if spacing != 90.0:  # nowhere far above them
        assert (ground - posts).max() < 3.5


def test_the_grid_covers_the_area(write_model: Write) -> None:
    grid, _ = read(write_model(), spacing=40.0)
    rows, columns = grid.heights.shape
    assert (grid.east, grid.north) == AREA[0]
    assert 0 <= grid.east + (columns - 1) * 40 - AREA[1][0] < 40
    assert 0 <= grid.north + (rows - 1) * 40 - AREA[1][1] < 40


def test_the_earth_curves_away_below(write_model: Write) -> None:
    grid, _ = read(write_model(lambda lat, lon: 500 + 0 * lat, size=800), area=((-6000.0, -10.0), (6000.0, 10.0)))
    # 6 km away a surface level with home is 6000^2 / 2 R = 2.82 m lower.
    assert grid.height(np.array([[6000.0, 0.0]]))[0] == pytest.approx(-2.82, abs=0.01)


def test_an_srtm_tile_is_read_as_its_posts(tmp_path: Path) -> None:
    posts = (500 + np.add.outer(-np.arange(1201), np.arange(1201)) % 10).astype(">i2")
    path = tmp_path / "N46E008.hgt"
    path.write_bytes(posts.tobytes())
    home = Geodetic(46.5, 8.5, 505.0)
    grid, remarks = local_grid(path, ElevationRules(), LocalFrame(home), (-500.0, -500.0), (500.0, 500.0))
    # Row 0 is 47 N, posts are 3 seconds apart on whole degrees: home is row 600, column 600.
    for row, column in ((600, 600), (598, 603), (603, 597)):
        east, north, up = pymap3d.geodetic2enu(
            47 - row / 1200, 8 + column / 1200, float(posts[row, column]), 46.5, 8.5, 505
        )
        assert float(grid.height(np.array([[east, north]]))[0]) >= up - 1e-3
        assert float(grid.height(np.array([[east, north]]))[0]) == pytest.approx(up, abs=5.0)
    assert remarks[0] == "N46E008.hgt: heights taken as above mean sea level"


def test_the_antimeridian_is_no_edge(write_model: Write, tmp_path: Path) -> None:
    home, pixel = Geodetic(-17.0, 179.9999, 500.0), 1 / 3600
    path = tmp_path / "fiji.tif"
    with rasterio.open(
        path, "w", driver="GTiff", width=80, height=80, count=1, dtype="float64", crs="EPSG:4326",
        transform=rasterio.Affine(pixel, 0, 180 - 40 * pixel, 0, -pixel, -17 + 40 * pixel),
    ) as file:  # fmt: skip
        file.write(np.tile(500 + np.arange(80.0) / 10 - 4, (80, 1)), 1)
    grid, _ = local_grid(path, ElevationRules(), LocalFrame(home), (-300.0, -300.0), (300.0, 300.0))
    heights = grid.height(np.column_stack([np.linspace(-300, 300, 7), np.zeros(7)]))
    np.testing.assert_allclose(np.diff(heights), 0.1 * 100 / (111320 * np.cos(np.radians(17)) * pixel), rtol=0.02)


@pytest.mark.parametrize(("unit", "factor"), [("ft", 0.3048), ("metre", 1.0), ("US survey foot", 1200 / 3937)])
def test_feet_become_meters(write_model: Write, unit: str, factor: float) -> None:
    grid, _ = read(write_model(lambda lat, lon: 500 / factor + 0 * lat, unit=unit))
    assert grid.height(np.zeros((1, 2)))[0] == pytest.approx(0, abs=1e-6)


def test_a_height_in_feet_over_a_plan_in_meters_becomes_meters(write_model: Write) -> None:
    """Aurtechmx/openlidarviewer PR #863, OSGeo/gdal #14503: NAVD88 height (ftUS) over UTM."""
    path = write_model(lambda lat, lon: 500 * 3937 / 1200 + 0 * lat, crs="EPSG:32632", name="plan.tif")
    with rasterio.open(path, "r+") as file:
        file.crs = rasterio.CRS.from_string("EPSG:32632+6360")
    assert read(path)[0].height(np.zeros((1, 2)))[0] == pytest.approx(0, abs=1e-4)


def test_scale_and_offset_are_heeded(write_model: Write) -> None:
    path = write_model(lambda lat, lon: 5 + 0 * lat, dtype="int16")
    with rasterio.open(path, "r+") as file:
        file.scales, file.offsets = (2.0,), (491.0,)
    assert read(path)[0].height(np.zeros((1, 2)))[0] == pytest.approx(1, abs=1e-6)


def with_a_hole(latitude: Any, longitude: Any) -> Any:
    heights = hills(latitude, longitude)
    heights[41:43, 41:43] = -9999
    return heights


def test_missing_heights_are_refused(write_model: Write) -> None:
    path = write_model(with_a_hole, nodata=-9999)
    with pytest.raises(BadInput) as caught:
        read(path)
    assert f"{path}: 4 of " in str(caught.value)
    assert "heights are missing, the first at row 41, column 41 (latitude 46.99" in str(caught.value)


def test_a_number_that_stands_for_a_missing_height_must_be_said(write_model: Write) -> None:
    path = write_model(with_a_hole)
    with refuses("heights-missing", "model.tif", kind=BadInput):
        read(path, nodata=-9999)
    path = write_model(lambda lat, lon: np.where(lat < 46.999, 9999, hills(lat, lon)))
    with refuses("heights-absurd", "model.tif", "9999", kind=BadInput):
        read(path)


@pytest.mark.parametrize("void", [-9999, -32767, -32768, -999, -501, -3.4e38])
def test_a_height_below_all_ground_is_missing(write_model: Write, void: float) -> None:
    def with_void(latitude: Any, longitude: Any) -> Any:
        heights = with_a_hole(latitude, longitude)
        return np.where(heights == -9999, void, heights)

    path = write_model(with_void)
    with refuses("heights-missing", "model.tif", "4 of", "row 41, column 41", f"{void:g} m", kind=BadInput):
        read(path)


def test_ellipsoidal_heights_lose_the_geoid(write_model: Write, tmp_path: Path) -> None:
    above_ellipsoid = write_model(lambda lat, lon: hills(lat, lon) + 47.25)
    by_number, remarks = read(above_ellipsoid, heights="ellipsoidal", geoid=47.25)
    plain, _ = read(write_model(hills, name="amsl.tif"))
    np.testing.assert_allclose(by_number.heights, plain.heights, atol=1e-9)
    assert remarks[0] == "model.tif: heights above the ellipsoid, less 47.25 m of geoid (as given)"
    # GTX: south, west, steps, size, then rows from south to north.
    grid = tmp_path / "geoid.gtx"
    values = np.full((5, 5), 47.25, ">f4")
    header = np.array([46.0, 7.0, 0.5, 0.5], ">f8").tobytes() + np.array([5, 5], ">i4").tobytes()
    grid.write_bytes(header + values.tobytes())
    from_grid, remarks = read(above_ellipsoid, heights="ellipsoidal", geoid=grid)
    np.testing.assert_allclose(from_grid.heights, plain.heights, atol=1e-5)
    assert remarks[0] == "model.tif: heights above the ellipsoid, less 47.25 m of geoid (by geoid.gtx)"


def test_a_three_dimensional_crs_marks_its_heights_as_ellipsoidal(write_model: Write) -> None:
    path = write_model(lambda lat, lon: hills(lat, lon) + 47.25, crs="EPSG:4979")
    _, remarks = read(path, geoid=47.25)
    assert "above the ellipsoid" in remarks[0]


def test_missing_geoid_grid_is_remarked(write_model: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ipoa_mission.maps.geoid.GRIDS", ("no_such_grid.tif",))
    path = write_model()
    with pytest.raises(BadInput) as caught:
        read(path, heights="ellipsoidal")
    assert str(caught.value) == (
        f"{path}: expected PROJ's grid of the geoid on this machine, since heights are above the ellipsoid"
    )
    assert "terrain.geoid" in str(caught.value.hint)
    _, remarks = read(path, heights="ellipsoidal", level_at_home=True)  # differences need no geoid
    assert remarks[0] == "model.tif: heights taken as differences only"


def test_a_grid_that_does_not_cover_the_flight_is_refused(write_model: Write, tmp_path: Path) -> None:
    grid = tmp_path / "far.gtx"
    header = np.array([0.0, 0.0, 0.5, 0.5], ">f8").tobytes() + np.array([3, 3], ">i4").tobytes()
    grid.write_bytes(header + np.zeros((3, 3), ">f4").tobytes())
    with refuses("not-covered", "terrain.geoid"):
        read(write_model(), heights="ellipsoidal", geoid=grid)


def test_home_must_agree_with_the_model_or_the_model_be_levelled(write_model: Write) -> None:
    path, home = write_model(), Geodetic(47.0, 8.0, 0.0)
    with pytest.raises(BadInput) as caught:
        read(path, home)
    assert str(caught.value).startswith("home.altitude_amsl: expected about 50")
    grid, remarks = read(path, home, level_at_home=True)
    assert grid.height(np.zeros((1, 2)))[0] == pytest.approx(0, abs=1e-9)
    assert remarks[-1].startswith("model.tif: moved by -50")


@pytest.mark.parametrize(
    ("area", "side"),
    [(((-300.0, -200.0), (400.0, 2000.0)), "upper"), (((-3000.0, -200.0), (40.0, 350.0)), "far beyond its left")],
)
def test_a_model_that_is_too_small_is_refused(write_model: Write, area: Any, side: str) -> None:
    with refuses("not-covered", "model.tif", side):
        read(write_model(), area=area)


def test_too_fine_a_grid_is_refused(write_model: Write) -> None:
    with refuses("bad-input", "terrain.spacing", "0.2", "0.01"):
        read(write_model(), spacing=0.01)


def test_files_that_are_no_elevation_model_are_refused(write_model: Write, tmp_path: Path) -> None:
    text = tmp_path / "text.tif"
    text.write_text("no raster", encoding="utf-8")
    with refuses("damaged-file", "text.tif"):
        read(text)
    with refuses("no-coordinate-system", "model.tif"):
        read(write_model(crs=None))
    with refuses("picture", "model.tif", kind=BadInput):
        read(write_model(dtype="uint8", photometric="RGB", count=3))


def test_a_depth_is_no_height(write_model: Write) -> None:
    with refuses("bad-input", "model.tif", "Depth"):
        read(write_model(lambda lat, lon: -hills(lat, lon), "EPSG:4326+5715"))


def test_zeros_among_mountains_are_missing_heights(write_model: Write) -> None:
    def holed(least: float) -> Heights:
        return lambda lat, lon: np.where(
            abs(lat - 47.001) + abs(lon - 8.001) < 4e-4, 0.0, hills(lat, lon) - 500 + least
        )

    with refuses("heights-missing", "model.tif", "0 m", kind=BadInput):
        read(write_model(holed(500.0)))
    grid, _ = read(write_model(holed(20.0)), home=Geodetic(47.0, 8.0, 20.0))
    assert grid.heights.min() < -15.0


def test_a_drop_as_of_a_spoiled_height_and_other_bands_are_named(write_model: Write) -> None:
    spoiled = write_model(
        lambda lat, lon: np.where(abs(lat - 47.001) + abs(lon - 8.001) < 3e-4, 290.5, hills(lat, lon))
    )
    _, remarks = read(spoiled)
    assert any("heights differ by 2" in remark and "one may be missing" in remark for remark in remarks)
    _, remarks = read(write_model(count=2))
    assert "model.tif: heights are those of band 1 of 2" in remarks


@pytest.mark.parametrize(("spoil", "rows"), [(lambda rows: rows[:-1], 6320), (lambda rows: [rows[0], *rows], 6480)])
def test_an_ascii_grid_with_another_number_of_rows_is_refused(
    write_model: Write, spoil: Callable[[list[str]], list[str]], rows: int
) -> None:
    """GDAL fills it up, or leaves them out."""
    path = write_model(name="model.asc", driver="AAIGrid", dtype="float32")
    read(path)
    lines = path.read_text().splitlines()
    head = [line for line in lines if line.strip()[0].isalpha()]
    path.write_text("\n".join([*head, *spoil(lines[len(head) :])]))
    with refuses("damaged-file", "model.asc", "6400", f"{rows}", kind=BadInput):
        read(path)
