import sqlite3
from pathlib import Path

import numpy as np
import pytest
import shapely
from pyproj import Transformer

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import MapWindow
from tests.refused import refuses

pyogrio = pytest.importorskip("pyogrio")

DRIVERS = {".shp": "ESRI Shapefile", ".fgb": "FlatGeobuf", ".gpkg": "GPKG"}
HOME = LocalFrame(Geodetic(46.8, 8.2, 500.0))
WITHIN = np.array([-500.0, -500.0]), np.array([500.0, 500.0])
ROWS, NOWHERE = 4000, 7


def houses(path: Path, crs: str = "EPSG:4326", west: float = 8.0, options: dict[str, str] | None = None) -> Path:
    """Houses over a quarter of a degree, one of unknown place."""
    rng = np.random.default_rng(3)
    longitude, latitude = west + rng.uniform(0.0, 0.4, ROWS), 46.7 + rng.uniform(0.0, 0.2, ROWS)
    shapes = shapely.box(longitude, latitude, longitude + 2e-4, latitude + 2e-4)
    if crs != "EPSG:4326":
        turn = Transformer.from_crs("EPSG:4326", crs, always_xy=True)
        shapes = shapely.transform(shapes, lambda at: np.column_stack(turn.transform(*at.T)))
    bytes_of = shapely.to_wkb(shapes)
    if path.suffix != ".fgb":
        bytes_of[NOWHERE] = None
    height, driver = np.arange(float(ROWS)), DRIVERS[path.suffix]
    about = {"geometry_type": "Polygon", "crs": crs, "driver": driver, "layer_options": options}
    pyogrio.raw.write(path, bytes_of, [height], np.array(["height"]), **about)
    return path


def near(path: Path, frame: LocalFrame = HOME) -> tuple[set[str], set[str], MapWindow]:
    """Return heights read near home, true ones, and the count left out."""
    around = MapWindow.of(frame, WITHIN)
    assert around.window is not None
    read, whole = read_features(path, around), read_features(path)
    boxes = np.array([feature.shape.bounds for feature in whole], float).reshape(-1, 4)
    wanted = np.isnan(boxes).any(axis=1) | around.window.meets(boxes)
    there = {feature.tags["height"] for feature, is_near in zip(whole, wanted, strict=True) if is_near}
    return {feature.tags["height"] for feature in read}, there, around


@pytest.mark.parametrize("crs", ["EPSG:4326", "EPSG:2056", "EPSG:3857"])
@pytest.mark.parametrize("suffix", DRIVERS)
def test_near_features_are_read_and_the_rest_are_counted(tmp_path: Path, suffix: str, crs: str) -> None:
    read, there, around = near(houses(tmp_path / f"map{suffix}", crs))
    assert read == there
    assert 20 < len(read) < ROWS / 10
    assert (f"{NOWHERE:.0f}" in {height.removesuffix(".0") for height in read}) is (suffix != ".fgb")
    assert around.elsewhere == ROWS - len(read)


def test_rows_are_read_that_an_index_lacks(tmp_path: Path) -> None:
    """A GeoPackage whose index lost a row, a Shapefile with an empty index beside it, files without an index."""
    package = houses(tmp_path / "map.gpkg")
    read, there, _ = near(package)
    with sqlite3.connect(package) as database:
        key = next(int(float(height)) for height in sorted(read) if int(float(height)) != NOWHERE) + 1
        database.execute("DELETE FROM rtree_map_geom WHERE id = ?", (key,))
    database.close()
    assert near(package)[0] == there
    shape = houses(tmp_path / "map.shp")
    (tmp_path / "map.qix").write_bytes(b"")
    read, there, _ = near(shape)
    assert read == there
    for name in ("bare.fgb", "bare.gpkg"):
        read, there, _ = near(houses(tmp_path / name, options={"SPATIAL_INDEX": "NO"}))
        assert read == there


def test_rows_beyond_the_count_that_a_geopackage_stores_are_read(tmp_path: Path) -> None:
    with sqlite3.connect(houses(tmp_path / "map.gpkg")) as database:
        database.execute("UPDATE gpkg_ogr_contents SET feature_count = 3")
    database.close()
    assert len(read_features(tmp_path / "map.gpkg")) == ROWS


def test_a_window_across_the_antimeridian_finds_both_sides(tmp_path: Path) -> None:
    frame = LocalFrame(Geodetic(46.8, 179.999, 500.0))
    for west in (179.8, -180.2 + 360.0 - 0.2):
        read, there, _ = near(houses(tmp_path / f"map{west:.1f}.gpkg", west=west - 0.2), frame)
        assert there
        assert there <= read


@pytest.mark.parametrize("share", [0.6, 0.9, 0.999])
def test_a_flatgeobuf_that_is_cut_short_is_refused_near_its_begin_too(tmp_path: Path, share: float) -> None:
    whole = houses(tmp_path / "map.fgb").read_bytes()
    (tmp_path / "cut.fgb").write_bytes(whole[: int(len(whole) * share)])
    with refuses("damaged-file", "cut.fgb"):
        read_features(tmp_path / "cut.fgb", MapWindow.of(HOME, WITHIN))


def test_a_map_of_another_place_is_named(tmp_path: Path) -> None:
    for suffix in DRIVERS:
        path = houses(tmp_path / f"map{suffix}", west=14.0)
        with refuses("too-far", f"map{suffix}", "100 km", kind=BadInput):
            read_features(path, MapWindow.of(HOME, WITHIN))
