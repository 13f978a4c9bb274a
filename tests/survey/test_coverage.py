import math
from itertools import pairwise

import numpy as np
import pytest
import shapely

from ipoa_mission.survey.flown_coverage import coverage
from ipoa_mission.survey.survey_area import Area
from ipoa_mission.survey.tour import Swath, Tour

AREA = Area.of([[[(0.0, 0.0), (100.0, 0.0), (100.0, 20.0), (0.0, 20.0)]]])


def along(*places: tuple[float, float]) -> Tour:
    swaths = [Swath(np.array(a), np.array(b)) for a, b in pairwise(places)]
    return Tour.of(swaths, [np.array([swath.end, swath.end]) for swath in swaths[:-1]])


def test_the_ends_of_a_line_are_round() -> None:
    covered = coverage(AREA, along((20.0, 10.0), (80.0, 10.0)), 20.0)
    assert covered.seen.area == pytest.approx(60.0 * 20.0 + math.pi * 100.0, rel=1e-3)
    assert covered.share == pytest.approx(covered.seen.area / 2000.0)
    assert covered.gaps.area == pytest.approx(2000.0 - covered.seen.area)


def test_areas_that_cannot_be_covered_are_not_required() -> None:
    house = shapely.box(40.0, -50.0, 60.0, 50.0)
    covered = coverage(AREA, along((0.0, 10.0), (40.0, 10.0), (60.0, 10.0), (100.0, 10.0)), 6.0, house)
    assert covered.share == pytest.approx(6.0 / 20.0)  # also up to 3 m inside of the house
    assert covered.outside_m == pytest.approx(10.0, abs=0.1)  # through the middle of the house


@pytest.mark.parametrize(("path", "away"), [(((0.0, 10.0), (100.0, 10.0)), 0.0), (((10.0, 10.0), (10.0, 27.0)), 7.0)])
def test_path_s_distance_outside_the_area_is_measured(path: tuple[tuple[float, float], ...], away: float) -> None:
    assert coverage(AREA, along(*path), 10.0).outside_m == pytest.approx(away, abs=0.05)


def test_a_path_across_a_hole_is_outside_there() -> None:
    hole = [(40.0, 5.0), (50.0, 5.0), (50.0, 15.0), (40.0, 15.0)]
    area = Area.of([[[(0.0, 0.0), (100.0, 0.0), (100.0, 20.0), (0.0, 20.0)], hole]])
    assert coverage(area, along((0.0, 10.0), (100.0, 10.0)), 20.0).outside_m == pytest.approx(5.0, abs=0.1)
