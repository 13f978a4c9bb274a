"""Ten loops of ArduCopter 4.8.0-dev (531699d652), PX4 1.17.0 and release/1.18 (05deebf313), by MISSION_CURRENT."""

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.forecast.itinerary.itinerary import itinerary
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, takeoff, waypoint

HOME = Geodetic(47.3977, 8.5456, 488.0)
NORTH, CORNER, EAST, SOUTH = (
    waypoint(Geodetic(HOME.latitude_deg + north, HOME.longitude_deg + east), 20.0)
    for north, east in ((72e-5, 0.0), (72e-5, 106e-5), (0.0, 106e-5), (-36e-5, 53e-5))
)
UP, BACK = takeoff(HOME, 20.0), return_to_launch()
PHOTOS = Item(Command.DO_SET_CAM_TRIGG_DIST, 2, (20.0, 0.0, 0.0, 0.0))
STAY = Item(Command.NAV_DELAY, 2, (3.0, -1.0, -1.0, -1.0))


def jump(to: float, times: float) -> Item:
    return Item(Command.DO_JUMP, 2, (to, times, 0.0, 0.0))


#: Items of each loop; places flown to by ArduCopter and PX4.
LOOPS = {
    "simple": ((UP, NORTH, CORNER, EAST, jump(2, 2), SOUTH, BACK), "2342342346", "2342342346"),
    "nested": ((UP, NORTH, CORNER, jump(2, 1), EAST, jump(2, 1), BACK), "2323523235", "23235235"),
    "an action behind": ((UP, NORTH, CORNER, PHOTOS, jump(2, 2), change_speed(4.0), EAST, BACK), "2323237", "2323237"),
    "two in a row": ((UP, NORTH, CORNER, EAST, jump(2, 1), jump(3, 1), SOUTH, BACK), "234234342347", "234234347"),
    "forward": ((UP, NORTH, jump(5, 1), CORNER, EAST, jump(2, 1), SOUTH, BACK), "252457", "252457"),
    "three deep": (
        (UP, NORTH, CORNER, jump(2, 1), jump(2, 1), EAST, jump(2, 1), BACK),
        "232323236232323236",
        "2323236236",
    ),
    "never": ((UP, NORTH, CORNER, jump(2, 0), EAST, jump(3, 1), SOUTH, BACK), "235357", "235357"),
    "at the end": ((UP, NORTH, CORNER, EAST, jump(2, 1)), "234234", "234234"),
    "nested, an action behind": (
        (UP, NORTH, CORNER, PHOTOS, jump(2, 1), change_speed(4.0), EAST, jump(2, 1), BACK),
        "2323723237",
        "23237237",
    ),
    "to an action": (
        (UP, change_speed(5.0), NORTH, CORNER, STAY, jump(2, 1), change_speed(8.0), EAST, BACK),
        "34348",
        "34348",
    ),
}


@pytest.mark.parametrize("name", LOOPS)
def test_loops_are_followed_as_they_were_flown(name: str) -> None:
    items, *flown = LOOPS[name]
    for autopilot, places in zip((Autopilot.ARDUPILOT, Autopilot.PX4), flown, strict=True):
        visits = itinerary(Mission(HOME, items, autopilot)).visits
        assert "".join(str(v.seq) for v in visits if v.item.command == Command.NAV_WAYPOINT) == places
