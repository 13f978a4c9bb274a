from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.forecast.itinerary.itinerary import itinerary
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.messages import MissionState
from ipoa_mission.mission.items import Item, Mission, change_speed, takeoff, waypoint
from ipoa_mission.mission.program import Program
from ipoa_mission.simulator.situation import Situation
from tests.refused import refuses

HOME = Geodetic(47.397742, 8.545594, 488.0)
NEAR, FAR = Geodetic(47.398642, 8.545594), Geodetic(47.399542, 8.545594)
HERE = Geodetic(0.0, 0.0)


def jump(to: float, times: float) -> Item:
    return Item(Command.DO_JUMP, Frame.MISSION, (to, times, 0.0, 0.0))


def mission(*items: Item) -> Mission:
    return Mission(HOME, (takeoff(HOME, 15.0), *items), Autopilot.ARDUPILOT)


def test_an_item_without_a_place_stays_where_the_flight_comes_from() -> None:
    route = itinerary(mission(waypoint(HERE, 0.0), waypoint(NEAR, 20.0), waypoint(FAR, 30.0), jump(2, 1)))
    assert [visit.seq for visit in route.visits] == [1, 2, 3, 4, 2, 3, 4]
    assert route.program.places[4] == pytest.approx(route.program.places[3])  # stays at FAR, at 30 m
    assert route.program.places[4][2] == 30.0


@pytest.mark.parametrize(
    ("item", "says"),
    [(jump(9, 1), ("bad-input", "item 2: param1")), (jump(1, -1), ("endless-flight", "item 2: param2"))],
)
def test_a_jump_that_cannot_be_followed_is_refused(item: Item, says: tuple[str, ...]) -> None:
    with refuses(*says):
        itinerary(mission(item))


def test_a_jump_is_no_hindrance_to_what_is_flown_on_to() -> None:
    items = mission(waypoint(NEAR, 20.0), waypoint(FAR, 20.0), jump(2, 1), waypoint(NEAR, 30.0)).items
    program = Program(items, LocalFrame(HOME), Autopilot.ARDUPILOT)
    assert program.onward(2) == 1
    assert program.after(2) == 1  # the next time it continues behind the jump
    assert program.onward(2) == 4


def test_a_loop_without_a_place_ends() -> None:
    items = (change_speed(5.0), jump(1, -1))
    program = Program(items, LocalFrame(HOME), Autopilot.ARDUPILOT)
    situation = Situation(program)
    assert situation.come_to(-1, lambda item: None) is None
    assert situation.mission is MissionState.COMPLETE
    assert program.onward(0) is None


def test_omitted_places_are_those_of_the_vehicle() -> None:
    hold = replace(waypoint(HERE, 0.0), command=Command.NAV_LOITER_TIME)
    program = Program((hold,), LocalFrame(HOME), Autopilot.ARDUPILOT)
    assert program.place(0, (1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)
