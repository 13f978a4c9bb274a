import math
from functools import cache
from itertools import permutations, product
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Points, polyline_length
from ipoa_mission.mission.items import Mission
from ipoa_mission.survey.cover import CoverProblem, quickest_tour
from ipoa_mission.survey.flown_coverage import coverage
from ipoa_mission.survey.survey_area import Area
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Tour
from tests.examples import examples
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 488.0)
FIELD = [(0.0, 0.0), (120.0, 10.0), (150.0, 90.0), (70.0, 60.0), (10.0, 100.0)]
POND = [(30.0, 20.0), (50.0, 25.0), (40.0, 45.0)]


@cache
def times(which: int = 0) -> LegTimes:
    return LegTimes.of(Mission(HOME, (), registered()[which]), 5.0)


def tour_over(
    area: Area, spacing: float, cost: LegTimes, keep_out: Any = None, turns_outside: float = 0.0, **asked: Any
) -> Tour:
    return quickest_tour(CoverProblem.of(area, spacing, cost, keep_out, turns_outside), **asked)


def sampled(tour: Tour, step: float = 0.25) -> Points:
    return np.concatenate(
        [
            swath.begin
            + np.linspace(0.0, 1.0, max(2, math.ceil(swath.length / step)))[:, None] * (swath.end - swath.begin)
            for swath in tour.swaths
        ]
    )


def share_seen(area: Area, tour: Tour, width: float, keep_out: shapely.Geometry | None = None) -> float:
    """Return the share of coverable places near a place flown over."""
    rng = np.random.default_rng(1)
    west, south, east, north = area.shape.bounds
    places = rng.uniform((west, south), (east, north), (20_000, 2))
    free = area.shape if keep_out is None else area.shape.difference(keep_out)
    points = shapely.points(places)
    places = places[shapely.covers(area.shape, points) & (shapely.distance(free, points) <= width / 2)]
    near = shapely.STRtree(shapely.points(sampled(tour))).query_nearest(
        shapely.points(places), return_distance=True, all_matches=False
    )[1]
    return float((near <= width / 2 + 0.01).mean())


def farthest_outside(area: Area, tour: Tour) -> float:
    """Along all of the path [m]."""
    path = shapely.LineString(tour.path)
    along = shapely.line_interpolate_point(path, np.linspace(0.0, path.length, 5000))
    return float(shapely.distance(area.shape, along).max())


def check_whole(tour: Tour) -> None:
    assert len(tour.transits) == len(tour.swaths) - 1
    for transit, before, after in zip(tour.transits, tour.swaths[:-1], tour.swaths[1:], strict=True):
        assert (transit[0] == before.end).all()
        assert (transit[-1] == after.begin).all()


@st.composite
def areas(draw: st.DrawFn) -> Area:
    """One polygon about its middle, with a triangle or none as a hole."""
    count = draw(st.integers(3, 9))
    radii = draw(st.lists(st.floats(30.0, 120.0), min_size=count, max_size=count))
    first = draw(st.floats(0.0, 6.0))
    turns = first + 2 * math.pi * np.arange(count) / count
    outer = np.column_stack([radii * np.cos(turns), radii * np.sin(turns)])
    if not draw(st.booleans()):
        return Area.of([[outer]])
    return Area.of([[outer, [(-8.0, -4.0), (9.0, -3.0), (2.0, 7.0)]]])


@settings(max_examples=examples(8))
@given(areas(), st.sampled_from([9.0, 15.0, 40.0]))
def test_any_area_is_seen_and_not_left(area: Area, spacing: float) -> None:
    tour = tour_over(area, spacing, cost=times())
    check_whole(tour)
    told = coverage(area, tour, spacing)
    assert told.share >= 0.999
    assert share_seen(area, tour, spacing) == pytest.approx(told.share, abs=2e-3)
    assert told.outside_m == 0.0
    assert farthest_outside(area, tour) == 0.0


@pytest.mark.parametrize("which", [0, 1])
def test_the_same_arguments_give_the_same_tour(which: int) -> None:
    area = Area.of([[FIELD, POND]])
    first, second = (tour_over(area, 12.0, cost=times(which)).path for _ in range(2))
    assert first.tobytes() == second.tobytes()


def test_keep_out_areas_are_seen_into_and_not_entered() -> None:
    area, mast = Area.of([[FIELD, POND]]), shapely.Point(90.0, 45.0).buffer(12.0)
    tour = tour_over(area, 10.0, cost=times(), keep_out=mast)
    check_whole(tour)
    assert shapely.LineString(tour.path).distance(mast) > 0.0
    assert coverage(area, tour, 10.0, mast).share >= 0.999
    assert share_seen(area, tour, 10.0, mast) > 0.997


def test_a_way_leads_from_beside_an_obstacle_too() -> None:
    """A keep-out is drawn with fewer corners, and so a little larger."""
    mast = shapely.Point(60.0, 50.0).buffer(15.0)
    transit = CoverProblem.of(Area.of([[FIELD]]), 10.0, times(), mast).transit
    begin, end = np.array([44.999, 50.0]), np.array([75.001, 50.0])
    path = transit(begin, end)
    assert (path[0] == begin).all()
    assert (path[-1] == end).all()
    line = shapely.LineString(path)
    assert not line.intersects(mast)
    assert line.length < 60.0
    wall = shapely.box(50.0, -500.0, 60.0, 500.0)
    with refuses("area-parted", "survey"):
        CoverProblem.of(Area.of([[FIELD]]), 10.0, times(), wall).transit(
            np.array([10.0, 50.0]), np.array([100.0, 50.0])
        )


def test_a_tour_begins_and_ends_where_it_is_asked_to() -> None:
    area = Area.of([[[(0.0, 0.0), (200.0, 0.0), (200.0, 60.0), (0.0, 60.0)]]])
    for begin, end in [((0.0, 0.0), (200.0, 60.0)), ((200.0, 0.0), (200.0, 60.0))]:
        path = tour_over(area, 20.0, cost=times(), begin=np.array(begin), end=np.array(end)).path
        assert np.linalg.norm(path[0] - begin) < 15.0
        assert np.linalg.norm(path[-1] - end) < 15.0


def test_parts_are_joined_round_holes() -> None:
    area = Area.of([[FIELD, POND], [[(200.0, 0.0), (260.0, 0.0), (260.0, 60.0), (200.0, 60.0)]]])
    tour = tour_over(area, 12.0, cost=times())
    check_whole(tour)
    assert coverage(area, tour, 12.0).share >= 0.999
    assert not shapely.LineString(tour.path).intersects(shapely.Polygon(POND))


def test_the_direction_is_that_of_the_lines() -> None:
    area = Area.of([[[(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]]])
    tour = tour_over(area, 10.0, cost=times(), direction=30.0)
    steps = np.array([swath.end - swath.begin for swath in tour.swaths if swath.length > 40.0])
    assert len(steps) > 5
    assert np.degrees(np.arctan2(steps[:, 0], steps[:, 1])) % 180.0 == pytest.approx(30.0, abs=1e-6)
    once, crossed = (tour_over(area, 10.0, cost=times(), direction=each) for each in ("best", "crosshatch"))
    assert polyline_length(crossed.path) == pytest.approx(2 * polyline_length(once.path), rel=0.1)
    assert coverage(area, crossed, 10.0).outside_m == 0.0


def test_ways_leave_the_area_as_far_as_they_may() -> None:
    """Between two bays a line is come to and left on the other side."""
    bays = [(54.0, 60.0), (50.0, 10.0), (46.0, 60.0), (44.0, 60.0), (40.0, 10.0), (36.0, 60.0)]
    area = Area.of([[[(0.0, 0.0), (100.0, 0.0), (100.0, 60.0), *bays, (0.0, 60.0)]]])
    inside = tour_over(area, 10.0, cost=times(), direction=0.0)
    outside = tour_over(area, 10.0, cost=times(), direction=0.0, turns_outside=20.0)
    assert coverage(area, inside, 10.0).outside_m == 0.0
    assert 0.0 < coverage(area, outside, 10.0).outside_m <= 20.0
    assert times().seconds(outside.path) < times().seconds(inside.path)


@pytest.mark.parametrize("which", [0, 1])
def test_a_small_field_is_flown_as_quickly_as_it_can_be(which: int) -> None:
    """All orders and senses of the chosen lines are tried."""
    area = Area.of([[[(0.0, 0.0), (60.0, 0.0), (80.0, 50.0), (0.0, 50.0)]]])
    cost = times(which)
    tour = tour_over(area, 12.0, cost=cost, direction=90.0)
    lines = [(swath.begin, swath.end) for swath in tour.swaths if swath.length > 30.0]
    assert len(lines) == 5
    least = min(
        cost.seconds(np.concatenate([lines[n][::sense] for n, sense in zip(order, senses, strict=True)]))
        for order in permutations(range(len(lines)))
        for senses in product((1, -1), repeat=len(lines))
    )
    assert cost.seconds(tour.path) <= 1.01 * least


def test_an_area_that_is_kept_out_of_is_none() -> None:
    with refuses("area-kept-out", "survey"):
        tour_over(Area.of([[FIELD]]), 10.0, cost=times(), keep_out=shapely.Point(60.0, 50.0).buffer(500.0))


def test_parts_that_are_walled_off_are_not_reached() -> None:
    area, wall = Area.of([[FIELD]]), shapely.Point(20.0, 20.0).buffer(15.0).exterior.buffer(3.0)
    with refuses("area-parted", "survey"):
        tour_over(area, 8.0, cost=times(), keep_out=wall)
