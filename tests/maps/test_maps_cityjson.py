import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import shapely
from pyproj import Transformer

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, find_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.world.frame import Geodetic, LocalFrame

RD = "https://www.opengis.net/def/crs/EPSG/0/7415"  # the Dutch grid, with heights
EAST, NORTH, GROUND = 121_000.0, 487_000.0, -1.5
LONGITUDE, LATITUDE = Transformer.from_crs(28992, 4326, always_xy=True).transform(EAST, NORTH)
FRAME = LocalFrame(Geodetic(LATITUDE, LONGITUDE, 0.0))
Write = Callable[..., Path]


def block(first: int) -> list[list[list[list[int]]]]:
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    return [[[[first + corner for corner in face]] for face in faces]]


def corners(west: float, south: float, wide: float, low: float, high: float) -> list[list[int]]:
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    return [[round(1000 * v) for v in (west + wide * x, south + wide * y, z)] for z in (low, high) for x, y in ring]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def as_file(objects: dict[str, Any], corners: list[list[int]], **members: Any) -> Path:
        path = tmp_path / "city.json"
        document = {
            "type": "CityJSON",
            "version": "2.0",
            "metadata": {"referenceSystem": RD},
            "transform": {"scale": [0.001] * 3, "translate": [EAST, NORTH, 0.0]},
            "CityObjects": objects,
            "vertices": corners,
        }
        path.write_text(json.dumps(document | members), encoding="utf-8")
        return path

    return as_file


def read(path: Path) -> Buildings:
    return find_buildings(read_features(path), BuildingRules(), FRAME, path)


def solid(first: int) -> list[dict[str, Any]]:
    return [{"type": "Solid", "lod": "1.2", "boundaries": block(first)}]


def test_a_block_stands_where_it_is_and_as_high(write: Write) -> None:
    path = write(
        {"b1": {"type": "Building", "attributes": {"name": "hall"}, "geometry": solid(0)}},
        corners(30.0, 40.0, 20.0, GROUND, GROUND + 12.3),
    )
    (hall,) = read(path).standing
    assert (hall.name, hall.foot) == ("hall", 0.0)
    assert hall.height == pytest.approx(12.3, abs=0.011)
    west, south, _, _ = shapely.bounds(hall.shape)
    assert (west, south) == pytest.approx((30.0, 40.0), abs=0.5)  # the grid is turned against north
    assert shapely.area(hall.shape) == pytest.approx(400.0, rel=2e-3)


def test_a_part_in_the_air_is_as_high_as_its_building(write: Write) -> None:
    path = write(
        {
            "b1": {"type": "Building", "children": ["p1", "p2"]},
            "p1": {"type": "BuildingPart", "parents": ["b1"], "geometry": solid(0)},
            "p2": {"type": "BuildingPart", "parents": ["b1"], "geometry": solid(8)},
        },
        [*corners(0, 0, 30, GROUND, GROUND + 20), *corners(10, 10, 5, GROUND + 20, GROUND + 50)],
    )
    found = read(path)
    assert [part.height for part in found.standing] == pytest.approx([20.0, 50.0], abs=0.011)
    assert not found.passed_over


def test_what_is_ground_is_passed_over_and_the_rest_stands(write: Write) -> None:
    surface = [{"type": "MultiSurface", "lod": "1", "boundaries": [[[0, 1, 2, 3]]]}]
    path = write(
        {
            "road": {"type": "Road", "geometry": surface},
            "relief": {"type": "TINRelief", "geometry": solid(0)},
            "wall": {"type": "+Wall", "geometry": solid(0)},
            "plan": {"type": "Building", "attributes": {"measuredHeight": 7.5}, "geometry": surface},
            "tree": {"type": "SolitaryVegetationObject", "geometry": [{"type": "GeometryInstance", "boundaries": [0]}]},
        },
        corners(0, 0, 30, GROUND, GROUND + 4),
    )
    found = read(path)
    assert {thing.name: thing.height for thing in found.standing} == {"wall": 4.0, "plan": 7.5, "tree": 30.0}
    assert {thing.name: thing.may_stand for thing in found.passed_over} == {"road": False, "relief": False}


@pytest.mark.parametrize(
    ("members", "told"),
    [
        ({"version": "0.9"}, "version: expected 1.0 or 1.1 or 2.0, not '0.9'"),
        ({"metadata": {}}, "metadata.referenceSystem: expected the name of a coordinate system"),
        ({"metadata": {"referenceSystem": "urn:ogc:def:crs:EPSG::99999999"}}, "metadata.referenceSystem: expected"),
        ({"vertices": [[0, 0]]}, "vertices: expected corners"),
        ({"vertices": [[0, 0, 0]]}, "CityObjects.b1.geometry[0].boundaries: expected lists of numbers below 1"),
        ({"CityObjects": {"b": 3}}, "CityObjects: expected an object of objects"),
        ({"transform": {"scale": [1e308] * 3, "translate": [0, 0, 0]}, "vertices": [[9, 9, 9]]}, "vertices: expected"),
        ({"transform": {"scale": [1]}}, "vertices: expected corners as [x, y, z], and a transform"),
    ],
)
def test_what_is_no_cityjson_is_refused_with_its_place(write: Write, members: dict[str, Any], told: str) -> None:
    path = write({"b1": {"type": "Building", "geometry": solid(0)}}, corners(0, 0, 9, 0, 9), **members)
    with pytest.raises(BadInput) as error:
        read_features(path)
    assert str(error.value).startswith(f"{path}: ")
    assert told in str(error.value)


def test_older_versions_name_their_system_otherwise(write: Write) -> None:
    path = write(
        {"b1": {"type": "Building", "geometry": solid(0)}},
        corners(0, 0, 9, 0, 9),
        version="1.0",
        metadata={"referenceSystem": "urn:ogc:def:crs:EPSG::7415"},
    )
    assert len(read(path).standing) == 1
