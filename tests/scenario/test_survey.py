import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.survey.camera import CAMERAS
from ipoa_mission.survey.sight import sight_of
from ipoa_mission.survey.survey_section import surveyed_area
from ipoa_mission.survey.survey_task import expect_survey
from tests.refused import refuses

HOME = {"latitude_deg": 47.4, "longitude_deg": 8.5, "altitude_amsl": 400.0}
SQUARE = [[0.0, 0.0], [100.0, 0.0], [100.0, 80.0], [0.0, 80.0]]
POND = [[20.0, 20.0], [40.0, 20.0], [40.0, 40.0]]
LINES = {"polygon": SQUARE, "line_spacing": 20.0, "height_above_ground": 40.0}


def scenario(survey: Any, folder: Path | str = "") -> Scenario:
    return Scenario.from_dict({"home": HOME, "survey": survey}, folder)


def test_a_survey_takes_the_place_of_start_and_goal() -> None:
    world = scenario(LINES)
    assert world.start_point.tolist() == world.goal_point.tolist() == [0.0, 0.0, 40.0]
    lower, upper = world.airspace.bounds.lower, world.airspace.bounds.upper
    assert lower[0] <= -50.0
    assert upper[0] >= 150.0
    assert upper[2] >= 90.0


@pytest.mark.parametrize("polygon", [[SQUARE, POND], [[SQUARE, POND]]])
def test_holes_are_inner_rings(polygon: Any) -> None:
    area = surveyed_area(scenario(LINES | {"polygon": polygon}))
    assert area is not None
    assert area.shape.area == pytest.approx(8000.0 - 200.0)


def geojson(path: Path, *geometries: dict[str, Any]) -> Path:
    features = [{"type": "Feature", "properties": {}, "geometry": geometry} for geometry in geometries]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def degrees(corners: list[list[float]]) -> list[list[float]]:
    frame = LocalFrame(Geodetic(47.4, 8.5, 400.0))
    latitude, longitude, _ = frame.to_geodetic(np.column_stack([np.array(corners), np.zeros(len(corners))]))
    ring = [[float(a), float(b)] for a, b in zip(longitude, latitude, strict=True)]
    return [*ring, ring[0]]


def test_an_area_comes_from_a_map_with_its_holes(tmp_path: Path) -> None:
    far = [[east + 200.0, north] for east, north in SQUARE]
    polygons = [{"type": "Polygon", "coordinates": [degrees(SQUARE), degrees(POND)]}]
    polygons.append({"type": "Polygon", "coordinates": [degrees(far)]})
    geojson(tmp_path / "field.geojson", *polygons)
    text = f"[home]\nlatitude_deg = 47.4\nlongitude_deg = 8.5\naltitude_amsl = 400\n[survey]\n{KEYS}"
    area = surveyed_area(parse_scenario(text, tmp_path / "field.toml"))
    assert area is not None
    assert [part.area for part in area.shape.geoms] == pytest.approx([7800.0, 8000.0], rel=1e-3)


KEYS = 'area = "field.geojson"\nline_spacing = 20\nheight_above_ground = 40\n'


def test_a_line_with_a_width_is_a_corridor(tmp_path: Path) -> None:
    drawn = scenario({"line": [[0, 0], [100, 0]], "width": 30, "line_spacing": 10, "height_above_ground": 40})
    assert expect_survey(drawn)[1].shape.area == pytest.approx(3000.0)
    line = {"type": "LineString", "coordinates": degrees([[0.0, 0.0], [100.0, 0.0]])[:2]}
    path = geojson(tmp_path / "road.geojson", line)
    mapped = scenario({"area": str(path), "width": 30, "line_spacing": 10, "height_above_ground": 40})
    assert expect_survey(mapped)[1].shape.area == pytest.approx(3000.0, rel=1e-3)


def test_a_camera_says_height_spacing_and_trigger() -> None:
    world = scenario({"polygon": SQUARE, "camera": "sony a6000 16mm", "gsd_cm": 2.0, "side_overlap": 0.6})
    survey, area = expect_survey(world)
    assert survey.height == pytest.approx(2.0 / 100 * 16.0 / (23.5 / 6000))  # the wider of both pitches
    sight = sight_of(survey, area, world)
    assert sight.spacing == pytest.approx(0.4 * 23.5 / 16.0 * survey.height)
    assert sight.trigger == pytest.approx(0.3 * 15.6 / 16.0 * survey.height)
    assert all(camera.footprint(50.0)[0] >= camera.footprint(50.0)[1] for camera in CAMERAS.values())


BOW = [[0.0, 0.0], [100.0, 80.0], [100.0, 0.0], [0.0, 80.0]]
NUMBERS = {"sensor_mm": [23.5, 15.6], "focal_length_mm": 16.0, "pixels": [6000, 4000]}
PHOTOS = {"polygon": SQUARE, "camera": NUMBERS, "height_above_ground": 40.0}


@pytest.mark.parametrize(
    ("survey", "words"),
    [
        (LINES | {"polygon": BOW}, ("invalid-ring", "survey.polygon", "50", "40")),
        (LINES | {"polygon": [SQUARE, BOW]}, ("invalid-ring", "survey.polygon[1]")),
        (LINES | {"polygon": [["0", 0], [50, 0], [9, 9]]}, ("invalid-ring", "survey.polygon", "pairs of numbers")),
        (LINES | {"polygon": [[0, 0], [50, True], [9, 9]]}, ("invalid-ring", "survey.polygon", "pairs of numbers")),
        (LINES | {"polygon": SQUARE, "flights": True}, ("bad-input", "survey.flights")),
        (LINES | {"polygon": SQUARE[:2]}, ("invalid-ring", "survey.polygon")),
        (LINES | {"polygon": [[0, 0], [50, 0], [100, 0]]}, ("invalid-ring", "survey.polygon")),
        (LINES | {"polygon": [[0, 0], [50, 0], [float("nan"), 9]]}, ("invalid-ring", "survey.polygon[2]")),
        (LINES | {"polygon": [SQUARE, SQUARE]}, ("invalid-ring", "survey.polygon")),
        (LINES | {"polygon": [SQUARE, POND, [[35, 21], [39, 21], [39, 24]]]}, ("ring-misplaced", "survey.polygon[2]")),
        (LINES | {"polygon": 7}, ("bad-input", "survey.polygon")),
        (LINES | {"polygon": None}, ("bad-input", "survey")),
        (LINES | {"area": "none.geojson"}, ("bad-input", "survey.area")),
        (LINES | {"width": 3}, ("bad-input", "survey")),
        (LINES | {"line_spacing": None}, ("bad-input", "survey", "line_spacing")),
        (LINES | {"gsd_cm": 2}, ("bad-input", "survey", "gsd_cm")),
        (LINES | {"direction_deg": "north"}, ("bad-input", "survey.direction_deg", '"best"', '"crosshatch"')),
        (LINES | {"direction_deg": []}, ("bad-input", "survey.direction_deg")),
        (LINES | {"direction_deg": float("inf")}, ("bad-input", "survey.direction_deg")),
        (LINES | {"line_spacing": 0}, ("bad-input", "survey.line_spacing")),
        (LINES | {"line_spacing": float("nan")}, ("bad-input", "survey.line_spacing")),
        (LINES | {"turns_outside": -1}, ("bad-input", "survey.turns_outside")),
        (LINES | {"height_above_ground": 0}, ("bad-input", "survey.height_above_ground")),
        (LINES | {"shade": 1}, ("unknown-key", "survey.shade")),
        (PHOTOS | {"side_overlap": 1.0}, ("bad-input", "survey.side_overlap", "100 %")),
        (PHOTOS | {"front_overlap": 75}, ("bad-input", "survey.front_overlap", "75", "0.75", "75 %")),
        (
            PHOTOS | {"camera": {k: NUMBERS[k] for k in ("sensor_mm", "pixels")}},
            ("missing", "survey.camera.focal_length_mm"),
        ),
        (PHOTOS | {"camera": NUMBERS | {"focal_length_mm": 0}}, ("bad-input", "survey.camera.focal_length_mm")),
        (PHOTOS | {"camera": "Sony A600"}, ("unknown-name", "survey.camera", "A6000")),
        (PHOTOS | {"gsd_cm": 2}, ("bad-input", "survey", "height_above_ground", "gsd_cm")),
        (PHOTOS | {"line_spacing": 5, "side_overlap": 0.5}, ("bad-input", "survey", "line_spacing", "side_overlap")),
    ],
)
def test_senseless_values_are_named_with_their_place(survey: dict[str, Any], words: tuple[str, ...]) -> None:
    table = {key: value for key, value in survey.items() if value is not None}
    with refuses(*words):
        scenario(table)


def test_senseless_values_of_a_map_are_named_with_their_place(tmp_path: Path) -> None:
    path = geojson(tmp_path / "bow.geojson", {"type": "Polygon", "coordinates": [degrees(BOW)]})
    over = {"area": str(path), "line_spacing": 20.0, "height_above_ground": 40.0}
    with refuses("invalid-ring", "bow.geojson: features[0].geometry[0][0]"):
        scenario(over)
    geojson(path, {"type": "Point", "coordinates": [8.5, 47.4]})
    with refuses("nothing-there", "bow.geojson"):
        scenario(over)
    spot = tmp_path / "spot.osm"
    spot.write_text(
        '<osm><node id="1" lat="47.398" lon="8.546"/><way id="2">'
        + '<nd ref="1"/>' * 4
        + '<tag k="a" v="b"/></way></osm>'
    )
    with refuses("invalid-ring", "spot.osm: way 2.geometry[0][0][0]"):
        scenario(over | {"area": str(spot)})
    geojson(path, {"type": "LineString", "coordinates": degrees(SQUARE)[:3]})
    with refuses("invalid-ring", "bow.geojson: features[0].geometry"):
        scenario(over)
