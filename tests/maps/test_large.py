import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps import buildings
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from ipoa_mission.maps.passed import MOST_NAMED, PassedOver, count_passed_over
from ipoa_mission.scenario import parse_scenario, surroundings
from tests.examples import some

WITHIN: Box = (np.array([-150.0, -100.0]), np.array([200.0, 120.0]))
AREAS: dict[str, list[dict[str, Any]]] = {
    "OpenStreetMap": [
        {"building": "yes"}, {"building": "house", "height": "12 m"}, {"building": "yes", "height": "high"},
        {"building": "no"}, {"building": "yes", "building:levels": "3", "min_height": "2"}, {"landuse": "forest"},
        {"leisure": "park"}, {"building": "yes", "height:amsl": "540"}, {}, {"operator": "somebody"},
        {"building": "yes", "relations": [{"type": "Feature"}, {"type": "Feature"}]},
    ],
    "cadastre": [{"height": 9}, {"height": None}, {"class": "x", "height": 3}, {}],
    "Overture": [{"height": None, "num_floors": 4}, {"has_parts": False}, {"height": 5, "is_underground": True}],
}  # fmt: skip
THIN = [
    {"natural": "tree"}, {"man_made": "mast", "height": "44"}, {"power": "line", "voltage": "110000"},
    {"power": "cable"}, {"barrier": "wall", "width": "1"}, {"aerialway": "gondola"}, {"highway": "path"},
]  # fmt: skip
TAKEN: list[dict[str, Any]] = [{}, {"take": "all"}, {"take": "tagged"}, {"line_height": 0.0}, {"wood_height": 20.0}]
At = Callable[[float, float], list[float]]


def generated(seed: int, at: At) -> dict[str, Any]:
    """A map of one writer, most of it away from home."""
    rng = random.Random(seed)
    writer = rng.choice(list(AREAS))
    spread = rng.choice([100.0, 500.0, 3000.0, 150_000.0])
    features = []
    for number in range(rng.choice([4, 20, 60])):
        east, north = (0.0, 30.0) if not number else (rng.gauss(0, spread), rng.gauss(0, spread))
        a, b, c, d = at(east, north), at(east + 20, north), at(east + 20, north + 15), at(east, north + 15)
        tags = rng.choice(AREAS[writer])
        kind, coordinates = rng.choice(
            [
                ("Polygon", [[a, b, c, d, a]]),
                ("Polygon", [[a, b, c, a]]),
                ("Polygon", [[a, c, b, d, a]]),
                ("MultiPolygon", [[[a, b, c, a]], [[a, at(east - 30, north), at(east - 30, north - 9), a]]]),
                ("LineString", [a, b, c, d, a]),
            ]
        )
        if writer == "OpenStreetMap" and rng.random() < 0.3:
            tags = rng.choice(THIN)
            kind, coordinates = rng.choice([("Point", a), ("LineString", [a, at(east + 300, north)])])
        geometry = None if rng.random() < 0.05 else {"type": kind, "coordinates": coordinates}
        feature = {"type": "Feature", "properties": {"name": f'"}},{number}'} | tags, "geometry": geometry}
        features.append(feature if rng.random() < 0.7 else dict(sorted(feature.items())))
    if writer == "cadastre" and rng.random() < 0.3:
        features.append({"type": "Feature", "properties": {"highway": "path"}, "geometry": None})
    crs = {"crs": {"type": "name", "properties": {"name": "EPSG:4326"}}}
    kinds = {"type": "FeatureCollection"}
    return rng.choice([kinds | {"features": features}, {"features": features} | kinds | crs])


def in_batches(path: Path, around: MapWindow) -> Iterator[tuple[Feature, ...]]:
    features = read_features(path, around)
    return (features[n : n + 5] for n in range(0, len(features), 5))


@pytest.mark.parametrize("seed", some(10, range(240)))
def test_near_and_counted_features_are_those_of_the_whole_map(
    seed: int, tmp_path: Path, frame: LocalFrame, at: At, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps(generated(seed, at), indent=seed % 2))
    rules = BuildingRules(**TAKEN[seed % len(TAKEN)])
    whole = search_buildings(path, rules, frame)
    monkeypatch.setattr(buildings, "read_batches", in_batches)
    near = search_buildings(path, rules, frame, WITHIN)
    assert near.remarks == whole.remarks
    assert list(count_passed_over(near.passed_over, near.left_out)) == list(count_passed_over(whole.passed_over))
    assert (near.features, len(near.obstacles) + near.beyond) == (whole.features, len(whole.obstacles))
    np.testing.assert_array_equal(near.box, whole.box)

    def nearby(thing: Any) -> bool:
        west, south, east, north = thing.shape.bounds
        reach = getattr(thing, "reach", 0.0)
        lower, upper = (WITHIN[0] - reach, WITHIN[1] + reach)
        return bool(west <= upper[0] and south <= upper[1] and east >= lower[0] and north >= lower[1])

    kept = {(s.name, s.shape.wkb) for s in near.obstacles}
    assert [s for s in near.obstacles if nearby(s)] == [s for s in whole.obstacles if nearby(s)]
    assert len([s for s in near.obstacles if not nearby(s)]) <= MOST_NAMED
    assert [(s.name, s.shape.wkb) in kept for s in whole.obstacles if not nearby(s)][:MOST_NAMED].count(False) == 0
    assert _doubtful(near.passed_over, nearby) == _doubtful(whole.passed_over, nearby)


def _doubtful(things: tuple[PassedOver, ...], nearby: Callable[[Any], bool]) -> list[tuple[str, str, str]]:
    return [
        (thing.name, thing.reason, thing.shape.wkt)
        for thing in things
        if thing.may_be_obstacle and not thing.shape.is_empty and nearby(thing)
    ]


def test_faults_far_away_are_remarked_too(tmp_path: Path, frame: LocalFrame, at: At) -> None:
    features = [
        {"type": "Feature", "properties": {"building": "yes"}, "geometry": {"type": "Point", "coordinates": at(n, 0)}}
        for n in range(0, 9000, 300)
    ]
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    with pytest.raises(BadInput) as caught:
        search_buildings(path, BuildingRules(), frame, WITHIN)
    lines = str(caught.value).splitlines()
    assert (len(lines), lines[-1]) == (11, "and 20 more of this kind")
    assert lines[9].startswith(f"{path}: features[9].geometry: expected the outline of a building")


def test_buildings_that_draw_the_bounds_far_away_have_the_map_read_again(
    tmp_path: Path, at: At, monkeypatch: pytest.MonkeyPatch
) -> None:
    def block(west: float, east: float) -> dict[str, Any]:
        ring = [at(west, 20), at(east, 20), at(east, 30), at(west, 30), at(west, 20)]
        return {
            "type": "Feature",
            "properties": {"building": "yes"},
            "geometry": {"type": "Polygon", "coordinates": [ring]},
        }

    wall, behind, far = block(60, 3000), block(3100, 3120), block(3300, 3320)
    (tmp_path / "map.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [behind, wall, far]}))
    text = """
home = { latitude_deg = 47.0, longitude_deg = 8.0, altitude_amsl = 500.0 }
start = { east = 0, north = 0, up = 10 }
goal = { east = 100, north = 0, up = 10 }
maps = [{ kind = "buildings", file = "map.geojson" }]
"""
    twice = parse_scenario(text, tmp_path / "s.toml")
    monkeypatch.setattr(surroundings, "WINDOW_MARGIN", 1e5)
    once = parse_scenario(text, tmp_path / "s.toml")
    for scenario in (twice, once):
        assert len(scenario.airspace.obstacles) == 2
        assert [counted.count for counted in scenario.passed_counts] == [1]
        assert scenario.airspace.bounds.upper[0] == pytest.approx(3050.0, abs=0.5)
    assert twice.remarks == once.remarks
