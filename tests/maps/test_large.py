import json
import random
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from ipoa_mission.maps.passed import PassedOver, count_passed_over
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


def unnumbered(passed: Iterable[PassedOver]) -> list[tuple[object, ...]]:
    """Return the counts without the numbers of features, which differ in a part of a map."""
    return [
        (each.reason, each.may_be_obstacle, each.count, each.code, [name.partition("[")[0] for name in each.names])
        for each in count_passed_over(passed)
    ]


@pytest.mark.parametrize("seed", some(10, range(240)))
def test_a_part_of_a_map_is_read_as_a_map_of_its_own(seed: int, tmp_path: Path, frame: LocalFrame, at: At) -> None:
    path, own = tmp_path / "map.geojson", tmp_path / "own" / "map.geojson"
    document, window = generated(seed, at), MapWindow.of(frame, WITHIN).window
    path.write_text(json.dumps(document, indent=seed % 2))
    assert window is not None
    drawn = [feature.shape for feature in read_features(path)]
    boxes = shapely.bounds(drawn).reshape(-1, 4)
    wanted = window.meets(boxes) | np.isnan(boxes[:, 0])
    part = [each for each, is_near in zip(document["features"], wanted, strict=True) if is_near]
    own.parent.mkdir()
    own.write_text(json.dumps(document | {"features": part}))
    rules = BuildingRules(**TAKEN[seed % len(TAKEN)])
    whole = search_buildings(own, rules, frame)
    near = search_buildings(path, rules, frame, WITHIN)
    assert (near.features, near.elsewhere) == (len(part), len(drawn) - len(part))
    assert [words for words in near.remarks if "not examined" not in words] == list(whole.remarks)
    assert unnumbered(near.passed_over) == unnumbered(whole.passed_over)
    assert [(s.name, s.shape.wkb, s.foot, s.height) for s in near.obstacles] == [
        (s.name, s.shape.wkb, s.foot, s.height) for s in whole.obstacles
    ]


def test_faults_far_away_are_counted_with_the_rest(tmp_path: Path, frame: LocalFrame, at: At) -> None:
    features = [
        {"type": "Feature", "properties": {"building": "yes"}, "geometry": {"type": "Point", "coordinates": at(n, 0)}}
        for n in range(0, 9000, 300)
    ]
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    with pytest.raises(BadInput) as caught:
        search_buildings(path, BuildingRules(), frame, WITHIN)
    lines = str(caught.value).splitlines()
    assert 3 < len(lines) < 10
    assert lines[2].startswith(f"{path}: features[2].geometry: expected the outline of a building")
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features[-3:]}))
    assert search_buildings(path, BuildingRules(), frame, WITHIN).elsewhere == 3


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
