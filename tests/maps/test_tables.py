import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
import shapely
from pyproj import Transformer

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.map_reader import read_features
from tests.examples import some
from tests.refused import refuses

RING = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.001], [8.0, 47.0]]
DRIVERS = {".shp": "ESRI Shapefile", ".fgb": "FlatGeobuf", ".gpkg": "GPKG"}


def write(path: Path, coordinates: list[list[float]], system: str | None) -> None:
    raw = pytest.importorskip("pyogrio").raw
    np = pytest.importorskip("numpy")
    shape = shapely.Polygon(coordinates)
    columns = [np.array(["yes", "yes"], object), np.array([23.5, np.nan]), np.array(["Rose", None], object)]
    raw.write(
        path,
        np.array([shapely.to_wkb(shape)] * 2, object),
        columns,
        ["building", "height", "name"],
        crs=system,
        geometry_type="Polygon",
        driver=DRIVERS[path.suffix],
    )


@pytest.mark.parametrize("suffix", DRIVERS)
@pytest.mark.parametrize("system", some(1, ["EPSG:32632", "EPSG:4326"]))
@pytest.mark.filterwarnings("ignore")  # of the writer
def test_each_table_is_read_in_degrees_with_its_fields(tmp_path: Path, suffix: str, system: str) -> None:
    to_system = Transformer.from_crs("EPSG:4326", system, always_xy=True)
    path = tmp_path / f"map{suffix}"
    write(path, [list(to_system.transform(*corner)) for corner in RING], system)
    rose, tower = read_features(path)
    assert shapely.equals_exact(rose.shape.normalize(), shapely.Polygon(RING).normalize(), tolerance=1e-8)
    assert (rose.tags["building"], rose.tags["height"], rose.name) == ("yes", "23.5", "Rose")
    assert {"height", "name"} <= tower.blank


@pytest.mark.filterwarnings("ignore")
def test_a_table_without_a_coordinate_system_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "map.shp", RING, None)
    with refuses("no-coordinate-system", "map.shp") as caught:
        read_features(tmp_path / "map.shp")
    assert ".prj" in str(caught.value.hint)


@pytest.mark.parametrize("suffix", DRIVERS)
def test_a_file_of_another_kind_is_not_even_opened(tmp_path: Path, suffix: str) -> None:
    pytest.importorskip("pyogrio")
    path = tmp_path / f"map{suffix}"
    path.write_text("<OGRVRTDataSource><OGRVRTLayer name='a'><SrcDataSource>/etc/passwd</SrcDataSource></OGRVRTLayer>")
    with refuses("wrong-format", f"map{suffix}", suffix):
        read_features(path)


@pytest.mark.parametrize("begin", [b"\x00\x00\x27\x0a", b"fgb\x03fgb\x00", b"SQLite format 3\x00"])
@pytest.mark.parametrize("suffix", DRIVERS)
def test_a_spoiled_table_is_refused(tmp_path: Path, suffix: str, begin: bytes) -> None:
    pytest.importorskip("pyogrio")
    (tmp_path / f"map{suffix}").write_bytes(begin + b"\xff" * 3000)
    with pytest.raises(BadInput) as refused:
        read_features(tmp_path / f"map{suffix}")
    assert refused.value.place == str(tmp_path / f"map{suffix}")


PLACEMARK = "<kml><Placemark><name>a</name><Point><coordinates>8.5,47.4</coordinates></Point></Placemark></kml>"


def kmz(folder: Path, **files: str) -> Path:
    with zipfile.ZipFile(folder / "map.kmz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name.replace("_", "."), text)
    return folder / "map.kmz"


def test_a_kmz_is_read_as_the_kml_in_it(tmp_path: Path) -> None:
    (feature,) = read_features(kmz(tmp_path, icon_png="x", doc_kml=PLACEMARK))
    assert (feature.name, feature.shape) == ("a", shapely.Point(8.5, 47.4))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda folder: kmz(folder, icon_png="x"), "expected a .kml in the archive, but it has none"),
        (lambda folder: kmz(folder, doc_kml=" " * (65 << 20)), "expected a .kml of at most 64 MB in the archive"),
        (lambda folder: kmz(folder, doc_kml="<kml>"), "line 1: expected well-formed XML"),
    ],
    ids=["empty", "bomb", "spoiled"],
)
def test_another_kmz_is_refused(tmp_path: Path, make: Callable[[Path], Path], words: str) -> None:
    with pytest.raises(BadInput) as caught:
        read_features(make(tmp_path))
    assert str(caught.value).endswith(words)


def test_kmz_must_be_an_archive(tmp_path: Path) -> None:
    (tmp_path / "map.kmz").write_text(PLACEMARK)
    with refuses("wrong-format", "map.kmz"):
        read_features(tmp_path / "map.kmz")


@pytest.mark.parametrize("name", some(1, ["polygon.shp", "pline.shp"]))
def test_qgroundcontrols_shapefiles_in_meters_with_a_prj_in_degrees_fail(samples: Path, name: str) -> None:
    pytest.importorskip("pyogrio")
    with refuses("not-degrees", kind=BadInput) as caught:
        read_features(samples / "DonLakeFlyer+qgroundcontrol" / "test" / "Utilities" / "Geo" / name)
    assert ".prj" in str(caught.value.hint)
