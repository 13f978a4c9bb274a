import math

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.survey.free import narrow, widen
from tests.examples import examples

ROUNDING = 1e-9  # [m]


@st.composite
def rounded(draw: st.DrawFn) -> shapely.Geometry:
    """Stars with rounded corners, with a round hole or none."""
    count = draw(st.integers(3, 8))
    radii = draw(st.lists(st.floats(8.0, 60.0), min_size=count, max_size=count))
    turns = 2 * math.pi * np.arange(count) / count
    star = shapely.Polygon(np.column_stack([radii * np.cos(turns), radii * np.sin(turns)]))
    round_star = star.buffer(draw(st.floats(0.5, 20.0)), quad_segs=draw(st.integers(4, 24)))
    return round_star.difference(shapely.Point(0.0, 0.0).buffer(3.0)) if draw(st.booleans()) else round_star


@settings(max_examples=examples(50))
@given(rounded(), st.floats(0.02, 1.0))
def test_an_outline_is_drawn_outside_and_inside(shape: shapely.Geometry, most: float) -> None:
    for redraw, sign in ((widen, 1.0), (narrow, -1.0)):
        drawn = redraw(shape, most)
        large, small = (drawn, shape) if sign > 0 else (shape, drawn)
        assert large.buffer(ROUNDING).covers(small)
        edge = shapely.segmentize(drawn.boundary, 0.2)
        assert shapely.distance(shape.boundary, shapely.points(shapely.get_coordinates(edge))).max() <= most + ROUNDING
        assert shapely.get_num_coordinates(drawn) <= shapely.get_num_coordinates(shape)


def test_a_circle_has_as_few_corners_as_its_arcs_allow() -> None:
    circle = shapely.Point(5.0, 5.0).buffer(10.0, quad_segs=64)
    few = len(widen(circle, 0.5).exterior.coords) - 1
    least = math.pi / math.acos(10.0 / 10.5)  # of a regular polygon, corners 0.5 m away
    assert least <= few <= math.ceil(least) + 1


def test_corners_that_are_corners_stay() -> None:
    house = shapely.Polygon([(0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (12.0, 20.0), (12.0, 14.0), (0.0, 14.0)])
    assert widen(house, 2.0).equals(house)
    assert narrow(house, 2.0).equals(house)
