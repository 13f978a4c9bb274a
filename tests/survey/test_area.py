import json
import math
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.survey.survey_area import Area, read_map, shapes_in
from tests.refused import refuses

SQUARE = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]


def square(west: float, south: float, side: float) -> list[tuple[float, float]]:
    return [(west, south), (west + side, south), (west + side, south + side), (west, south + side)]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([], ("invalid-ring", "field")),
        ([[]], ("invalid-ring", "field[0]")),
        ([[[(0.0, 0.0), (1.0, 0.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), (9.0, 0.0), (0.0, 0.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), (9.0, math.nan), (9.0, 9.0)]]], ("invalid-ring", "field[0][0][1]")),
        ([[[(0.0, 0.0), (9.0, 0.0), (9.0, 0.0), (9.0, 9.0)]]], ("invalid-ring", "field[0][0][2]")),
        ([[[(0.0, 0.0), (9.0, 9.0), (9.0, 0.0), (0.0, 9.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), (5.0, 5.0), (9.0, 9.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0), ("a", 5.0), (9.0, 9.0)]]], ("invalid-ring", "field[0][0]")),
        ([[[(0.0, 0.0, 1.0), (9.0, 5.0, 1.0), (9.0, 9.0, 1.0)]]], ("invalid-ring", "field[0][0]")),
        ([[SQUARE, square(-10.0, -10.0, 200.0)]], ("invalid-ring", "field[0]")),
        ([[SQUARE, square(200.0, 0.0, 10.0)]], ("ring-misplaced", "field[0][1]")),
        ([[SQUARE, square(10.0, 10.0, 50.0), square(20.0, 20.0, 10.0)]], ("ring-misplaced", "field[0][2]")),
        ([[SQUARE, square(10.0, 10.0, 50.0)], [square(20.0, 20.0, 10.0)]], ("ring-misplaced", "field[1]")),
        ([[SQUARE, [(40.0, -9.0), (60.0, -9.0), (60.0, 109.0), (40.0, 109.0)]]], ("invalid-ring", "field[0]")),
        ([[SQUARE], [square(50.0, 50.0, 100.0)]], ("ring-misplaced", "field[1]")),
    ],
)
def test_wrong_areas_are_named(parts: list[list[list[tuple[float, float]]]], words: tuple[str, ...]) -> None:
    with refuses(*words):
        Area.of(parts, "field")


def test_rings_may_be_closed_and_turn_either_way() -> None:
    there, back = Area.of([[[*SQUARE, SQUARE[0]]]]), Area.of([[SQUARE[::-1]]])
    assert there.shape.area == back.shape.area == 10_000.0


def map_of(folder: Path, *features: tuple[dict[str, Any] | None, dict[str, Any]]) -> Path:
    listed = [{"type": "Feature", "geometry": shape, "properties": properties} for shape, properties in features]
    path = folder / "field.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": listed}))
    return path


def point(east_deg: float) -> dict[str, Any]:
    return {"type": "Point", "coordinates": [8.0 + east_deg, 47.0]}


FRAME = LocalFrame(Geodetic(47.0, 8.0, 0.0))


def test_a_point_with_a_radius_is_an_area(tmp_path: Path) -> None:
    area = read_map(map_of(tmp_path, (point(0.001), {"radius": "50 m"})), None, FRAME)
    assert area.shape.area == pytest.approx(math.pi * 50.0**2, rel=0.01)


def test_what_is_no_area_of_a_map_is_reported(tmp_path: Path) -> None:
    corners = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.0]]
    field = {"type": "Polygon", "coordinates": [corners]}
    path = map_of(tmp_path, (field, {}), (point(0.0), {}), (point(5.0), {}), (None, {"name": "a gap"}))
    shapes, unread = shapes_in(path, FRAME)
    assert [shape.geom_type for _, shape in shapes] == ["Polygon"]
    assert [(thing.what, thing.place) for thing in unread] == [
        ("a point", "features[1]"),
        ("more than 100 km from home", "features[2]"),
        ("without a geometry", "features[3]"),
    ]


def test_a_point_of_unknown_size_is_refused(tmp_path: Path) -> None:
    with refuses("bad-input", "features[0]", "range_km"):
        read_map(map_of(tmp_path, (point(0.0), {"range_km": "3"})), None, FRAME)
