from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import shapely

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings
from ipoa_mission.maps.passed import count_passed_over

Square = Callable[..., dict[str, Any]]
WriteMap = Callable[..., Path]
#: Tags, reason to pass over a polygon in OpenStreetMap, possible obstacle.
POLYGONS: list[tuple[dict[str, Any], tuple[str, bool] | None]] = [
    ({}, ("an area untagged", True)),
    ({"name": "hall", "@id": "way/7"}, ("an area untagged", True)),
    ({"operator": "somebody"}, ("an area of a kind unknown", True)),
    ({"man_made": "bridge"}, ("an area of a kind unknown", True)),
    ({"natural": "wood"}, ("a wood of unknown height", True)),
    ({"landuse": "forest"}, ("a wood of unknown height", True)),
    ({"leisure": "park"}, ("tagged as something flat", False)),
    ({"amenity": "parking"}, ("tagged as something flat", False)),
    ({"building": "no"}, ("tagged building=no", False)),
    ({"building": "yes", "location": "underground"}, ("underground", False)),
    ({"building": None, "height": None, "leisure": "park"}, ("tagged as something flat", False)),
    ({"building": None, "height": None, "operator": "somebody"}, None),
    ({"height": None}, None),
    ({"height": ""}, None),
    ({"height": float("nan")}, None),
    ({"building": True}, None),
    ({"building": False}, ("tagged building=no", False)),
    ({"landuse": "forest", "height": "25"}, None),
    ({"leisure": "stadium"}, ("an area of a kind unknown", True)),
]


def find(path: Path, frame: LocalFrame, rules: BuildingRules = BuildingRules()) -> Buildings:  # noqa: B008
    return search_buildings(path, rules, frame)


@pytest.mark.parametrize(("tags", "expected"), POLYGONS, ids=[str(tags) for tags, _ in POLYGONS])
def test_a_polygon_beside_a_building_stands_or_is_named(
    write_map: WriteMap, frame: LocalFrame, square: Square, tags: dict[str, Any], expected: tuple[str, bool] | None
) -> None:
    path = write_map((square(0, 0), {"building": "yes"}), (square(50, 0), tags))
    read = find(path, frame)
    assert len(read.obstacles) == 2 - (expected is not None)
    assert [(thing.reason, thing.may_be_obstacle) for thing in read.passed_over] == ([expected] if expected else [])
    assert not any(thing.may_be_obstacle for thing in find(path, frame, BuildingRules(take="tagged")).passed_over)
    is_flat = expected is not None and expected[0] in ("tagged as something flat", "a wood of unknown height")
    assert len(find(path, frame, BuildingRules(take="all")).obstacles) == 2 - is_flat


def test_a_file_of_nothing_but_buildings_is_taken_whole(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    """A cadastre's: some have a height, none a tag of OpenStreetMap."""
    path = write_map((square(0, 0), {"height": 12}), (square(50, 0), {"class": "garage"}), (square(90, 0), {}))
    assert [(s.shape.area > 390, s.height) for s in find(path, frame).obstacles] == [(True, 12), (True, 20), (True, 20)]
    assert len(find(path, frame, BuildingRules(take="tagged")).obstacles) == 1


def test_overtures_buildings_are_read_by_their_own_tags(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    rows: list[dict[str, Any]] = [
        {"names": {"primary": "Hall"}, "height": 21.5, "num_floors": 2, "has_parts": False, "is_underground": False},
        {"names": None, "height": None, "num_floors": 4, "roof_height": 2.5},
        {"height": None, "num_floors": 3, "min_floor": 2, "has_parts": False},
        {"height": 9, "min_height": 3.0, "roof_height": 1.0},
        {"height": None, "num_floors": None, "has_parts": True},
        {"has_parts": False},
        {"height": 5, "is_underground": True},
    ]
    buildings = find(write_map(*((square(50 * n, 0), row) for n, row in enumerate(rows))), frame)
    assert [(s.foot, s.height) for s in buildings.obstacles] == [(0, 21.5), (0, 14.5), (6, 9), (3, 9), (0, 20), (0, 20)]
    assert buildings.obstacles[0].name == "Hall"
    assert buildings.remarks == (
        "1 building of known storeys and unknown roof, 3 m a storey",
        "2 buildings without a height, given 20 m",
    )
    assert [thing.reason for thing in buildings.passed_over] == ["underground"]


def test_points_lines_and_what_has_no_geometry_are_counted(
    write_map: WriteMap, frame: LocalFrame, square: Square, at: Callable[[float, float], list[float]]
) -> None:
    path = write_map(
        (square(0, 0), {"building": "yes"}),
        (None, {"name": "lost"}),
        ({"type": "Point", "coordinates": at(5, 5)}, {"name": "spot"}),
        ({"type": "LineString", "coordinates": [at(0, 0), at(9, 9)]}, {"name": "way"}),
        ({"type": "LineString", "coordinates": square(60, 0)["coordinates"][0]}, {"name": "ring"}),
    )
    buildings = find(path, frame)
    counts = list(count_passed_over(buildings.passed_over))
    assert [counted.words() for counted in counts] == [
        "map.geojson: 1 passed over, an area untagged: ring",
        "map.geojson: 2 passed over, a point or line untagged: spot, way",
    ]
    assert [(thing.words, thing.may_limit) for thing in buildings.unread] == [
        ('map.geojson: not read: without a geometry: features[1] ("lost")', True)
    ]


def test_the_far_part_of_a_wide_map_is_counted(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    path = write_map((square(0, 0), {"building": "yes"}), (square(300_000, 0), {"building": "yes", "name": "away"}))
    buildings = find(path, frame)
    assert (len(buildings.obstacles), [thing.name for thing in buildings.passed_over]) == (1, ["away"])
    assert buildings.passed_over[0].reason == "more than 100 km from home"


def test_every_building_of_overtures_utrecht_stands(samples: Path) -> None:
    buildings = find(samples / "bertt+overture" / "buildings.geojson", LocalFrame(Geodetic(52.1, 5.12)))
    assert not buildings.passed_over
    assert buildings.remarks == ("3739 buildings without a height, given 20 m",)
    assert all(shapely.is_valid(s.shape) for s in buildings.obstacles)
