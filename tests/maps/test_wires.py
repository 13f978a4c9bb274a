from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.ground import FLAT_GROUND
from ipoa_mission.maps.building_rules import BuildingRules, volts_of, wire_of
from ipoa_mission.maps.buildings import Buildings, MapObstacle, raise_obstacles, raise_span, search_buildings
from ipoa_mission.maps.planar import spans

At = Callable[[float, float], list[float]]
WriteMap = Callable[..., Path]
KINDS: list[tuple[dict[str, str], float | None]] = [
    ({"power": "line", "voltage": "110000"}, 40.0),
    ({"power": "line", "voltage": "110000;380000"}, 60.0),
    ({"power": "line", "voltage": "220 kV"}, 50.0),
    ({"power": "line"}, 60.0),
    ({"power": "line", "voltage": "medium"}, 60.0),
    ({"power": "minor_line"}, 15.0),
    ({"power": "minor_line", "voltage": "400"}, 10.0),
    ({"power": "line", "voltage": "20000", "height": "22 m"}, 22.0),
    ({"power": "cable", "location": "overhead"}, 15.0),
    ({"communication": "line"}, 10.0),
    ({"aerialway": "gondola"}, 40.0),
    ({"aerialway": "t-bar"}, 15.0),
    ({"power": "cable"}, None),
    ({"power": "line", "location": "underground"}, None),
    ({"highway": "residential", "name": "Dorfstrasse"}, None),
    ({"aerialway": "magic_carpet"}, None),
]


def find(path: Path, frame: LocalFrame, **rules: Any) -> Buildings:
    return search_buildings(path, BuildingRules(**rules), frame)


@pytest.mark.parametrize(("tags", "height"), KINDS, ids=[str(tags) for tags, _ in KINDS])
@pytest.mark.parametrize("take", [None, "tagged"])
def test_a_line_is_as_high_as_its_kind(
    write_map: WriteMap, frame: LocalFrame, at: At, tags: dict[str, str], height: float | None, take: str | None
) -> None:
    line = {"type": "LineString", "coordinates": [at(0, 0), at(90, 0), at(90, 200)]}
    wires = find(write_map((line, tags)), frame, take=take)
    assert [s.height for s in wires.obstacles] == ([] if height is None else [height, height])  # a wall for each span
    assert bool(wires.remarks) == (height is not None and "height" not in tags)


def test_the_scenario_changes_heights_and_zero_is_nothing(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    def line(north: float) -> dict[str, Any]:
        return {"type": "LineString", "coordinates": [at(0, north), at(90, north)]}

    path = write_map(
        (line(0), {"power": "line"}), (line(50), {"power": "cable"}), (line(99), {"aerialway": "cable_car"})
    )
    changed = find(path, frame, line_height=33.0, aerialway_height=140.0)
    assert [s.height for s in changed.obstacles] == [33.0, 33.0, 140.0]
    nothing = find(path, frame, line_height=0.0, aerialway_height=0.0)
    assert not nothing.obstacles
    assert [thing.may_be_obstacle for thing in nothing.passed_over] == [False, False, False]
    assert {thing.reason for thing in nothing.passed_over} == {
        "line_height = 0 excludes it",
        "aerialway_height = 0 excludes it",
    }


def test_a_wood_is_what_the_scenario_says(write_map: WriteMap, frame: LocalFrame, square: Callable[..., Any]) -> None:
    path = write_map((square(0, 0), {"building": "yes"}), (square(90, 0), {"landuse": "forest"}))
    assert [s.height for s in find(path, frame, wood_height=35.0).obstacles] == [20.0, 35.0]
    for rules, may_be_obstacle in (
        ({}, True),
        ({"take": "all"}, True),
        ({"take": "tagged"}, False),
        ({"wood_height": 0.0}, False),
    ):
        (wood,) = find(path, frame, **rules).passed_over
        assert wood.may_be_obstacle is may_be_obstacle


def test_no_road_and_no_field_becomes_a_wall(write_map: WriteMap, frame: LocalFrame, square: Any, at: At) -> None:
    road = {"type": "LineString", "coordinates": [at(0, 0), at(90, 0)]}
    flat: list[tuple[Any, dict[str, str]]] = [
        (road, {"highway": "residential"}),
        (road, {"railway": "rail"}),
        (square(0, 0), {"landuse": "farmland"}),
        (square(0, 0), {"amenity": "parking"}),
    ]
    buildings = find(write_map((square(50, 50), {"building": "yes"}), *flat), frame, take="all")
    assert len(buildings.obstacles) == 1
    assert len(buildings.passed_over) == 4


@given(
    st.tuples(st.floats(-300, 300), st.floats(-300, 300)),
    st.floats(1.0, 20.0),
    st.floats(1.0, 60.0),
    st.floats(-0.5, 0.5),
    st.floats(-30.0, 30.0),
)
def test_no_rope_sticks_out_of_its_walls(
    end: tuple[float, float], reach: float, height: float, slope: float, hill: float
) -> None:
    span = shapely.LineString([(0.0, 0.0), end])
    if span.length < 1.0:
        return

    def ground(points: np.ndarray) -> np.ndarray:
        away = np.hypot(points[:, 0] - end[0] / 2, points[:, 1] - end[1] / 2)
        return np.asarray(slope * points[:, 0] + hill * np.exp(-((away / 60.0) ** 2)))

    walls = list(raise_span(MapObstacle("line", span, reach, 0.0, height, hangs=True), ground))
    share = np.linspace(0.0, 1.0, 101)
    places = share[:, None] * np.array(end)
    under = ground(places)
    straight = under[0] + share * (under[-1] - under[0])
    rope = np.maximum(under, straight) + height
    for level in (rope - 1.0, under + 0.9):  # as the ground bends between samples
        inside = np.min([wall.distance(np.column_stack([places, level])) for wall in walls], axis=0)
        assert (inside <= 1e-6).all()
    assert len(walls) <= max(span.length // 20, 1)


def test_span_over_level_ground_is_one_wall() -> None:
    line = MapObstacle("line", shapely.LineString([(0, 0), (0, 300)]), 8.0, 0.0, 40.0, hangs=True)
    (wall,) = raise_span(line, FLAT_GROUND)
    assert wall.bounds.tolist() == [[-8.0, -8.0, 0.0], [8.0, 308.0, 40.0]]


def test_every_part_of_a_wire_stands(write_map: WriteMap, frame: LocalFrame, at: At) -> None:
    lines = [[at(0, 0), at(90, 0)], [at(0, 50), at(90, 50), at(90, 50), at(180, 50)]]
    path = write_map(({"type": "MultiLineString", "coordinates": lines}, {"power": "line", "voltage": "110000"}))
    buildings = find(path, frame)
    assert buildings.remarks == ("1 power line of 110 kV without a height, given 40 m (line_height)",)
    assert len(raise_obstacles(buildings.obstacles, FLAT_GROUND)) == 3


def test_repeated_points_of_a_line_make_no_span() -> None:
    there, here = (3.0, 4.0), (9.0, 4.0)
    assert [*spans(shapely.LineString([there, there]))] == []
    assert [*spans(shapely.LineString([there, there, here, here]))] == [shapely.LineString([there, here])]


def test_voltages_are_read_as_mappers_write_them() -> None:
    texts = ("110000", "380000;220000", "20 kV", "0.4kV", "110000;", "high", "", "20 kV;1,100 kV")
    assert [volts_of(text) for text in texts] == [
        110e3, 380e3, 20e3, 400.0, 110e3, None, None, None,
    ]  # fmt: skip
    assert wire_of({"building": "yes"}, BuildingRules()) is None
