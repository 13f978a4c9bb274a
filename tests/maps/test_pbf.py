import os
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps import map_reader, pbf
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from tests.maps.test_osm import RELATION, TOWN, node, way_xml
from tests.refused import refuses

osmium = pytest.importorskip("osmium")
pytestmark = pytest.mark.alone
#: The town, a far wood, a cable car, an area of two far ways, a hut, a far road.
COUNTRY = TOWN.replace(
    "</osm>",
    "".join(
        [
            *(node(100 + n, place) for n, place in enumerate([(46.5, 7.5), (46.5, 8.5), (47.5, 8.5), (47.5, 7.5)])),
            *(node(200 + n, place) for n, place in enumerate([(46.9, 8.002), (47.1, 8.002)])),
            *(node(300 + n, place) for n, place in enumerate([(47.3, 8.3), (47.3, 8.301), (47.301, 8.301)])),
            *(node(400 + n, place) for n, place in enumerate([(49.0, 11.0), (49.1, 11.0)])),
            node(500, (47.25, 8.25), '<tag k="man_made" v="mast"/>'),
            way_xml(110, [100, 101, 102]),
            way_xml(111, [102, 103, 100]),
            way_xml(120, [200, 201], aerialway="gondola"),
            way_xml(130, [300, 301, 302, 300], building="hut"),
            way_xml(140, [400, 401], highway="path"),
            '<relation id="150"><member type="way" ref="110" role="outer"/><member type="way" ref="111" role="outer"/>'
            '<tag k="type" v="multipolygon"/><tag k="natural" v="wood"/></relation></osm>',
        ]
    ),
)
HERE: Box = (np.array([-300.0, -300.0]), np.array([600.0, 600.0]))
HOME = LocalFrame(Geodetic(47.0, 8.0, 400.0))
Make = Callable[[str], Path]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Make a binary file by osmium, nodes before ways, as extracts have them."""

    def made(text: str) -> Path:
        xml, binary = tmp_path / "town.osm", tmp_path / "town.osm.pbf"
        xml.write_text(text)
        binary.unlink(missing_ok=True)
        with osmium.SimpleWriter(binary) as writer:
            for sort in (osmium.osm.NODE, osmium.osm.WAY, osmium.osm.RELATION):
                for each in osmium.FileProcessor(xml, sort):
                    writer.add(each)
        return binary

    return made


def test_pbf_is_read_as_the_xml_that_it_was_made_from(make: Make) -> None:
    binary = make(COUNTRY)
    by_id = {each.tags["@id"]: (each.tags, each.shape.wkb) for each in read_features(binary)}
    assert by_id == {each.tags["@id"]: (each.tags, each.shape.wkb) for each in read_features(binary.with_suffix(""))}
    assert {"node/9", "way/13", "relation/30", "relation/150"} < by_id.keys()


def test_things_that_are_only_drawn_yet_are_refused(make: Make) -> None:
    """Their numbers are below 0, and nodes are not kept."""
    for sort, number in (("way", 130), ("node", 500)):
        path = make(COUNTRY.replace(f'<{sort} id="{number}"', f'<{sort} id="-{number}"'))
        with refuses("bad-input", path.name, f"{sort} -{number}"):
            read_features(path)
        assert [*read_features(path.with_suffix(""))]


def test_only_what_meets_the_window_is_read_and_the_rest_is_counted(make: Make) -> None:
    around = MapWindow.of(HOME, HERE)
    numbers = {feature.tags["@id"] for feature in read_features(make(COUNTRY), around)}
    assert numbers == {"node/9", "way/10", "way/11", "way/12", "way/13", "way/120", "relation/30", "relation/150"}
    assert around.elsewhere == 3  # the hut, the path, the mast


def test_obstacles_are_those_of_the_xml(make: Make) -> None:
    binary = make(COUNTRY)
    ours, theirs = (search_buildings(path, BuildingRules(), HOME, HERE) for path in (binary, binary.with_suffix("")))
    here = shapely.box(*np.hstack(HERE))
    near, same = ([s for s in world.obstacles if here.intersects(s.shape)] for world in (ours, theirs))
    assert [(s.name, s.height, s.shape.wkb) for s in near] == [(s.name, s.height, s.shape.wkb) for s in same]
    assert {obstacle.name for obstacle in near} == {"node/9", "Hall & more", "way/12", "way/120", "relation/30"}
    assert "3 things far from the flight, not examined" in ours.remarks
    wood = [feature for feature in ours.passed_over if feature.may_be_obstacle]
    assert [(feature.name, feature.reason) for feature in wood] == [
        ("way/13", "with a part that is not in the file"),
        ("relation/150", "a wood of unknown height"),
    ]


def test_a_small_part_is_read_once_until_the_file_is_another(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    binary, times = make(TOWN), 0

    def count(path: Path, around: MapWindow) -> object:
        nonlocal times
        times += 1
        return pbf.read_pbf(path, around)

    monkeypatch.setitem(map_reader._WINDOW_READERS, ".pbf", count)
    moved = HERE[0] + 5.0, HERE[1] + 5.0
    first, second = (search_buildings(binary, BuildingRules(), HOME, box) for box in (HERE, moved))
    assert (times, len(first.obstacles)) == (1, len(second.obstacles))
    os.utime(binary, ns=(1, 1))
    search_buildings(binary, BuildingRules(), HOME, HERE)
    assert times == 2


def test_the_map_of_another_place_is_refused(make: Make) -> None:
    with refuses("too-far", ".pbf", "100 km", "46.0000, 9.5000"):
        search_buildings(make(TOWN), BuildingRules(), LocalFrame(Geodetic(46.0, 9.5)), HERE)


def test_a_flight_beside_all_that_a_map_has_is_none_of_its_mistakes(make: Make) -> None:
    binary = make(TOWN)
    away = LocalFrame(Geodetic(47.3, 8.3))
    assert search_buildings(binary, BuildingRules(), away, HERE).elsewhere == 6


def test_truncated_and_other_files_are_refused(make: Make) -> None:
    binary = make(COUNTRY)
    whole = binary.read_bytes()
    for content, code in {
        whole[: len(whole) // 2]: "damaged-file",
        whole[:40] + b"\xff" * 400: "damaged-file",
        COUNTRY.encode(): "wrong-format",
        b"": "wrong-format",
    }.items():
        binary.write_bytes(content)
        with refuses(code, str(binary)):
            read_features(binary)


def test_a_file_without_things_is_refused(make: Make) -> None:
    with refuses("nothing-there", ".pbf"):
        read_features(make(f'<osm version="0.6">{node(1, (47.0, 8.0))}</osm>'))


def test_nodes_without_place_and_open_areas_have_no_shape(make: Make) -> None:
    open_one = RELATION.replace('<member type="way" ref="21" role="outer"/>', "")
    binary = make(TOWN.replace(RELATION, open_one).replace("</osm>", way_xml(14, [5], building="yes") + "</osm>"))
    empty = {
        feature.tags["@id"] for feature in read_features(binary, MapWindow.of(HOME, HERE)) if feature.shape.is_empty
    }
    assert empty == {"way/13", "way/14", "relation/30"}


def test_a_large_file_is_refused_with_what_cuts_it_out(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pbf, "LARGEST_PBF", 100)
    with refuses("too-large", ".pbf", "0 MB") as caught:
        search_buildings(make(TOWN), BuildingRules(), HOME, HERE)
    assert "osmium extract --strategy smart --bbox 7.98,46.98,8.02,47.02 --output" in str(caught.value.hint)


def test_missing_library_is_an_error_that_names_the_extra(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    binary = make(TOWN)
    monkeypatch.setitem(sys.modules, "osmium", None)
    with refuses("package-missing", "", "osmium", kind=BadInput) as caught:
        read_features(binary)
    assert caught.value.hint == "pip install 'ipoa-mission[maps]'"
