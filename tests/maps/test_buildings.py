from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import places_under
from ipoa_mission.ground import Ground
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import raise_obstacles, search_buildings
from ipoa_mission.scenario.obstacles import CylinderSection, PrismSection
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.terrain import Flat
from tests.refused import refuses

Square = Callable[..., dict[str, Any]]
WriteMap = Callable[..., Path]
At = Callable[[float, float], list[float]]


class Rising:
    """A terrain that rises a meter in ten towards the east."""

    def height(self, points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return np.asarray(points[:, 0] / 10)


SLOPE = Ground(Rising())


def stand(path: Path, frame: LocalFrame, rules: BuildingRules = BuildingRules()) -> tuple[Obstacle, ...]:  # noqa: B008
    return raise_obstacles(search_buildings(path, rules, frame).obstacles, SLOPE)


def test_a_building_stands_where_pymap3d_says(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    (house,) = stand(write_map((square(100, 50), {"building": "yes", "height": "23"})), frame)
    np.testing.assert_allclose(house.bounds, [[100, 50, 10], [120, 70, 12 + 23]], atol=1e-6)


@pytest.mark.parametrize(
    ("tags", "name"),
    [
        ({"building": "barn"}, "barn 125 m NE of home (way/5)"),
        ({"building": "yes", "man_made": "storage_tank"}, "storage tank 125 m NE of home (way/5)"),
        ({"building": "yes"}, "building 125 m NE of home (way/5)"),
        ({"building": "house", "addr:street": "Dorfstrasse", "addr:housenumber": "8"}, "house, Dorfstrasse 8"),
        ({"building": "church", "name": "St. Anna"}, "St. Anna"),
    ],
)
def test_one_is_called_by_name_or_address_else_by_kind_and_position(
    write_map: WriteMap, frame: LocalFrame, square: Square, tags: dict[str, str], name: str
) -> None:
    """Its middle lies 110 m east and 60 m north of home."""
    assert [obstacle.name for obstacle in stand(write_map((square(100, 50), tags | {"@id": "way/5"})), frame)] == [name]


def test_a_power_line_is_called_by_its_voltage(write_map: WriteMap, frame: LocalFrame) -> None:
    line = {"type": "LineString", "coordinates": [[8.0001, 47.0001], [8.0010, 47.0005]]}
    tags = {"power": "minor_line", "voltage": "20000", "@id": "way/7"}
    assert {obstacle.name for obstacle in stand(write_map((line, tags)), frame)} == {"20 kV line (way/7)"}


def test_a_courtyard_is_free(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    shape = square(0, 0, 60)
    shape["coordinates"].append(square(20, 20)["coordinates"][0])
    (house,) = stand(write_map((shape, {"building": "yes", "height": "23"})), frame)
    assert house.distance(np.array([[30.0, 30.0, 10.0]]))[0] == pytest.approx(10, abs=1e-6)
    assert house.distance(np.array([[10.0, 30.0, 10.0]]))[0] == pytest.approx(-10, abs=1e-6)


def test_each_part_of_a_multipolygon_is_an_obstacle(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    shape = {"type": "MultiPolygon", "coordinates": [square(0, 0)["coordinates"], square(100, 0)["coordinates"]]}
    west, east = stand(write_map((shape, {"building": "yes", "height": "23", "name": "twins"})), frame)
    assert (west.name, east.name) == ("twins", "twins")
    assert (west.bounds[1, 2], east.bounds[1, 2]) == pytest.approx((25, 35), abs=1e-6)  # each on its own ground


def test_a_bridge_between_houses_leaves_the_street_free(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    (bridge,) = stand(write_map((square(0, 0), {"building": "bridge", "height": "12", "min_height": "6"})), frame)
    assert bridge.bounds[:, 2] == pytest.approx([0 + 6, 2 + 12], abs=1e-6)


def test_points_are_cylinders(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    features = [
        ({"type": "Point", "coordinates": at(10, 0)}, {"natural": "tree"}),
        ({"type": "Point", "coordinates": at(10, 50)}, {"natural": "tree", "diameter_crown": "7 m", "height": "12"}),
        ({"type": "MultiPoint", "coordinates": [at(0, 90)]}, {"man_made": "mast", "height": "100 ft"}),
        ({"type": "Point", "coordinates": at(0, 0)}, {"amenity": "bench"}),
    ]
    tree, oak, mast = stand(write_map(*features), frame, BuildingRules(point_height=15, point_radius=2.5))
    assert isinstance(tree, Cylinder)
    assert isinstance(oak, Cylinder)
    assert isinstance(mast, Cylinder)
    assert (tree.radius, tree.base, tree.top) == pytest.approx((2.5, 0.75, 1.25 + 15), abs=1e-6)
    assert (oak.radius, oak.north) == pytest.approx((3.5, 50), abs=1e-6)
    assert mast.top - mast.base == pytest.approx(30.48 + 0.5, abs=1e-6)  # the ground rises by half a meter under it


def test_a_wall_is_as_wide_as_it_says(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    line = {"type": "LineString", "coordinates": [at(0, 0), at(100, 0), at(100, 80)]}
    (wall,) = stand(write_map((line, {"barrier": "wall", "height": "3", "width": "2"})), frame)
    assert isinstance(wall, Prism)
    assert wall.distance(np.array([[50.0, 11.0, 3.0], [91.0, 40.0, 3.0]])) == pytest.approx([10, 8], abs=1e-6)


def test_the_closed_line_of_a_building_is_its_outline(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    line = {"type": "LineString", "coordinates": square(0, 0)["coordinates"][0]}
    (house,) = stand(write_map((line, {"building": "yes"})), frame)
    assert house.distance(np.array([[10.0, 10.0, 3.0]]))[0] < 0


def test_only_what_stands_in_the_way_is_taken(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    others = [
        {"leisure": "park"},
        {"building": "no", "height": "5"},
        {"building": "yes", "location": "underground"},
        {"building": "entrance"},
        {},
    ]
    kinds = [{"building": "yes"}, {"building:part": "yes"}, {"height": "4"}, {"man_made": "silo"}]
    path = write_map(*((square(100 * i, 0), tags) for i, tags in enumerate([*others, *kinds])))
    assert [house.bounds[0, 0] for house in stand(path, frame)] == pytest.approx([500, 600, 700, 800], abs=1e-3)
    assert len(stand(path, frame, BuildingRules(take="all"))) == 8  # the park is flat


def test_assumptions_are_remarked(write_map: WriteMap, frame: LocalFrame, square: Square, at: At) -> None:
    bow = {"type": "Polygon", "coordinates": [[at(0, 0), at(40, 20), at(40, 0), at(0, 20), at(0, 0)]]}
    path = write_map(
        (square(0, 0), {"building": "yes"}),
        (square(50, 0), {"building": "yes"}),
        (square(90, 0), {"building": "yes", "height": "6", "min_height": "8"}),
        (bow, {"building": "yes", "height": "9"}),
        ({"type": "LineString", "coordinates": [at(0, 0), at(9, 9)]}, {"power": "line", "name": "110 kV"}),
    )
    buildings = search_buildings(path, BuildingRules(default_height=11), frame)
    obstacles = buildings.obstacles
    assert buildings.remarks == (
        "2 buildings without a height, given 11 m",
        "1 building whose min_height is not below the height, taken to begin at the ground",
        "1 outline mended (a ring with self-intersection)",
        "1 power line of unknown voltage without a height, given 60 m (line_height)",
    )
    assert not buildings.passed_over
    # A bow tie of 40 m by 20 m is two triangles of 20 m by 20 m / 2.
    assert [s.shape.area for s in obstacles[3:5]] == pytest.approx([200, 200], abs=1e-3)
    assert all(shapely.is_valid(s.shape) for s in obstacles)


@pytest.mark.parametrize(
    ("ring", "words"),
    [
        ([(0, 0), (10, 0), (20, 0), (0, 0)], "expected a polygon with an area, not a"),
        ([(0, 0), (0, 1e-4), (1e-4, 0), (0, 0)], "expected a polygon with an area, not a"),
    ],
)
def test_a_footprint_without_an_area_is_refused(
    write_map: WriteMap, frame: LocalFrame, at: At, ring: list[tuple[float, float]], words: str
) -> None:
    path = write_map(({"type": "Polygon", "coordinates": [[at(*corner) for corner in ring]]}, {"building": "yes"}))
    with pytest.raises(BadInput) as caught:
        stand(path, frame)
    assert str(caught.value).startswith(f"{path}: features[0].geometry: {words}")


def test_repeated_corners_do_no_harm(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    ring = [at(0, 0), at(20, 0), at(20, 0), at(20, 20), at(0, 20), at(0, 1e-5), at(0, 0)]
    (house,) = stand(write_map(({"type": "Polygon", "coordinates": [ring]}, {"building": "yes"})), frame)
    assert house.distance(np.array([[30.0, 10.0, 3.0]]))[0] == pytest.approx(10, abs=1e-3)


def test_a_building_given_as_a_point_is_refused(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    path = write_map(({"type": "Point", "coordinates": at(0, 0)}, {"building": "yes"}))
    with pytest.raises(BadInput) as caught:
        stand(path, frame)
    assert str(caught.value) == f"{path}: features[0].geometry: expected the outline of a building, not a Point"
    assert caught.value.hint


def test_swapped_latitude_and_longitude_are_noticed(write_map: WriteMap, frame: LocalFrame, square: Square) -> None:
    ring = [[y, x] for x, y in square(0, 0)["coordinates"][0]]
    path = write_map(({"type": "Polygon", "coordinates": [ring]}, {"building": "yes"}))
    with refuses("too-far", "map.geojson", "100"):
        stand(path, frame)


@pytest.mark.parametrize(
    ("mode", "altitude", "extrude", "top"),
    [
        ("relativeToGround", 25, 1, 25.0),
        ("absolute", 540, 1, 40.0),  # home is at 500 m
        ("relativeToGround", 25, 0, None),
        ("clampToGround", 25, 1, None),
    ],
)
def test_a_polygon_of_a_kml_drawn_down_to_the_ground_is_as_high_as_it_says(
    tmp_path: Path, frame: LocalFrame, mode: str, altitude: float, extrude: int, top: float | None
) -> None:
    ring = " ".join(f"{8 + x},{47 + y},{altitude}" for x, y in [(0, 0), (0.001, 0), (0.001, 0.001), (0, 0)])
    path = tmp_path / "hall.kml"
    path.write_text(
        f"<kml><Placemark><name>hall</name><Polygon><extrude>{extrude}</extrude><altitudeMode>{mode}</altitudeMode>"
        f"<outerBoundaryIs><LinearRing><coordinates>{ring}</coordinates></LinearRing></outerBoundaryIs>"
        "</Polygon></Placemark></kml>"
    )
    buildings = search_buildings(path, BuildingRules(), frame)
    raised = raise_obstacles(buildings.obstacles, Ground(Flat(3.0)))
    if top is None:
        assert not raised
        assert [thing.may_be_obstacle for thing in buildings.passed_over] == [True]
    else:
        (hall,) = raised
        assert hall.bounds[:, 2] == pytest.approx([3.0, top + 3.0 * (mode == "relativeToGround")], abs=0.01)


class Ridge:
    """30 m high along east 50, and level 60 m away."""

    def height(self, points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return np.asarray(30.0 * np.clip(1.0 - np.abs(points[:, 0] - 50.0) / 60.0, 0.0, 1.0))


def test_ground_between_level_corners_raises_a_long_hall(
    write_map: WriteMap, frame: LocalFrame, square: Square
) -> None:
    ring = [(-60.0, 0.0), (300.0, 0.0), (300.0, 20.0), (-60.0, 20.0)]  # level at its middle, too
    section = PrismSection.model_validate({"kind": "prism", "footprint": ring, "height": 10.0})
    written = section.build("hall", frame, Ground(Ridge()))
    buildings = search_buildings(
        write_map((square(-60.0, 0.0, 360.0), {"building": "yes", "height": "10"})), BuildingRules(), frame
    )
    (mapped,) = raise_obstacles(buildings.obstacles, Ground(Ridge()))
    for hall in (written, mapped):
        assert hall.bounds[0, 2] == pytest.approx(0.0, abs=0.01)
        assert hall.bounds[1, 2] == pytest.approx(40.0, abs=1.3)  # places 5 m apart on a slope of 1:2
    assert len(places_under(shapely.box(0.0, 0.0, 19.0, 19.0))) == 0


@pytest.mark.parametrize("quadrant", [(1, 1), (-1, 1), (-1, -1), (1, -1)])
def test_a_hill_under_any_quadrant_raises_a_wide_cylinder(frame: LocalFrame, quadrant: tuple[int, int]) -> None:
    class Hill:
        def height(self, points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
            away = np.linalg.norm(points[:, :2] - 50.0 * np.array(quadrant), axis=1)
            return np.asarray(np.maximum(20.0 - away, 0.0))

    tank = {"kind": "cylinder", "east": 0.0, "north": 0.0, "radius": 100.0, "height": 10.0}
    top = CylinderSection.model_validate(tank).build("tank", frame, Ground(Hill())).bounds[1, 2]
    assert top == pytest.approx(30.0, abs=3.6)
