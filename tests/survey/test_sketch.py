from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import pytest
import shapely

from ipoa_mission import plan_survey, read_scenario
from ipoa_mission.errors import BadInput
from ipoa_mission.ground import Ground
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.flown_coverage import Overlaps, lines_of_tour, photo_places, smallest_overlaps
from ipoa_mission.survey.survey_task import SurveySketch, sketch_survey, survey_bound
from ipoa_mission.survey.tour import Tour
from tests.refused import refuses

FIELD = [[[20.0, 10.0], [220.0, 10.0], [220.0, 160.0], [20.0, 160.0]], [[60, 40], [90, 40], [90, 70], [60, 70]]]
HOME = {"latitude_deg": 47.3977, "longitude_deg": 8.5456, "altitude_amsl": 488.0}


def scenario(*, wind: Mapping[str, object] | None = None, **survey: object) -> Scenario:
    section = {"polygon": FIELD, "height_above_ground": 40.0, "direction_deg": 90.0} | survey
    return Scenario.from_dict(
        {"home": HOME, "survey": section, "vehicle": {"cruise_speed": 8.0}, "wind": dict(wind or {})}
    )


@pytest.fixture(scope="module")
def photographed() -> Scenario:
    return scenario(camera="DJI Mavic 3E", side_overlap=0.6, front_overlap=0.7)


def test_a_sketch_has_the_lines_of_the_plan_and_takes_no_longer(photographed: Scenario) -> None:
    sketch, survey = sketch_survey(photographed), plan_survey(scenario=photographed)
    assert [tuple(s.begin) + tuple(s.end) for s in sketch.tour.swaths] == [
        tuple(s.begin) + tuple(s.end) for s in survey.plan.tour.swaths
    ]
    assert sketch.coverage.share == survey.plan.coverage.share > 0.999
    assert 0.65 * survey.total_s < sketch.seconds < survey.total_s  # without take-off and ways from and to home


def test_the_bound_is_that_of_the_strongest_wind() -> None:
    calm, steady, uncertain, profile = (
        survey_bound(scenario(wind=wind, line_spacing=30.0))
        for wind in (
            {},
            {"speed": 6.0},
            {"speed": 4.0, "spread": 2.0},
            {"heights": [0.0, 100.0], "speeds": [2.0, 6.0], "directions": [0.0, 0.0]},
        )
    )
    assert steady.lateral > calm.lateral
    assert uncertain == profile == steady


def test_unflyable_sketches_are_refused_as_the_plan_refuses_them() -> None:
    low = scenario(line_spacing=20.0, height_above_ground=1.0)
    for ask in (sketch_survey, lambda scenario: plan_survey(scenario=scenario)):
        with refuses("survey-too-low", "survey", kind=NoPath):
            ask(low)
    with refuses("missing", "survey", kind=BadInput):
        sketch_survey(read_scenario("missions/sitl.toml"))


def test_overlaps_are_those_of_the_photos_as_rectangles(photographed: Scenario) -> None:
    sketch = sketch_survey(photographed)
    sight, smallest = sketch.sight, overlaps(sketch, sketch.tour)
    photo = sight.across * sight.along
    front = 1.0
    for swath in sketch.tour.swaths:
        places = photo_places(swath, sight)
        assert len(places) == sight.triggering(swath.length)[1]
        boxes = [shapely.box(e - sight.along / 2, 0.0, e + sight.along / 2, sight.across) for e, _ in places]
        front = min(front, *(first.intersection(second).area / photo for first, second in pairwise(boxes)))
    assert smallest.front is not None
    assert smallest.front.share >= 0.7 - 1e-9
    assert smallest.front.share == pytest.approx(front, abs=2 * sight.lag / sight.along)  # lines lie from west to east
    rows = np.unique([round(float(swath.begin[1]), 3) for swath in sketch.tour.swaths])
    strips = [shapely.box(0.0, north - sight.across / 2, 1.0, north + sight.across / 2) for north in rows]
    sides = [first.intersection(second).area / sight.across for first, second in pairwise(strips)]
    assert smallest.side is not None
    assert smallest.side.share == pytest.approx(min(sides), abs=1e-3)
    assert smallest.side.share >= 0.6 - 1e-9


def test_a_line_that_is_left_out_shows_in_the_smallest_overlap(photographed: Scenario) -> None:
    sketch = sketch_survey(photographed)
    rows = sorted({round(float(swath.begin[1]), 3) for swath in sketch.tour.swaths})
    left = [swath for swath in sketch.tour.swaths if round(float(swath.begin[1]), 3) != rows[-3]]
    smallest = overlaps(sketch, Tour.of(left, [np.array([a.end, b.begin]) for a, b in pairwise(left)])).side
    assert smallest is not None
    assert smallest.share == pytest.approx(1 - (rows[-2] - rows[-4]) / sketch.sight.across, abs=1e-3)
    assert rows[-4] - 1 < smallest.at[1] < rows[-2] + 1


def test_overlap_needs_a_camera() -> None:
    sketch = sketch_survey(scenario(line_spacing=20.0))
    assert overlaps(sketch, sketch.tour) == Overlaps(None, None)
    assert len(photo_places(sketch.tour.swaths[0], sketch.sight)) == 0


def overlaps(sketch: SurveySketch, tour: Tour) -> Overlaps:
    ground = Ground()
    return smallest_overlaps([*lines_of_tour(tour, sketch.sight, ground)], sketch.sight, ground, sketch.area.shape)
