"""openstreetmap-carto #4236 (turbines), CityEnergyAnalyst #3218 (est_height), blosm #339 (spellings)."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings

WriteMap = Callable[..., Path]
At = Callable[[float, float], list[float]]
Square = Callable[..., dict[str, Any]]
WIND = {"power": "generator", "generator:source": "wind"}

#: Tags of a point, height and radius [m].
POINTS = [
    (WIND | {"height": "125", "rotor:diameter": "90"}, 125.0, 45.0),
    (WIND | {"height:hub": "80", "rotor:diameter": "90"}, 125.0, 45.0),
    (WIND | {"hub:height": "80 m", "generator:rotor:diameter": "90 m"}, 125.0, 45.0),
    (WIND | {"hub_height": "80", "rotor_diameter": "90"}, 125.0, 45.0),
    (WIND | {"height": "125", "height:hub": "80"}, 125.0, 45.0),
    (WIND | {"height:hub": "80", "rotor:radius": "45"}, 125.0, 45.0),
    (WIND | {"height:hub": "60"}, 120.0, 60.0),  # blades do not reach into the ground
    (WIND, 250.0, 85.0),
    ({"generator:method": "wind_turbine", "height": "30"}, 30.0, 15.0),
    ({"man_made": "tower", "tower:height": "66"}, 66.0, 15.0),
    ({"man_made": "Mast; tower", "Height": "66"}, 66.0, 15.0),
    ({"man_made": "chimney", "height": "66", "diameter": "7"}, 66.0, 3.5),
    ({"disused:man_made": "chimney", "est_height": "66"}, 66.0, 8.0),
    ({"natural": "tree", "height": "22", "diameter": "0.6", "circumference": "1.9"}, 22.0, 5.0),  # of its trunk
    ({"natural": "tree", "height": "22", "diameter_crown": "14"}, 22.0, 7.0),
    ({"natural": "tree", "height": "22", "crown_radius": "7"}, 22.0, 7.0),
    ({"AGL": "66", "AMSL": "60", "TYPE": "POLE"}, 66.0, 3.0),
    ({"building": "no", "man_made": "mast"}, 120.0, 10.0),
]

#: Properties of an area, foot and height [m].
AREAS = [
    ({"building": "yes", "est_height": "30"}, 0.0, 30.0),
    ({"building": "yes", "building:height": "45"}, 0.0, 45.0),
    ({"building": "yes", "height": "12", "building:height": "45"}, 0.0, 45.0),
    ({"building": "yes", "building_levels": "30", "roof_levels": "1"}, 0.0, 93.0),
    ({"BUILDING": "yes", "HEIGHT": "45"}, 0.0, 45.0),
    ({"building": "yes", "building:levels": "G+4"}, 0.0, 15.0),
    ({"building": "yes", "height": "G+4"}, 0.0, 15.0),
    ({"building": "yes", "building:max_level": "4"}, 0.0, 15.0),
    ({"building": "yes", "building:levels": "5", "building:levels:underground": "9"}, 0.0, 15.0),
    ({"building": "yes", "building:levels": "5", "building:min_level": "2"}, 6.0, 15.0),
    ({"building": "yes", "height": "22", "min_height": "somewhere"}, 0.0, 22.0),
    ({"building": "yes", "height": "22", "min_height": "12", "unit": "ft"}, 0.0, 22.0),
    ({"building": "yes", "maxheight": "3"}, 0.0, 20.0),
    ({"building": "yes", "height": "-1"}, 0.0, 20.0),
    ({"building": "yes", "height": "unknown"}, 0.0, 20.0),
    ({"building": "church"}, 0.0, 80.0),
    ({"building": "house"}, 0.0, 12.0),
    ({"BLDGHEIGHT": 45}, 0.0, 45.0),
    ({"measuredHeight": 45}, 0.0, 45.0),
    ({"hauteur": 45.0, "nb_etages": 4}, 0.0, 45.0),
    ({"height_ft": 100}, 0.0, 30.48),
    ({"storeysAboveGround": 5}, 0.0, 15.0),
]


def find(path: Path, frame: LocalFrame) -> Buildings:
    return search_buildings(path, BuildingRules(), frame)


@pytest.mark.parametrize(("tags", "height", "radius"), POINTS, ids=[str(tags) for tags, *_ in POINTS])
def test_a_point_is_as_high_and_wide_as_any_spelling_says(
    write_map: WriteMap, frame: LocalFrame, at: At, tags: dict[str, str], height: float, radius: float
) -> None:
    (thing,) = find(write_map(({"type": "Point", "coordinates": at(0, 0)}, tags)), frame).obstacles
    assert (thing.height, thing.reach) == pytest.approx((height, radius))


@pytest.mark.parametrize(("tags", "foot", "height"), AREAS, ids=[str(tags) for tags, *_ in AREAS])
def test_an_area_is_as_high_as_any_spelling_says(
    write_map: WriteMap, frame: LocalFrame, square: Square, tags: dict[str, Any], foot: float, height: float
) -> None:
    (thing,) = find(write_map((square(0, 0), tags)), frame).obstacles
    assert (thing.foot, thing.height) == pytest.approx((foot, height))


@pytest.mark.parametrize(
    ("tags", "named", "height"),
    [
        ({"building": "yes", "height": "30 cubits"}, "height '30 cubits'", 30.0),
        ({"building": "yes", "height": "5 yojana"}, "height '5 yojana'", 20.0),
        ({"building": "yes", "building:levels": "40 or so"}, "building:levels '40 or so'", 120.0),
        ({"building": "yes", "h_dak_max": 45.0}, "h_dak_max '45.0'", 20.0),
        ({"building": "yes", "height": "12", "Z_MAX": "512"}, "Z_MAX '512'", 12.0),
    ],
)
def test_a_height_that_is_not_understood_is_named_where_it_is(
    write_map: WriteMap, frame: LocalFrame, square: Square, tags: dict[str, Any], named: str, height: float
) -> None:
    buildings = find(write_map((square(0, 0), tags)), frame)
    (thing,) = buildings.obstacles
    (doubt,) = buildings.passed_over
    assert thing.height == height
    assert doubt.code == "not-read"
    assert doubt.may_be_obstacle
    assert named in doubt.reason
    assert doubt.shape.area == pytest.approx(400, rel=1e-3)


def test_a_road_on_a_bridge_is_in_the_air(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    road = {"type": "LineString", "coordinates": [at(0, 0), at(90, 0)]}
    tags = {"highway": "primary", "bridge": "viaduct", "layer": "2"}
    (bridge,) = find(write_map((road, tags), (road, {"highway": "primary", "bridge": "no"})), frame).obstacles
    assert (bridge.height, bridge.reach) == (20.0, 8.0)
