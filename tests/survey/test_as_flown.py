import math

import numpy as np
import pytest
import shapely

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points
from ipoa_mission.survey.flown_coverage import as_flown, predict_lines
from ipoa_mission.survey.survey_flight import plan_survey
from ipoa_mission.survey.survey_plan import rest_of
from ipoa_mission.survey.survey_report import survey_as_json
from tests.survey.test_flights import LINES, scenario

FIELD = shapely.box(0.0, 0.0, 100.0, 20.0)


def flown(*places: tuple[float, float]) -> Track:
    """Straight from one to the next, 1 m/s."""
    points = np.array(places)
    times = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return Track(times, np.column_stack([points, np.zeros(len(points))]), np.ones(len(points)))


def test_coverage_and_the_distance_outside_count_lines_and_no_turns() -> None:
    track = flown((0.0, 5.0), (103.0, 5.0), (103.0, 15.0), (0.0, 15.0))
    both = as_flown([(track, np.array([[0.0, 103.0], [113.0, 216.0]]))], FIELD, FIELD, 10.0)
    assert both.share == pytest.approx(1.0, abs=1e-3)
    assert both.outside_m == pytest.approx(3.0)
    single = as_flown([(track, np.array([[0.0, 60.0]]))], FIELD, FIELD, 10.0)
    assert single.share == pytest.approx((60.0 * 10.0 + math.pi * 25.0 / 2) / 2000.0, rel=2e-3)
    assert single.outside_m == 0.0


def sampled_share(tracks: list[Points], area: shapely.Geometry, width: float) -> float:
    """Return the share of an area near the tracks (n, 2)."""
    west, south, east, north = area.bounds
    places = shapely.points(np.random.default_rng(2).uniform((west, south), (east, north), (20_000, 2)))
    places = places[shapely.covers(area, places)]
    near = shapely.STRtree(shapely.points(np.concatenate(tracks))).query_nearest(
        places, return_distance=True, all_matches=False
    )[1]
    return float((near <= width / 2).mean())


@pytest.mark.parametrize("autopilot", [Autopilot.PX4, Autopilot.ARDUPILOT])
def test_a_flight_cuts_corners_and_flies_past_them(autopilot: Autopilot) -> None:
    plan = plan_survey(scenario=scenario(LINES | {"line_spacing": 5.0, "flights": 2}, autopilot)).plan
    assert plan.flown is not None
    whole = [  # the sensor on between lines
        flight.forecast.predicted(noise_free=True).track.points[:, :2] for flight in plan.flights
    ]
    assert 0.94 < plan.flown.share < plan.coverage.share
    assert plan.flown.share == pytest.approx(sampled_share(whole, plan.area.shape, 5.0), abs=6e-3)
    assert survey_as_json(plan, ("a", "b"))["as_flown"]["covered_share"] == pytest.approx(plan.flown.share, abs=1e-6)


@pytest.mark.parametrize("autopilot", [Autopilot.PX4, Autopilot.ARDUPILOT])
def test_flight_past_corners_stays_in_the_outline(autopilot: Autopilot) -> None:
    plan = plan_survey(scenario=scenario(LINES, autopilot)).plan
    track, ends = predict_lines(plan.flights[0].forecast, plan.tour)
    path = track.between(ends[0, 0], ends[-1, 1]).points
    assert shapely.covers(plan.area.shape, shapely.points(path[:, :2])).all()
    corners = np.array([swath.end for swath in plan.tour.swaths])
    assert shapely.distance(plan.area.shape.boundary, shapely.points(corners)).min() > 0.2
    assert plan.flown is not None
    assert plan.flown.outside_m == 0.0
    assert plan.coverage.share >= 0.999


def test_rest_of_a_survey_has_no_coverage() -> None:
    plan = plan_survey(scenario=scenario(LINES)).plan
    track = plan.flights[0].forecast.expected.track.points
    rest = rest_of(plan, [track[: len(track) // 2]])
    assert rest.flown is None
    assert survey_as_json(rest, ("a",))["as_flown"] is None
