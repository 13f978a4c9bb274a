import math
from typing import Any

import numpy as np
import shapely

from ipoa_mission import Command
from ipoa_mission.geometry import Points
from ipoa_mission.mission.complex_items import ITEMS, TRANSECTS, complex_item
from ipoa_mission.mission.items import ComplexItem, Mission
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.tour import Tour

MANUAL_CAMERA, CUSTOM_CAMERA = "Manual (no camera specs)", "Custom Camera"
ABOVE_HOME = 1
VERSIONS = {"survey": 5, "CorridorScan": 2}


def survey_item(mission: Mission, first: int, last: int, tour: Tour, sight: Sight, scenario: Scenario) -> ComplexItem:
    section, area = scenario.survey, scenario.survey_area
    assert section is not None
    assert area is not None
    items = mission.items[first : last + 1]
    begin, end = tour.swaths[0].begin, tour.swaths[0].end
    angle = math.degrees(math.atan2(*(end - begin).tolist()))
    middles = section.middles(scenario.frame)
    kind = "CorridorScan" if middles else "survey"
    entry: dict[str, Any] = {
        TRANSECTS: {
            "CameraCalc": _camera(sight, scenario),
            "CameraShots": sight.photos_of(tour),
            "CameraTriggerInTurnAround": False,
            "HoverAndCapture": False,
            ITEMS: [],
            "Refly90Degrees": False,
            "TurnAroundDistance": 0,
            "VisualTransectPoints": [
                [item.latitude_deg, item.longitude_deg] for item in items if item.command == Command.NAV_WAYPOINT
            ],
            "version": 2,
        },
        "complexItemType": kind,
        "type": "ComplexItem",
        "version": VERSIONS[kind],
    }
    if middles:
        entry |= {"CorridorWidth": section.width, "EntryPoint": 0, "polyline": _degrees(middles[0], scenario)}
    else:
        outer = max(area.shape.geoms, key=lambda part: part.intersection(_lines(tour)).length)
        entry |= {
            "angle": round(90.0 - (90.0 - angle) % 180.0, 3),
            "entryLocation": 0,
            "flyAlternateTransects": False,
            "polygon": _degrees(shapely.get_coordinates(outer.exterior)[:-1], scenario),
            "splitConcavePolygons": False,
        }
    return complex_item(items, entry)


def _camera(sight: Sight, scenario: Scenario) -> dict[str, Any]:
    section = scenario.survey
    assert section is not None
    entry: dict[str, Any] = {
        "AdjustedFootprintFrontal": round(sight.trigger or 0.0, 2),
        "AdjustedFootprintSide": round(sight.spacing, 3),
        "CameraName": MANUAL_CAMERA,
        "DistanceMode": ABOVE_HOME,
        "DistanceToSurface": round(sight.least, 3),
        "version": 2,
    }
    if (camera := section.taken_by) is None or sight.trigger is None:
        return entry
    return entry | {
        "CameraName": CUSTOM_CAMERA,
        "FixedOrientation": False,
        "FocalLength": camera.focal_length,
        "FrontalOverlap": round(100.0 * sight.overlaps[0], 3),
        "ImageDensity": round(100.0 * camera.sensor[0] / camera.pixels[0] * sight.least / camera.focal_length, 6),
        "ImageHeight": camera.pixels[1],
        "ImageWidth": camera.pixels[0],
        "Landscape": True,
        "MinTriggerInterval": 0,
        "SensorHeight": camera.sensor[1],
        "SensorWidth": camera.sensor[0],
        "SideOverlap": round(100.0 * sight.overlaps[1], 3),
        "ValueSetIsDistance": True,
    }


def _degrees(places: Points, scenario: Scenario) -> list[list[float]]:
    latitude, longitude, _ = scenario.frame.to_geodetic(np.column_stack([places, np.zeros(len(places))]))
    return [[round(float(a), 7), round(float(b), 7)] for a, b in zip(latitude, longitude, strict=True)]


def _lines(tour: Tour) -> Any:
    return shapely.multilinestrings([[swath.begin, swath.end] for swath in tour.swaths])
