import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check_mission
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.itinerary.copter_curves import arc_center, arc_chords, arc_length, arc_radius, turn_of
from ipoa_mission.forecast.itinerary.flown_legs import flown_legs
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.fly import fly_built_in
from tests.examples import examples

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)
places = st.tuples(*[st.floats(-500.0, 500.0)] * 2, st.floats(5.0, 100.0))
turns = st.integers(-359, 359).filter(lambda degrees: abs(degrees) > 1)


def at(east: float, north: float) -> Geodetic:
    return FRAME.geodetic(np.array([east, north, 0.0]))


def arc(east: float, north: float, degrees: float) -> Item:
    place = at(east, north)
    where = place.latitude_deg, place.longitude_deg, 20.0
    return Item(Command.NAV_ARC_WAYPOINT, Frame.GLOBAL_RELATIVE_ALT, (degrees, 0.0, 0.0, 0.0), *where)


def mission(degrees: float) -> Mission:
    items = (takeoff(HOME, 20.0), waypoint(at(0, 40), 20.0), arc(60, 40, degrees), waypoint(at(100, 0), 20.0))
    return Mission(HOME, (*items, return_to_launch()), Autopilot.ARDUPILOT)


@settings(max_examples=examples(20))
@given(origin=places, target=places, degrees=turns)
def test_an_arc_is_a_circle_through_both_ends(
    origin: tuple[float, float, float], target: tuple[float, float, float], degrees: int
) -> None:
    if math.dist(origin[:2], target[:2]) < 1.0:
        return
    turn = math.radians(degrees)
    center, radius = np.array(arc_center(origin, target, turn)), arc_radius(origin, target, turn)
    points = arc_chords(origin, target, turn, 0.005)
    assert np.allclose(np.hypot(*(points[:, :2] - center).T), radius, rtol=1e-6)
    assert np.allclose(points[[0, -1]], [origin, target], atol=1e-6)
    headings = np.unwrap([math.atan2(*step) for step in np.diff(points[:, :2], axis=0)])
    assert headings[-1] - headings[0] == pytest.approx(turn * (1 - 1 / (len(points) - 1)), rel=1e-3)
    way = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert way == pytest.approx(arc_length(origin, target, turn), rel=0.0051 / (3 * radius) + 1e-9)


def test_less_than_a_degree_and_a_whole_circle_are_straight() -> None:
    assert [turn_of(arc(60, 40, degrees)) for degrees in (0.0, 0.9, -360.0, 720.0, math.nan)] == [0.0] * 5
    assert turn_of(arc(60, 40, -90.7)) == math.radians(-90)  # kept in whole degrees


def test_a_half_circle_to_the_right_bulges_to_the_left_of_its_chord() -> None:
    (leg,) = (leg for leg in flown_legs(mission(180), FRAME) if leg.seq == 3)
    assert leg.points[:, 1].max() == pytest.approx(70.0, abs=0.1)
    assert leg.points[:, 1].min() == pytest.approx(40.0, abs=0.1)


@pytest.mark.parametrize("degrees", [90, -180, 270])
def test_arc_is_timed_on_its_circle(degrees: int) -> None:
    flown = mission(degrees)
    prediction = estimate(flown)
    (leg,) = (leg for leg in flown_legs(flown, FRAME) if leg.seq == 3)
    center = np.array(arc_center(tuple(leg.points[0]), tuple(leg.points[-1]), math.radians(degrees)))
    radius = float(np.hypot(*(leg.points[0, :2] - center)))
    during = (prediction.track.times > prediction.items[1].done_s + 1) & (
        prediction.track.times < prediction.items[2].done_s - 1
    )
    away = np.hypot(*(np.asarray(prediction.track.points)[during, :2] - center).T) - radius
    assert np.abs(away).max() < 1.0


def test_the_stand_in_flies_it() -> None:
    flown = mission(90)
    record, done = fly_built_in(flown), {item.seq: item.done_s for item in estimate(flown).items}
    assert record.completed
    reached = record.item_reached_s
    assert reached[2] - reached[1] == pytest.approx(done[3] - done[2], rel=0.05)


def test_older_firmware_takes_none() -> None:
    later, earlier = mission(90), Version(4, 6)
    assert not [f for f in check_mission(later) if f.severity == "error"]
    refused = check_mission(replace(later, firmware_version=earlier, unmeasured_version=True))
    assert (refused[0].code, refused[0].seq) == ("command-not-taken", 3)
    assert refused[0].hint == "ArduPilot 4.7 takes it"
