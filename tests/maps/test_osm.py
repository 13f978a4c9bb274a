import json
from pathlib import Path

import pytest
import shapely

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.map_reader import read_features
from tests.refused import refuses

CORNERS = {1: (47.0, 8.0), 2: (47.0, 8.004), 3: (47.003, 8.004), 4: (47.003, 8.0)}
COURT = {5: (47.001, 8.001), 6: (47.001, 8.002), 7: (47.002, 8.002), 8: (47.002, 8.001)}


def node(number: int, place: tuple[float, float], tags: str = "") -> str:
    return f'<node id="{number}" lat="{place[0]}" lon="{place[1]}">{tags}</node>'


def way_xml(number: int, nodes: list[int], **tags: str) -> str:
    tag_text = "".join(f'<tag k="{key.replace("__", ":")}" v="{value}"/>' for key, value in tags.items())
    return f'<way id="{number}">{"".join(f"<nd ref={chr(34)}{node}{chr(34)}/>" for node in nodes)}{tag_text}</way>'


RELATION = """<relation id="30"><member type="way" ref="20" role="outer"/><member type="way" ref="21" role="outer"/>
<member type="way" ref="22" role="inner"/><member type="node" ref="9" role="label"/>
<tag k="type" v="multipolygon"/><tag k="building" v="yes"/><tag k="height" v="12"/></relation>"""
TOWN = "".join(
    [
        '<?xml version="1.0"?><osm version="0.6">',
        *(node(number, place) for number, place in {**CORNERS, **COURT}.items()),
        node(9, (47.0015, 8.003), '<tag k="man_made" v="mast"/><tag k="height" v="30"/>'),
        way_xml(10, [5, 6, 7, 8, 5], building="yes", name="Hall &amp; more", height="14.5"),
        way_xml(11, [1, 2, 3, 4, 1], highway="residential"),
        way_xml(12, [5, 6, 7, 5], building__part="yes", height="9"),
        way_xml(13, [1, 2, 99, 1], building="yes", height="20"),  # a corner of it lies outside of the extract
        way_xml(20, [1, 2, 3]),
        way_xml(21, [3, 4, 1]),
        way_xml(22, [5, 6, 7, 8, 5]),
        RELATION,
        "</osm>",
    ]
)


@pytest.fixture
def town(tmp_path: Path) -> Path:
    path = tmp_path / "town.osm"
    path.write_text(TOWN)
    return path


def test_things_have_the_shapes_that_gdal_finds(town: Path) -> None:
    raw = pytest.importorskip("pyogrio").raw
    theirs = {}
    for layer in ("points", "lines", "multipolygons"):
        meta, _, shapes, columns = raw.read(town, layer=layer)
        rows = [dict(zip(meta["fields"], row, strict=True)) for row in zip(*columns, strict=True)]
        for row, shape in zip(rows, shapes, strict=True):
            theirs[row.get("osm_way_id") or row["osm_id"]] = shapely.from_wkb(shape)
    ours = {feature.tags["@id"].split("/")[1]: feature.shape for feature in read_features(town)}
    assert set(ours) == {"9", "10", "11", "12", "13", "30"}
    for number in ("9", "10", "11", "30"):
        assert shapely.equals(ours[number], theirs[number]), number
    assert ours["12"].geom_type == "Polygon"  # GDAL makes a line
    assert ours["30"].area == pytest.approx(0.004 * 0.003 - 0.001 * 0.001)


def test_shapes_that_lack_a_corner_are_remarked(town: Path) -> None:
    frame = LocalFrame(Geodetic(47.0, 8.0, 400.0))
    buildings = search_buildings(town, BuildingRules(), frame)
    assert sorted(round(thing.height, 1) for thing in buildings.obstacles) == [9.0, 12.0, 14.5, 30.0]
    assert "Hall & more" in {thing.name for thing in buildings.obstacles}
    assert any("way/13" in thing.name or "way 13" in str(thing) for thing in buildings.passed_over)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TOWN[:-200], ("wrong-format", f"town.osm: line {TOWN[:-200].count(chr(10)) + 1}", "XML")),  # cut short
        ("<gpx/>", ("wrong-format", "town.osm", "XML")),
        ('<?xml version="1.0" encoding="klingon"?><osm/>', ("wrong-format", "town.osm", "XML")),
        ("<osm/>", ("nothing-there", "town.osm")),
        (TOWN.replace('lat="47.0"', 'lat="far"'), ("not-degrees", "town.osm: node 1")),
        (TOWN.replace('lat="47.0015"', 'lat="470015"'), ("not-degrees", "town.osm: node 9")),
        (TOWN.replace('lat="47.001"', 'lat="nan"'), ("not-degrees", "town.osm: node 5")),
    ],
)
def test_no_file_of_that_kind_is_an_error_that_names_the_place(
    tmp_path: Path, text: str, words: tuple[str, ...]
) -> None:
    path = tmp_path / "town.osm"
    path.write_text(text)
    with refuses(*words):
        read_features(path)


def test_a_ring_that_does_not_close_has_no_shape(tmp_path: Path) -> None:
    path = tmp_path / "town.osm"
    path.write_text(TOWN.replace('<member type="way" ref="21" role="outer"/>', ""))
    (open_one,) = (feature for feature in read_features(path) if feature.tags["@id"] == "relation/30")
    assert open_one.shape.is_empty


def test_a_tagged_node_without_a_place_is_refused(tmp_path: Path) -> None:
    """As `out tags` of Overpass writes it."""
    path = tmp_path / "town.json"
    mast, tree = {"type": "node", "id": 7, "tags": {"man_made": "mast"}}, {"type": "node", "id": 8, "lat": 47, "lon": 8}
    path.write_text(json.dumps({"elements": [tree | {"tags": {"natural": "tree"}}, mast]}))
    with refuses("not-degrees", "town.json: elements[1]"):
        read_features(path)
