import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings
from ipoa_mission.maps.map_reader import read_features
from tests.refused import refuses

RING = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.001], [8.0, 47.0]]
HOUSE = {"building": "yes", "height": "30"}
Write = Callable[[Sequence[str], Sequence[Any]], Path]


def buildings_of(path: Path, frame: LocalFrame) -> Buildings:
    return search_buildings(path, BuildingRules(), frame)


@pytest.fixture
def shapefile(tmp_path: Path) -> Write:
    pyogrio = pytest.importorskip("pyogrio")

    def write(fields: Sequence[str], values: Sequence[Any]) -> Path:
        path = tmp_path / "town.shp"
        with pytest.warns(RuntimeWarning):
            pyogrio.raw.write(
                path, np.array([shapely.to_wkb(shapely.Polygon(RING))] * 4, object),
                [np.array([value] * 4) for value in values], list(fields),
                geometry_type="Polygon", crs="EPSG:4326", driver="ESRI Shapefile",
            )  # fmt: skip
        return path

    return write


@pytest.mark.parametrize(
    ("tags", "height"),
    [
        ({"building:levels": 30, "roof:levels": 1}, 93.0),
        ({"building:levels": 30, "roof:height": 4.5}, 94.5),
        ({"building:levels": 30, "building:levels:underground": 2}, 90.0),
        ({"building:part": "yes", "building:height": 45.0}, 45.0),
        ({"building:levels": 30, "building:material": "brick", "roof:levels": 1}, 93.0),
        ({"measuredHeight": 45.0, "generator:source": "none"}, 45.0),
        ({"generator:source": "wind", "generator:method": "wind_turbine", "rotor:diameter": 90.0}, 250.0),
        ({"generator:source": "wind", "tower:height": 66.0}, 66.0),
        ({"roofs_height_max": 45.0}, 45.0),
    ],
)
def test_names_that_a_shapefile_cut_are_found_again(
    shapefile: Write, frame: LocalFrame, tags: dict[str, Any], height: float
) -> None:
    maps = buildings_of(shapefile([*tags, "diameter_crown_of_it"], [*tags.values(), 1.0]), frame)
    assert {thing.height for thing in maps.obstacles} == {height}


def test_a_second_name_of_the_same_letters_that_may_be_a_height_is_named(shapefile: Write, frame: LocalFrame) -> None:
    """`building:levels` is `building_1` behind `building:levels:underground`."""
    maps = buildings_of(
        shapefile(["building", "building:levels:underground", "building:levels"], ["yes", 2, 30]), frame
    )
    assert all(thing.code == "not-read" and "building_1" in thing.reason for thing in maps.passed_over)
    assert len(maps.passed_over) == 4


def test_tags_packed_in_a_text_that_was_cut_off_are_named(shapefile: Write, frame: LocalFrame) -> None:
    packed = '"name"=>"' + "x" * 300 + '","height"=>"30"'
    maps = buildings_of(shapefile(["building", "other_tags"], ["yes", packed]), frame)
    assert [thing.code for thing in maps.passed_over] == ["not-read"] * 4
    assert "other_tags is not whole" in maps.passed_over[0].reason


@pytest.mark.parametrize(
    ("suffix", "keep", "words"),
    [
        (".dbf", None, ("damaged-file", "town.shp")),
        (".shx", None, ("damaged-file", "town.shp")),
        (".shp", 0.8, ("damaged-file", "town.shp")),
        (".dbf", 0.8, ("damaged-file", "town.shp")),
    ],
)
def test_a_shapefile_that_is_not_whole_is_refused(
    shapefile: Write, suffix: str, keep: float | None, words: tuple[str, ...]
) -> None:
    path = shapefile(["building", "building:levels"], ["yes", 30])
    part = path.with_suffix(suffix)
    data = part.read_bytes()
    part.unlink()
    if keep is not None:
        part.write_bytes(data[: int(len(data) * keep)])
    with refuses(*words):
        read_features(path)


def test_a_flatgeobuf_that_is_cut_short_is_refused(tmp_path: Path) -> None:
    """GDAL 3.12.4 gives 34 of 40 features without a word."""
    pyogrio = pytest.importorskip("pyogrio")
    path = tmp_path / "town.fgb"
    shapes = np.array([shapely.to_wkb(shapely.box(8 + n / 1000, 47, 8.0005 + n / 1000, 47.0005)) for n in range(40)])
    pyogrio.raw.write(
        path, shapes.astype(object), [np.array([30.0] * 40)], ["height"],
        geometry_type="Polygon", crs="EPSG:4326", driver="FlatGeobuf",
    )  # fmt: skip
    assert len(read_features(path)) == 40
    data = path.read_bytes()
    for part in (0.5, 0.9, 0.98):
        path.write_bytes(data[: int(len(data) * part)])
        with pytest.raises(BadInput):
            read_features(path)


def overpass(**way: Any) -> dict[str, Any]:
    return {"version": 0.6, "elements": [{"type": "way", "id": 1, "tags": HOUSE} | way]}


def lat_lon(ring: Sequence[Sequence[float]] = RING) -> list[Any]:
    return [{"lat": y, "lon": x} for x, y in ring]


NODES = [{"type": "node", "id": n, **place} for n, place in enumerate(lat_lon(RING[:4]), 1)]
MEMBER = {"type": "way", "ref": 3, "role": "outer", "geometry": lat_lon()}
OUTLINE = {"type": "multipolygon"} | HOUSE
FEATURE = {"type": "Feature", "properties": HOUSE, "geometry": {"type": "Polygon", "coordinates": [RING]}}

SAME = {
    "a.json": json.dumps(overpass(geometry=lat_lon(), nodes=[1, 2, 3, 4, 1])),
    "b.json": json.dumps(overpass(geometry=lat_lon())),
    "c.json": json.dumps({"elements": [*overpass(nodes=[1, 2, 3, 4, 1])["elements"], *NODES]}),
    "d.json": json.dumps({"elements": [{"type": "relation", "id": 2, "tags": OUTLINE, "members": [MEMBER]}]}),
    "e.geojsonl": json.dumps(FEATURE) + "\n",
    "f.ndjson": json.dumps(FEATURE) + "\n" + json.dumps(FEATURE | {"properties": {"highway": "path"}}) + "\n\n",
    "g.geojson": "\x1e" + json.dumps(FEATURE) + "\n\x1e" + json.dumps(FEATURE | {"properties": {"highway": "path"}}),
    "h.json": json.dumps(FEATURE, indent=1)
    + "\n"
    + json.dumps(FEATURE | {"properties": {"highway": "path"}}, indent=1),
    "i.geojson": json.dumps(FEATURE | {"properties": {"other_tags": '{"building":"yes","height":"30"}'}}),
    "j.geojson": json.dumps(FEATURE | {"properties": {"all_tags": '"building"=>"yes","a"=>NULL,"height"=>"30"'}}),
    "k.geojson": json.dumps(FEATURE | {"properties": {"building": "yes", "size": {"height": {"value": 30}}}}),
    "l.geojson": json.dumps(FEATURE | {"properties": {"building": "yes", "heights": [12, 30]}}),
    "m.osm": '<osm><way id="1">'
    + "".join(f'<nd ref="{n}" lat="{y}" lon="{x}"/>' for (x, y), n in zip(RING, (1, 2, 3, 4, 1), strict=True))
    + '<tag k="building" v="yes"/><tag k="height" v="30"/></way></osm>',
    "n.osm": '<osm><relation id="1"><member type="way" ref="7" role="outer">'
    + "".join(f'<nd lat="{y}" lon="{x}"/>' for x, y in RING)
    + '</member><tag k="type" v="multipolygon"/><tag k="building" v="yes"/><tag k="height" v="30"/></relation></osm>',
}


@pytest.mark.parametrize(("name", "text"), SAME.items(), ids=SAME)
def test_one_house_is_the_same_in_every_spelling(tmp_path: Path, frame: LocalFrame, name: str, text: str) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    maps = buildings_of(path, frame)
    (house,) = maps.obstacles
    assert (house.height, house.shape.area) == pytest.approx((30.0, 76.05 * 111.18), rel=2e-3)
    assert maps.unread == ()
    assert not any(thing.may_be_obstacle for thing in maps.passed_over)


def test_omissions_of_overpass_are_named(tmp_path: Path, frame: LocalFrame) -> None:
    path = tmp_path / "town.json"
    remark = 'runtime error: Query timed out in "query" at line 3 after 25 seconds.'
    path.write_text(json.dumps(overpass(geometry=lat_lon()) | {"remark": remark}))
    (left_out,) = buildings_of(path, frame).unread
    assert left_out.may_limit
    assert "Query timed out" in left_out.what


def test_a_way_that_leads_out_of_the_box_is_in_doubt_where_it_is_known(tmp_path: Path, frame: LocalFrame) -> None:
    """Overpass writes null for places outside."""
    path = tmp_path / "town.json"
    two = overpass(geometry=[*lat_lon()[:2], None, None, *lat_lon()[:1]])
    two["elements"].append({"type": "way", "id": 2, "tags": HOUSE, "geometry": lat_lon()})
    path.write_text(json.dumps(two))
    (doubt,) = buildings_of(path, frame).passed_over
    assert (doubt.name, doubt.code, doubt.may_be_obstacle) == ("way/1", "not-read", True)
    assert doubt.shape.length == pytest.approx(76.05, rel=2e-3)


@pytest.mark.parametrize("way", [{}, {"center": {"lat": 47.0, "lon": 8.0}}, {"nodes": [1, 2, 3, 4, 1]}])
def test_ways_without_a_place_are_refused_with_the_way_out(tmp_path: Path, way: dict[str, Any]) -> None:
    path = tmp_path / "town.json"
    path.write_text(json.dumps(overpass(**way)))
    with refuses("bad-input", "town.json") as refused:
        read_features(path)
    assert "out geom" in str(refused.value.hint)


@pytest.mark.parametrize("cut", [0.25, 0.65, 0.97])
def test_a_file_of_lines_that_is_cut_short_is_refused(tmp_path: Path, cut: float) -> None:
    path = tmp_path / "town.geojsonl"
    text = "\n".join([json.dumps(FEATURE)] * 5)
    path.write_text(text[: int(len(text) * cut)])
    with refuses("wrong-format"):
        read_features(path)


def test_the_public_cases_are_read(field4: Path, frame: LocalFrame) -> None:
    """Overpass's raw JSON, and Microsoft's footprints, whose height of -1 means unknown."""
    home = LocalFrame(frame.home.__class__(47.3977, 8.5456, 488.0))
    for name, heights in (("f4-26-overpass-raw.json", [30, 20]), ("f4-26b-one-feature-a-line.geojson", [30, 20])):
        path = field4 / name
        assert [thing.height for thing in search_buildings(path, BuildingRules(), home).obstacles] == heights


@pytest.mark.parametrize("kind", ["multipolygon", "boundary", "building", "site"])
def test_a_relation_that_goes_round_an_area_is_one(tmp_path: Path, frame: LocalFrame, kind: str) -> None:
    """`boundary`: reserves and military areas."""
    path = tmp_path / "town.json"
    tags = HOUSE | {"type": kind} | ({"boundary": "protected_area"} if kind == "boundary" else {})
    path.write_text(json.dumps({"elements": [{"type": "relation", "id": 2, "tags": tags, "members": [MEMBER]}]}))
    (area,) = find_zones(read_features(path), frame, path).zones
    assert area.shape.area == pytest.approx(76.05 * 111.18, rel=2e-3)
