from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.planar import to_plane
from tests.examples import examples
from tests.refused import refuses

KML = """<?xml version="1.0" encoding="UTF-8"?><kml><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>
8.0,47.0 8.001,47.0 8.001,47.001 8.0,47.0</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></kml>"""


@given(st.floats(-0.01, 0.01), st.floats(-60, 60), st.floats(0.001, 0.05), st.floats(0.001, 0.05), st.booleans())
@example(aside=0.0, latitude=3.0, width=0.04, depth=0.03125, holed=False)  # two of the longest undivided edges wide
@example(aside=0.0, latitude=3.0, width=0.04, depth=0.03125, holed=True)
def test_a_ring_across_longitude_180_stays_where_it_is(
    aside: float, latitude: float, width: float, depth: float, holed: bool
) -> None:
    home = LocalFrame(Geodetic(latitude, 179.995 if aside > 0 else -179.995))
    box = shapely.box(180 + aside - width / 2, latitude, 180 + aside + width / 2, latitude + depth)
    hole = shapely.box(180 + aside - width / 9, latitude + depth / 3, 180 + aside + width / 9, latitude + depth / 2)

    def rounded(corners: np.ndarray) -> np.ndarray:
        """Return longitudes that wrap exactly: a last bit more can divide an edge into one part more."""
        return np.column_stack([np.round(corners[:, 0] * 2.0**40) / 2.0**40, corners[:, 1]])

    sure = shapely.transform(shapely.difference(box, hole) if holed else box, rounded)

    def wrapped(corners: np.ndarray) -> np.ndarray:
        return np.column_stack([(corners[:, 0] + 180.0) % 360.0 - 180.0, corners[:, 1]])

    drawn = shapely.transform(sure, wrapped)
    for shape in (drawn, shapely.MultiPolygon([drawn])):
        ((there,), (near,)) = to_plane([shape], home)
        ((truth,), _) = to_plane([sure], home)
        assert near
        assert shapely.is_valid(there)
        assert shapely.symmetric_difference(there, truth).area <= 1e-6 * truth.area


def test_a_zone_round_the_whole_earth_stays_one() -> None:
    world = shapely.box(-180.0, -80.0, 180.0, 80.0)
    ((there,), (near,)) = to_plane([world], LocalFrame(Geodetic(10.0, 20.0)))
    assert near
    assert not shapely.is_empty(there)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda text: text.replace("UTF-8", "UTFx"), ("wrong-format", "m.kml", "XML")),
        (lambda text: text.replace("UTF-8", "utf-7"), ("wrong-format", "m.kml", "XML")),
        (lambda text: text.replace("LinearRing", "LineString"), ("bad-input", "m.kml: Placemark[0].Polygon")),
        (lambda text: text.replace("LinearRing", "Folder"), ("bad-input", "m.kml: Placemark[0].Polygon")),
        (lambda text: text.replace("47.001 ", "47.001,12m "), ("bad-input", "m.kml: Placemark[0].Polygon.coordinates")),
        (lambda text: text[: len(text) // 2], ("wrong-format", "m.kml: line 2")),
    ],
)
def test_a_spoiled_kml_ends_in_words(tmp_path: Path, spoil: Callable[[str], str], words: tuple[str, ...]) -> None:
    file = tmp_path / "m.kml"
    file.write_text(spoil(KML))
    with refuses(*words):
        read_features(file)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(20))
@given(st.data())
def test_a_damaged_elevation_model_ends_in_words(missions: Path, tmp_path: Path, data: st.DataObject) -> None:
    pytest.importorskip("rasterio")
    from ipoa_mission.maps.elevation import ground_altitude, local_grid
    from ipoa_mission.maps.geoid import ElevationRules

    whole = (missions / "oldtown.tif").read_bytes()
    spoiled = bytearray(whole[: data.draw(st.integers(0, len(whole)))])
    for _ in range(data.draw(st.integers(0, 6)) if spoiled else 0):
        spoiled[data.draw(st.integers(0, min(len(spoiled), 800) - 1))] = data.draw(st.integers(0, 255))
    file = tmp_path / "m.tif"
    file.write_bytes(bytes(spoiled))
    for read in (
        lambda: ground_altitude(file, 46.442, 9.842),
        lambda: local_grid(file, ElevationRules(), LocalFrame(Geodetic(46.442, 9.842, 1720.0)), (0, 0), (90, 90)),
    ):
        with suppress(BadInput):
            read()


def test_a_shapefile_with_a_prj_that_is_none_ends_in_words(tmp_path: Path) -> None:
    pyogrio = pytest.importorskip("pyogrio")
    file = tmp_path / "m.shp"
    geometry = np.array([shapely.to_wkb(shapely.Point(8.0, 47.0))], dtype=object)
    pyogrio.raw.write(
        file, geometry, [np.array([9.0])], fields=np.array(["height"]), geometry_type="Point", crs="EPSG:4326"
    )
    assert len(read_features(file)) == 1
    for text in ("GEOGCS[", 'GEOGCS["x",DATUM["y"', "\x00\xff" * 9, 'PROJCS["GCS_WGS_1984",GEOGCS["x"]]'):
        file.with_suffix(".prj").write_text(text, encoding="latin-1")
        with pytest.raises(BadInput) as refused:
            read_features(file)
        assert refused.value.place == str(file)
