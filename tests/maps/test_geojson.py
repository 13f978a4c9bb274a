import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps import map_reader
from ipoa_mission.maps.json_shapes import shape_of
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import MapWindow
from tests.refused import refuses

SQUARE = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.0]]
HOLE = [[8.0005, 47.0002], [8.0007, 47.0002], [8.0007, 47.0004]]
HIGH = [[*corner, 410.5] for corner in SQUARE]


def feature(kind: str, coordinates: Any, **properties: Any) -> dict[str, Any]:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "id": "way/7", "properties": properties, "geometry": geometry}


FEATURES = [
    feature("Polygon", [SQUARE, HOLE], building="yes", name="Bäckerei 🥨 «Zopf»"),
    feature("Point", [8.0, 47.0], height=12.5),
    feature("Polygon", [HIGH[:3]]),
    feature("Polygon", [[["8.0", "47.0"], [8.1, 47], [8.1, 47.1]]]),
    feature("LineString", SQUARE, voltage=None),
]


def test_features_are_those_of_geos(tmp_path: Path) -> None:
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": FEATURES, "n": 1234567}, ensure_ascii=False))
    features = read_features(path)
    assert [f.place for f in features] == [f"{path}: features[{i}] (way/7)" for i in range(len(FEATURES))]
    assert [f.shape.wkt for f in features] == [
        shapely.from_geojson(json.dumps(each | {"geometry": _plain(each["geometry"])})).wkt for each in FEATURES
    ]
    assert features[0].name == "Bäckerei 🥨 «Zopf»"


def _plain(geometry: dict[str, Any]) -> dict[str, Any]:
    """Keep numbers, drop heights, close rings, for GEOS's own reader."""
    if geometry["type"] != "Polygon":
        return geometry
    rings = [[[float(x), float(y)] for x, y, *_ in ring] for ring in geometry["coordinates"]]
    return geometry | {"coordinates": [ring if ring[0] == ring[-1] else [*ring, ring[0]] for ring in rings]}


@pytest.mark.parametrize("cut", range(1, 130, 9))
def test_a_file_that_ends_early_is_told_as_json_itself_does(tmp_path: Path, cut: int) -> None:
    text = json.dumps({"type": "FeatureCollection", "features": [FEATURES[1]]}, indent=1)[: -cut - 1]
    with pytest.raises(json.JSONDecodeError) as expected:
        json.loads(text)
    path = tmp_path / "map.geojson"
    path.write_text(text)
    place = f"line {expected.value.lineno}, column {expected.value.colno}"
    with pytest.raises(BadInput) as caught:
        read_features(path)
    assert str(caught.value) == f"{path}: {place}: expected JSON: {expected.value.msg}"


def test_feature_errors_name_their_number(tmp_path: Path) -> None:
    path = tmp_path / "map.geojson"
    flat = feature("Polygon", [[SQUARE[0], SQUARE[1], SQUARE[0]]])
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [*[FEATURES[0]] * 1500, flat]}))
    with refuses("invalid-ring", "map.geojson: features[1500] (way/7).geometry.coordinates[0]"):
        read_features(path)


@pytest.mark.parametrize("behind", [False, True])
def test_the_coordinate_system_counts_wherever_it_stands(tmp_path: Path, behind: bool) -> None:
    meters = feature("Polygon", [[[500_000, 5_200_000], [500_010, 5_200_000], [500_010, 5_200_010]]])
    crs = {"crs": {"type": "name", "properties": {"name": "EPSG:32632"}}}
    features = {"type": "FeatureCollection", "features": [meters]}
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps(features | crs if behind else crs | features))
    assert read_features(path)[0].shape.bounds == pytest.approx((9.0, 46.9535, 9.0001, 46.9536), abs=1e-4)


@pytest.mark.parametrize(
    ("rings", "code", "place"),
    [
        ([], "invalid-ring", "coordinates"),
        ([[]], "bad-input", "coordinates[0]"),
        ({"a": 1}, "invalid-ring", "coordinates"),
        ([SQUARE, []], "bad-input", "coordinates[1]"),
        ([[SQUARE[0], SQUARE[1], SQUARE[0]]], "invalid-ring", "coordinates[0]"),
        ([SQUARE, [SQUARE[0]] * 4], "invalid-ring", "coordinates[1]"),
        ([[[800, 1], [8, 2], [9, 3], [800, 1]]], "not-degrees", "coordinates[0]"),
    ],
)
def test_a_wrong_polygon_is_refused_at_its_place(rings: Any, code: str, place: str) -> None:
    with refuses(code, f"here.{place}"):
        shape_of({"type": "Polygon", "coordinates": rings}, "here")


def test_a_polygon_has_its_hole_closed_or_not() -> None:
    for hole in (HOLE, [*HOLE, HOLE[0]]):
        shape = shape_of({"type": "Polygon", "coordinates": [SQUARE, hole]}, "here")
        assert shape.wkt == shapely.Polygon(SQUARE, [HOLE]).wkt


@pytest.mark.parametrize(
    "text",
    [
        json.dumps({"features": FEATURES, "type": "FeatureCollection"}, ensure_ascii=False, indent=1),
        "\ufeff" + json.dumps({"features": FEATURES, "type": "FeatureCollection"}),
        "\n".join(map(json.dumps, FEATURES)),
        "".join(f"\x1e{json.dumps(each, indent=1)}\n" for each in FEATURES),
    ],
)
def test_one_value_or_one_a_line_has_the_same_features(tmp_path: Path, text: str) -> None:
    path = tmp_path / "map.geojson"
    path.write_text(text)
    geometries = [each["geometry"] for each in FEATURES]
    features = read_features(path)
    assert [each.shape.wkt for each in features] == [shape_of(geometry, "here").wkt for geometry in geometries]
    assert [each.tags["@id"] for each in features] == ["way/7"] * len(FEATURES)


def test_too_large_file_is_refused_with_the_command_to_cut_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps(FEATURES[0]))
    monkeypatch.setattr(map_reader, "LARGEST_WHOLE", 100)
    around = MapWindow.of(LocalFrame(Geodetic(47.0, 8.0)), (np.full(2, -150.0), np.full(2, 150.0)))
    with refuses("too-large", ".geojson", "0 MB") as caught:
        read_features(path, around)
    assert "ogr2ogr -spat 7.98 46.98 8.02 47.02 town.geojson map.geojson" in str(caught.value.hint)
