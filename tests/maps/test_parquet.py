import json
import sys
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pyproj import CRS, Transformer

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from ipoa_mission.scenario.scenario_file import new_scenario, parse_scenario
from tests.maps.conftest import degrees
from tests.refused import refuses

pa = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

HERE: Box = (np.array([-100.0, -100.0]), np.array([1000.0, 100.0]))
HOME = LocalFrame(Geodetic(47.0, 8.0, 500.0))
SIDES = ("xmin", "ymin", "xmax", "ymax")
ABOUT: dict[str, Any] = {
    "version": "1.1.0",
    "primary_column": "geometry",
    "columns": {"geometry": {"encoding": "WKB", "geometry_types": []}},
}
#: Overture's columns.
KINDS = {
    "id": pa.string(),
    "geometry": pa.binary(),
    "bbox": pa.struct([(side, pa.float32()) for side in SIDES]),
    "sources": pa.list_(pa.struct([("dataset", pa.string())])),
    "names": pa.struct([("primary", pa.string()), ("common", pa.map_(pa.string(), pa.string()))]),
    "height": pa.float64(),
    "min_height": pa.float64(),
    "num_floors": pa.int32(),
    "min_floor": pa.int32(),
    "has_parts": pa.bool_(),
    "is_underground": pa.bool_(),
}
ROWS: list[dict[str, Any]] = [
    {"id": "a", "names": {"primary": "Hall", "common": [("en", "Hall")]}, "height": 21.5, "num_floors": 2},
    {"id": "b", "num_floors": 4, "has_parts": True},
    {"id": "c", "height": 9.0, "min_height": 3.0},
    {"id": "d", "num_floors": 3, "min_floor": 2},
    {"id": "e"},
    {"id": "f", "height": 5.0, "is_underground": True},
]
Write = Callable[..., Path]


def house(east: float, north: float = 0.0) -> Any:
    return shapely.Polygon([degrees(east + x, north + y) for x, y in ((0, 0), (20, 0), (20, 20), (0, 20))])


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(
        rows: list[dict[str, Any]], shapes: list[Any], geo: Any = ABOUT, kinds: Any = KINDS, group: int = 3
    ) -> Path:
        whole = []
        for row, shape in zip(rows, shapes, strict=True):
            box = None if shape is None else dict(zip(SIDES, shapely.bounds(shape).tolist(), strict=True))
            whole.append({"geometry": shape if shape is None else shapely.to_wkb(shape), "bbox": box} | row)
        table = pa.Table.from_pylist(whole, pa.schema(list(kinds.items())))
        about = {} if geo is None else {"geo": geo if isinstance(geo, str) else json.dumps(geo)}
        parquet.write_table(table.replace_schema_metadata(about), tmp_path / "map.parquet", row_group_size=group)
        return tmp_path / "map.parquet"

    return write


def test_overtures_buildings_become_what_they_become_as_geojson(write: Write, tmp_path: Path) -> None:
    shapes = [house(50.0 * n) for n in range(len(ROWS))]
    twin = tmp_path / "map.geojson"
    features = [
        {
            "type": "Feature",
            "geometry": shapely.geometry.mapping(shape),
            "properties": {key: None for key in KINDS if key not in ("geometry", "bbox")} | row,
        }
        for row, shape in zip(ROWS, shapes, strict=True)
    ]
    twin.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    ours, theirs = (search_buildings(p, BuildingRules(), HOME, HERE) for p in (write(ROWS, shapes), twin))
    assert [(s.foot, s.height) for s in ours.obstacles] == [(0, 21.5), (0, 12), (3, 9), (6, 9), (0, 20)]
    assert [s._replace(shape=s.shape.wkb) for s in ours.obstacles] == [
        s._replace(shape=s.shape.wkb) for s in theirs.obstacles
    ]
    assert (ours.obstacles[0].name, ours.remarks) == ("Hall", theirs.remarks)
    assert [(feature.name, feature.reason) for feature in ours.passed_over] == [("f", "underground")]


def test_rows_far_away_are_counted(write: Write) -> None:
    far = [house(20_000.0 + 50 * n) for n in range(4)]
    path = write(ROWS + [{"id": f"far {n}"} for n in range(4)], [house(50.0 * n) for n in range(6)] + far, group=3)
    buildings = search_buildings(path, BuildingRules(), HOME, HERE)
    assert (len(buildings.obstacles), buildings.elsewhere, buildings.features) == (5, 4, 6)
    assert "4 things far from the flight, not examined" in buildings.remarks


def test_rows_that_meet_the_window_are_selected(write: Write) -> None:
    wide = shapely.box(7.0, 46.0, 9.0, 48.0)
    places = [house(0), house(30_000), wide, None, house(0, 30_000), house(500)]
    around = MapWindow.of(HOME, HERE)
    features = read_features(write(ROWS, places, group=2), around)
    assert [feature.tags["id"] for feature in features] == ["a", "c", "d", "f"]
    assert [feature.place.rpartition(": ")[2] for feature in features] == ["row[0]", "row[2]", "row[3]", "row[5]"]
    assert around.elsewhere == 2
    assert features[2].shape.is_empty


def test_a_row_across_longitude_180_is_found(write: Write) -> None:
    frame = LocalFrame(Geodetic(10.0, 179.9999, 0.0))
    around = MapWindow.of(frame, (np.array([-50.0, -50.0]), np.array([50.0, 50.0])))
    rows = [{"id": "east"}, {"id": "west"}, {"id": "far"}]
    places = [
        shapely.box(179.999, 9.9999, 179.9999, 10.0001),
        shapely.box(-180.0, 9.9999, -179.9999, 10.0001),
        shapely.box(170, 9, 171, 10),
    ]
    assert [feature.tags["id"] for feature in read_features(write(rows, places, group=1), around)] == ["east", "west"]


def test_the_map_of_another_place_is_refused(write: Write) -> None:
    path = write(ROWS[:1], [house(0)])
    with refuses("too-far", "map.parquet", "100", "10.0000", "8.0000"):
        search_buildings(path, BuildingRules(), LocalFrame(Geodetic(10.0, 8.0)), HERE)
    with refuses("too-far", "map.parquet", "100"):
        read_features(path, MapWindow.of(LocalFrame(Geodetic(10.0, 8.0))))


def test_meters_become_degrees_and_tags_of_other_writers_are_read(write: Write) -> None:
    shape = house(0)
    meters = shapely.transform(
        shape, lambda xy: np.column_stack(Transformer.from_crs("OGC:CRS84", "EPSG:32632").transform(*xy.T))
    )
    geo = json.loads(json.dumps(ABOUT))
    geo["columns"]["geometry"]["crs"] = CRS("EPSG:32632").to_json_dict()
    kinds = {"geometry": pa.large_binary(), "tags": pa.map_(pa.string(), pa.string()), "height": pa.decimal128(9, 2)}
    rows = [{"tags": [("building", "yes"), ("name", "Rose")], "height": Decimal("12.50")}]
    (feature,) = read_features(write(rows, [meters], geo, kinds))
    assert (dict(feature.tags), feature.name) == ({"building": "yes", "name": "Rose", "height": "12.5"}, "Rose")
    assert shapely.equals_exact(feature.shape, shape, tolerance=1e-8)


def spoiled(**about: Any) -> dict[str, Any]:
    return ABOUT | {"columns": {"geometry": {"encoding": "WKB"} | about}}


@pytest.mark.parametrize(
    ("geo", "words"),
    [
        (None, "expected a GeoParquet file, but none of its columns is a geometry"),
        ("{", "geo: expected GeoParquet's metadata of its columns"),
        ([], "geo: expected GeoParquet's metadata of its columns"),
        (ABOUT | {"primary_column": "shape"}, "geo: expected GeoParquet's metadata of its columns"),
        (spoiled(encoding="polygon"), "geometry: expected shapes as WKB, not as 'polygon' in binary"),
        (spoiled(crs=None), "expected a file that names its coordinate system"),
        (spoiled(crs={"type": "GeographicCRS"}), "crs: expected a coordinate system as PROJ's JSON has it"),
    ],
)
def test_metadata_of_the_file_must_make_sense(write: Write, geo: Any, words: str) -> None:
    path = write(ROWS[:1], [house(0)], geo)
    with pytest.raises(BadInput) as caught:
        read_features(path)
    assert str(caught.value) == f"{path}: {words}"


@pytest.mark.parametrize(
    ("wkb", "words"),
    [
        (b"\x01\x03", "expected a shape: "),
        (shapely.to_wkb(shapely.Point(500.0, 8.0)), "expected longitude and latitude"),
    ],
)
def test_a_row_that_is_no_shape_is_named(write: Write, wkb: bytes, words: str) -> None:
    path = write([*ROWS[:4], {"geometry": wkb}], [house(0)] * 5)
    with pytest.raises(BadInput) as caught:
        read_features(path)
    assert str(caught.value).startswith(f"{path}: row[4]: {words}")


def test_tags_that_are_no_pairs_are_none(write: Write) -> None:
    kinds = KINDS | {"tags": pa.list_(pa.string())}
    (feature,) = read_features(write([{"height": 9.0, "tags": ["old", "red"]}], [house(0)], kinds=kinds))
    assert feature.tags["height"] == "9.0"
    assert "tags" not in feature.tags


def test_truncated_empty_and_other_files_are_refused(write: Write) -> None:
    path = write(ROWS, [house(50.0 * n) for n in range(6)])
    whole = path.read_bytes()
    for content, code in {
        whole[: len(whole) // 2]: "damaged-file",
        b"PAR1" + b"\xff" * 3000 + b"PAR1": "damaged-file",
        b'{"type": "FeatureCollection"}': "wrong-format",
        b"": "wrong-format",
    }.items():
        path.write_bytes(content)
        with refuses(code, path.name):
            read_features(path)
    with refuses("nothing-there", "map.parquet"):
        read_features(write([], []))


def test_a_scenario_begins_from_it_and_is_planned_over(write: Write, tmp_path: Path) -> None:
    rows = [{"id": f"{n}", "height": 10.0 + n} for n in range(25)]
    path = write(rows, [house(60.0 * (n % 5), 60.0 * (n // 5)) for n in range(25)])
    target = tmp_path / "town.toml"
    scenario = parse_scenario(new_scenario(target, None, path).text, target)
    assert len(scenario.airspace.obstacles) == 25


def test_missing_library_is_an_error_that_names_the_extra(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(ROWS[:1], [house(0)])
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with refuses("package-missing", kind=BadInput) as caught:
        read_features(path)
    assert caught.value.hint == "pip install 'ipoa-mission[maps]'"
