from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points, polyline_length
from ipoa_mission.ground import FLAT_GROUND
from ipoa_mission.survey.resume import rest_of_tour
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.survey_plan import SurveyPlan, plan_flights, rest_of
from ipoa_mission.survey.tour import Swath, Tour
from tests.examples import some
from tests.refused import refuses
from tests.survey.test_flights import FIELD, LINES, PHOTOS, TOWER, scenario


def flown_of(plan: SurveyPlan, flight: int) -> Any:
    """Return a flight's path, east, north, up (n, 3)."""
    return plan.flights[flight].forecast.estimate.track.points


def seen(legs: list[Any], width: float) -> Any:
    return shapely.union_all([shapely.LineString(leg).buffer(width / 2, quad_segs=32) for leg in legs])


@pytest.mark.parametrize("share", [0.3, 0.62])
def test_a_flight_that_is_broken_off_is_gone_on_with(share: float) -> None:
    plan = plan_flights(scenario(PHOTOS, obstacles=[TOWER]))
    path = flown_of(plan, 0)
    path = path[: int(share * len(path))]
    rest = rest_of(plan, [path])
    first, *others = rest.tour.swaths
    lines = {(*swath.begin, *swath.end): n for n, swath in enumerate(plan.tour.swaths)}
    at = [lines[(*swath.begin, *swath.end)] for swath in others]  # whole ones
    assert at == [*range(at[0], len(lines))]
    begun = plan.tour.swaths[at[0] - 1]
    assert (first.end == begun.end).all()
    again = max(plan.sight.trigger or 0.0, plan.sight.along / 2)
    left_at = path[-1, :2]
    if shapely.LineString([begun.begin, begun.end]).distance(shapely.Point(left_at)) < 1.0:
        assert np.linalg.norm(first.begin - left_at) == pytest.approx(again, abs=2.0)
    legs = [path[:, :2], *([swath.begin, swath.end] for swath in rest.tour.swaths)]
    area = shapely.Polygon(FIELD).difference(plan.keep_out)
    unbroken = area.intersection(seen([flown_of(plan, 0)[:, :2]], plan.sight.spacing)).area  # corners are cut
    assert area.intersection(seen(legs, plan.sight.spacing)).area > unbroken - 5e-4 * area.area > 0.99 * area.area
    (forecast,) = (flight.forecast for flight in rest.flights)
    assert not forecast.guarantee.forbidding
    assert rest.photos < plan.photos


def test_rest_between_two_flights_is_one_flight() -> None:
    plan = plan_flights(scenario(LINES | {"flights": 3}, obstacles=[TOWER]))
    rest = rest_of(plan, [flown_of(plan, 0), flown_of(plan, 2)])
    second = plan.flights[1].tour.swaths
    left, all_of_it = (sum(swath.length for swath in swaths) for swaths in (rest.tour.swaths, second))
    assert left == pytest.approx(all_of_it, rel=0.02)
    assert {(*swath.begin, *swath.end) for swath in rest.tour.swaths} <= {(*s.begin, *s.end) for s in second}
    ends = rest_of(plan, [flown_of(plan, 1)])
    every = sum(swath.length for swath in plan.tour.swaths)
    assert sum(swath.length for swath in ends.tour.swaths) == pytest.approx(every - all_of_it, rel=0.02)
    assert plan.keep_out is not None
    assert not shapely.LineString(ends.tour.path).intersects(plan.keep_out.buffer(-0.05))
    assert polyline_length(ends.tour.path) < polyline_length(plan.tour.path)  # the last way skips the flown part


def test_only_what_was_flown_along_and_high_enough_counts() -> None:
    plan = plan_flights(scenario(LINES))
    whole, path = [swath.length for swath in plan.tour.swaths], flown_of(plan, 0)
    low = path - np.array([0.0, 0.0, 10.0])
    beside = path + np.array([0.0, 7.0, 0.0])
    across, back = np.column_stack([path[:, 1], path[:, 0], path[:, 2]]), path[::-1]
    for flight in (low, beside, across, back):
        left = rest_of(plan, [flight]).tour.swaths
        assert sum(swath.length for swath in left) > 0.98 * sum(whole)


@pytest.mark.parametrize("obstacles", some(1, [[], [TOWER]]))
def test_a_survey_that_is_flown_is_done(obstacles: list[Any]) -> None:
    plan = plan_flights(scenario(LINES, obstacles=obstacles))
    with refuses("nothing-left", "survey", kind=BadInput):
        rest_of(plan, [flown_of(plan, 0)])


def test_short_lines_round_a_tower_that_were_not_flown_are_left() -> None:
    plan = plan_flights(scenario(LINES | {"line_spacing": 12.0, "direction_deg": 0.0}, obstacles=[TOWER]))
    lengths = [swath.length for swath in plan.tour.swaths]
    short = [n for n, length in enumerate(lengths) if length < 5.0]
    assert len(short) > 15
    path = flown_of(plan, 0)
    away = np.hypot(path[:, 0] - 110.0, path[:, 1] - 80.0)
    left = rest_of(plan, [path[away > 25.0]]).tour.swaths  # as if it had gone straight on there
    assert sum(swath.length for swath in left) > 0.9 * sum(lengths[n] for n in short)


def test_a_place_between_two_flown_lines_is_not_flown_again() -> None:
    at = [np.array(place) for place in ([0.0, 0.0], [100.0, 0.0], [110.0, 10.0], [100.0, 20.0], [0.0, 20.0])]
    swaths = (Swath(at[0], at[1]), Swath(at[2], at[2]), Swath(at[3], at[4]))
    tour = Tour.of(swaths, [np.array(at[1:3]), np.array(at[2:4])])
    sight = Sight(least=40.0, band=0.0, spacing=20.0, trigger=None, across=20.0, along=0.0)
    flat = shapely.get_coordinates(shapely.segmentize(shapely.LineString(tour.path), 1.0))
    path = np.column_stack([flat, np.full(len(flat), 40.0)])

    def left(flown: Points) -> Tour | None:
        return rest_of_tour(tour, [flown], sight, FLAT_GROUND, lambda a, b: np.array([a, b]))

    assert left(path) is None
    passed_by = np.concatenate([path[:101], path[-101:]])
    rest = left(passed_by)
    assert rest is not None
    assert rest.lines.tolist() == [[[110.0, 10.0], [110.0, 10.0]]]
