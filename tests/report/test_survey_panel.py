import re
from functools import reduce
from pathlib import Path

import numpy as np
import pytest
import shapely

from ipoa_mission import plan_survey
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.survey_report import survey_layers, survey_panel

HOME = {"latitude_deg": 47.3977, "longitude_deg": 8.5456, "altitude_amsl": 488.0}
FIELD = [[[20.0, 10.0], [120.0, 10.0], [120.0, 90.0], [20.0, 90.0]], [[60, 40], [80, 40], [80, 60], [60, 60]]]


def area_of(path: str) -> float:
    """The area that a path encloses, its inner rings left out."""
    rings = (re.findall(r"([-\d.]+) ([-\d.]+)", ring) for ring in path.split("Z") if ring)
    return reduce(shapely.symmetric_difference, (shapely.Polygon(np.array(ring, float)) for ring in rings)).area


def test_shaded_is_what_is_seen_and_flights_have_their_colors() -> None:
    asked = {"polygon": FIELD, "line_spacing": 15.0, "height_above_ground": 40.0, "flights": 2}
    survey = plan_survey(scenario=Scenario.from_dict({"home": HOME, "survey": asked}))
    layers = survey_layers(survey.plan)
    whole, seen = map(area_of, re.findall(r'<path style="fill:currentColor[^"]*" d="([^"]*)"', layers.svg))
    assert whole == pytest.approx(100.0 * 80.0 - 20.0 * 20.0)
    assert seen == pytest.approx(survey.plan.coverage.seen.area, rel=0.002)
    on_map = list(dict.fromkeys(re.findall(r"stroke:(hsl\([^)]*\))", layers.svg)))
    assert on_map == re.findall(r"color:(hsl\([^)]*\))\">━", survey_panel(survey.plan, survey.names))
    assert len(on_map) == 2
    (west, south), (east, north) = layers.around
    assert west < 20.0 < 120.0 < east
    assert south < 10.0 < 90.0 < north
    page = next(iter(survey._pages(Path()).values()))
    assert layers.svg in page
    assert page.count('role="img" aria-label="map of the flight') == 1
