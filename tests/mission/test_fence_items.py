import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item
from ipoa_mission.mission.stored_mission import (
    as_stored,
    compare,
    fence_from_wire,
    fence_to_wire,
    rally_from_wire,
    rally_to_wire,
)
from tests.refused import refuses

DEGREES = st.integers(-899_999_999, 899_999_999).map(lambda n: n / 1e7)
PLACE = st.tuples(DEGREES, DEGREES)
FENCE = st.lists(
    st.builds(FencePolygon, st.lists(PLACE, min_size=3, max_size=6).map(tuple), st.booleans())
    | st.builds(FenceCircle, PLACE, st.floats(1, 1e5, width=32), st.booleans()),
    max_size=4,
).map(tuple)


@given(FENCE)
def test_a_fence_survives_the_wire_and_both_stores(fence: tuple[FencePolygon | FenceCircle, ...]) -> None:
    items = fence_to_wire(fence)
    for autopilot in registered():
        stored = as_stored(items, autopilot)
        assert compare(items, stored, autopilot) is None
        assert fence_from_wire(stored) == fence


def test_vertices_carry_their_number_and_circles_their_radius() -> None:
    square = FencePolygon(((39.0, 121.0), (39.0, 121.1), (39.1, 121.1), (39.1, 121.0)), inclusion=False)
    items = fence_to_wire((square, FenceCircle((39.05, 121.05), 250.0)))
    assert [(item.command, item.params[0]) for item in items] == [(5002, 4.0)] * 4 + [(5003, 250.0)]


def test_ardupilots_return_point_is_no_fence() -> None:
    assert fence_from_wire([Item(5000, 0), Item(5003, 0, (30.0, 0.0, 0.0, 0.0))]) == (FenceCircle((0.0, 0.0), 30.0),)


def test_a_polygon_that_breaks_off_is_an_error() -> None:
    with refuses("fence-broken", "fence item 1"):
        fence_from_wire([Item(5001, 0, (3.0, 0.0, 0.0, 0.0))] * 2)


@pytest.mark.parametrize("number", [2.0, -3.0, float("nan"), float("inf")])
def test_a_polygon_of_no_vertices_is_an_error(number: float) -> None:
    with refuses("fence-broken", "fence item 1"):
        fence_from_wire([Item(5001, 0, (number, 0.0, 0.0, 0.0))] * 3)


def test_wrong_fences_are_errors() -> None:
    with refuses("not-a-mission-item", "fence item 1", "NAV_WAYPOINT"):
        fence_from_wire([Item(16, 3)])
    with refuses("not-a-mission-item", "rally item 1", "NAV_WAYPOINT"):
        rally_from_wire([Item(16, 3)])


def test_ardupilot_keeps_whole_meters_of_a_rally_points_height() -> None:
    items = rally_to_wire([Geodetic(39.1, 121.8, 35.7)])
    assert rally_from_wire(as_stored(items, Autopilot.ARDUPILOT)) == (Geodetic(39.1, 121.8, 35.0),)
    assert rally_from_wire(as_stored(items, Autopilot.PX4))[0].altitude == pytest.approx(35.7, abs=1e-5)
    assert compare(items, as_stored(items, Autopilot.ARDUPILOT), Autopilot.ARDUPILOT) is None
