import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import shapely
from pyproj import Transformer

from ipoa_mission.errors import BadInput, WrongFormat
from ipoa_mission.maps.map_reader import read_features
from tests.refused import refuses

RING = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.0]]
SUFFIXES = (
    ".geojson, .json, .geojsonl, .geojsons, .geojsonseq, .ndjson, .jsonl, .kml, .kmz, .osm, .pbf, .shp, .fgb, .gpkg"
)
TAGS = {"building": "yes", "height": "23", "name": 'The "Rose"'}

#: A building by each exporter.
WRITERS = {
    "Overpass turbo": {"@id": "way/1"} | TAGS,
    "osmtogeojson": {"type": "way", "id": 1, "tags": TAGS, "relations": [], "meta": {}},
    "QGIS": {
        "osm_id": None,
        "osm_way_id": "1",
        "name": 'The "Rose"',
        "building": "yes",
        "other_tags": '"height"=>"23"',
    },
    "GDAL": {"other_tags": r'"building"=>"yes","height"=>"23","name"=>"The \"Rose\""'},
    "typed": {"building": "yes", "height": 23, "name": 'The "Rose"', "roof": True, "note": None},
}


@pytest.mark.parametrize("properties", WRITERS.values(), ids=WRITERS)
def test_every_exporters_tags_are_read(write_map: Callable[..., Path], properties: dict[str, Any]) -> None:
    (feature,) = read_features(write_map(({"type": "Polygon", "coordinates": [RING]}, properties)))
    assert {key: feature.tags[key] for key in TAGS} == TAGS
    assert feature.name == 'The "Rose"'
    assert feature.shape.equals(shapely.Polygon(RING))


def test_a_thing_without_a_name_is_called_by_its_number(write_map: Callable[..., Path]) -> None:
    path = write_map(
        ({"type": "Point", "coordinates": [8, 47]}, {"@id": "node/7"}), ({"type": "Point", "coordinates": [8, 47]}, {})
    )
    assert [feature.name for feature in read_features(path)] == ["node/7", f"{path}: features[1]"]


def test_shapely_reads_every_geometry_as_we_do(write_map: Callable[..., Path]) -> None:
    geometries = [
        {"type": "Point", "coordinates": [8, 47, 510.5]},
        {"type": "MultiPoint", "coordinates": [[8, 47], [9, 48]]},
        {"type": "LineString", "coordinates": RING[:2]},
        {"type": "MultiLineString", "coordinates": [RING[:2], RING[1:]]},
        {"type": "Polygon", "coordinates": [RING]},
        {"type": "MultiPolygon", "coordinates": [[RING], [[[x + 1, y] for x, y in RING]]]},
        {"type": "GeometryCollection", "geometries": [{"type": "Polygon", "coordinates": [RING]}]},
    ]
    read = read_features(write_map(*((geometry, {}) for geometry in geometries)))
    for feature, geometry in zip(read, geometries, strict=True):
        assert feature.shape.equals(shapely.force_2d(shapely.from_geojson(json.dumps(geometry))))


def test_coordinates_in_meters_are_turned_into_degrees(write_map: Callable[..., Path]) -> None:
    to_utm = Transformer.from_crs("EPSG:4326", "EPSG:32632", always_xy=True)
    meters = [list(to_utm.transform(x, y)) for x, y in RING]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}}
    (feature,) = read_features(write_map(({"type": "Polygon", "coordinates": [meters]}, {}), crs=crs))
    assert shapely.equals_exact(feature.shape, shapely.Polygon(RING), tolerance=1e-9)


def test_a_kml_and_a_geojson_of_the_same_area_agree(tmp_path: Path, write_map: Callable[..., Path]) -> None:
    hole = [[8.0005, 47.0002], [8.0007, 47.0002], [8.0007, 47.0004], [8.0005, 47.0002]]
    words = [" \n ".join(f"{x},{y},120" for x, y in ring) for ring in (RING, hole)]
    kml = tmp_path / "area.kml"
    kml.write_text(
        f"""<?xml version="1.0" encoding="UTF-8"?>
        <kml xmlns="http://www.opengis.net/kml/2.2"><Document><name>not this</name><Folder><Placemark>
        <name>CTR North</name><description>a zone</description>
        <ExtendedData><Data name="class"><value>D</value></Data></ExtendedData>
        <MultiGeometry><Polygon><altitudeMode>absolute</altitudeMode>
        <outerBoundaryIs><LinearRing><coordinates>{words[0]}</coordinates></LinearRing></outerBoundaryIs>
        <innerBoundaryIs><LinearRing><coordinates>{words[1]}</coordinates></LinearRing></innerBoundaryIs>
        </Polygon></MultiGeometry></Placemark>
        <Placemark><name>nothing</name></Placemark></Folder></Document></kml>""",
        encoding="utf-8",
    )
    zone, nothing = read_features(kml)
    assert (nothing.name, nothing.shape.is_empty) == ("nothing", True)
    (twin,) = read_features(write_map(({"type": "Polygon", "coordinates": [RING, hole]}, {})))
    assert (zone.name, zone.tags["class"]) == ("CTR North", "D")
    assert zone.shape.equals(twin.shape)


BROKEN = {
    '{"type": [[]]}': "type: expected 'FeatureCollection', not [[]]",
    "[": "line 1, column 2: expected JSON: Expecting value",
    "[]": "type: expected 'FeatureCollection', not None",
    '{"type": "Topology"}': "type: expected 'FeatureCollection', not 'Topology'",
    '{"type": "FeatureCollection", "features": 3}': "features: expected a list",
    '{"type": "FeatureCollection", "features": [3]}': "features[0]: expected a Feature",
    '{"type": "FeatureCollection", "features": [{"type": "Feature", "id": "way/7", "geometry": 3}]}': (
        "features[0] (way/7).geometry.type: expected a kind of geometry, such as 'Polygon', not None"
    ),
    '{"type": "FeatureCollection", "features": [], "crs": "WGS84"}': (
        "crs: expected the name of a coordinate system, such as 'EPSG:32633'"
    ),
    '{"type": "Polygon", "coordinates": [[[500123, 5240000], [500200, 5240000], [500200, 5240100]]]}': (
        "feature.geometry.coordinates[0]: expected longitude and latitude in degrees, not 500123, 5.24e+06"
    ),
}
BROKEN_SHAPES = {
    '{"type": "Circle"}': "geometry.type: expected a kind of geometry, such as 'Polygon', not 'Circle'",
    '{"type": ["Polygon"]}': "geometry.type: expected a kind of geometry, such as 'Polygon', not ['Polygon']",
    '{"type": "Polygon", "coordinates": 3}': "geometry.coordinates: expected a list of rings",
    '{"type": "Polygon", "coordinates": [[[8, 47], [9, 48]]]}': (
        "geometry.coordinates[0]: expected a ring of 3 different corners or more"
    ),
    '{"type": "Polygon", "coordinates": [[[8, 47], [9, "x"]]]}': (
        "geometry.coordinates[0]: expected positions as [longitude, latitude]"
    ),
    '{"type": "MultiPolygon", "coordinates": [[[8, 47]]]}': (
        "geometry.coordinates[0][0]: expected positions as [longitude, latitude]"
    ),
    '{"type": "Point", "coordinates": [8]}': "geometry.coordinates: expected positions as [longitude, latitude]",
    '{"type": "Point"}': "geometry.coordinates: expected positions as [longitude, latitude]",
    '{"type": "LineString", "coordinates": [[8, 47]]}': "geometry.coordinates: expected 2 positions or more, not 1",
    '{"type": "GeometryCollection"}': "geometry.geometries: expected a list",
}


@pytest.mark.parametrize(("text", "words"), BROKEN.items(), ids=BROKEN.values())
def test_a_broken_map_is_refused_with_the_place(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "broken.geojson"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        read_features(path)
    assert str(caught.value) == f"{path}: {words}"


CITY = '{"type": "CityJSON", "version": "2.0", "CityObjects": {}, "vertices": []}\n'


@pytest.mark.parametrize("text", [CITY, CITY + '{"type": "CityJSONFeature", "CityObjects": {}, "vertices": []}'])
def test_cityjson_is_refused_with_a_hint(tmp_path: Path, text: str) -> None:
    path = tmp_path / "town.city.json"
    path.write_text(text)
    with pytest.raises(WrongFormat) as refused:
        read_features(path)
    assert "'CityJSON'" in str(refused.value)
    assert "GeoJSON" in str(refused.value.hint)


@pytest.mark.parametrize(("shape", "words"), BROKEN_SHAPES.items(), ids=BROKEN_SHAPES.values())
def test_a_broken_shape_is_refused_with_the_place(write_map: Callable[..., Path], shape: str, words: str) -> None:
    path = write_map(({"type": "Point", "coordinates": [8, 47]}, {}), (json.loads(shape), {}))
    with pytest.raises(BadInput) as caught:
        read_features(path)
    assert str(caught.value) == f"{path}: features[1].{words}"


def test_all_broken_shapes_are_told_but_not_a_flood(write_map: Callable[..., Path]) -> None:
    path = write_map(*[({"type": "Circle"}, {})] * 30)
    with pytest.raises(BadInput) as caught:
        read_features(path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 11
    assert lines[-1] == "and 20 more of this kind"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("map.dxf", "", f"expected a file that ends in {SUFFIXES}, not in .dxf"),
        ("map.kml", "<kml>", "line 1: expected well-formed XML"),
        ("map.kml", "<gpx/>", "expected a kml document, not gpx"),
        (
            "map.kml",
            "<kml><Placemark><Point><coordinates>8;47</coordinates></Point></Placemark></kml>",
            "Placemark[0].Point.coordinates: expected 1 or more different positions as longitude,latitude",
        ),
        (
            "map.kml",
            "<kml><Placemark><Polygon/></Placemark></kml>",
            "Placemark[0].Polygon.outerBoundaryIs: expected one LinearRing, not 0",
        ),
    ],
)
def test_other_files_are_refused_in_words(tmp_path: Path, name: str, text: str, words: str) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        read_features(path)
    assert str(caught.value) == f"{path}: {words}"


POINT = '{"type":"Point","coordinates":[8.5,47.4]}'
SPOT = "<Point><coordinates>8.5,47.4</coordinates></Point>"


def nested(opening: str, core: str, closing: str, times: int) -> str:
    return opening * times + core + closing * times


def collections(times: int) -> str:
    return nested('{"type":"GeometryCollection","geometries":[', POINT, "]}", times)


def placemark(core: str) -> str:
    return f"<kml><Document><Placemark>{core}</Placemark></Document></kml>"


NONSENSE = {
    "deep.geojson": (collections(50_000), "too-large"),
    "collections.geojson": (collections(300), "too-large"),
    "digits.geojson": (POINT.replace("8.5", "9" * 6_000), "too-large"),
    "great.geojson": (POINT.replace("8.5", "9" * 400), "bad-input"),
    "deep.kml": (placemark(nested("<MultiGeometry>", SPOT, "</MultiGeometry>", 50_000)), "too-large"),
    "folders.kml": (f"<kml>{nested('<Folder>', SPOT, '</Folder>', 20_000)}</kml>", "too-large"),
    "placemarks.kml": (placemark(nested("<Placemark>", SPOT, "</Placemark>", 20_000)), "bad-input"),
}


@pytest.mark.parametrize("name", NONSENSE)
def test_nonsense_without_end_is_an_error_at_once(tmp_path: Path, name: str) -> None:
    text, code = NONSENSE[name]
    (tmp_path / name).write_text(text)
    with refuses(code) as refused:
        read_features(tmp_path / name)
    assert refused.value.place.startswith(str(tmp_path))


def test_network_links_of_a_kml_are_features_without_a_shape(tmp_path: Path) -> None:
    link = "<NetworkLink><name>more</name><Link><href>http://example.org/zones.kml</href></Link></NetworkLink>"
    (tmp_path / "a.kml").write_text(f"<kml><Document>{link}<Placemark>{SPOT}</Placemark></Document></kml>")
    more, _ = read_features(tmp_path / "a.kml")
    assert (more.name, more.shape.is_empty) == ("more", True)


def test_depth_of_ordinary_files_is_allowed(tmp_path: Path) -> None:
    (tmp_path / "a.geojson").write_text(collections(16))
    (tmp_path / "a.kml").write_text(placemark(nested("<MultiGeometry>", SPOT, "</MultiGeometry>", 16)))
    assert len(read_features(tmp_path / "a.geojson")) == len(read_features(tmp_path / "a.kml")) == 1
