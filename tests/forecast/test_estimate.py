import math
import re
from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.forecast import estimate as predict
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, change_speed, land, return_to_launch, takeoff, waypoint
from tests.refused import refuses

HOME = Geodetic(39.101, 121.82, 20.0)
EAST = Geodetic(39.101, 121.821, 20.0)


def estimate(mission: Mission, parameters: Parameters | None = None) -> Estimate:
    return predict(mission, parameters or {})


def out_and_back(autopilot: Autopilot, *between: Item) -> Mission:
    items = (takeoff(HOME, 20.0), waypoint(HOME, 20.0), *between, waypoint(EAST, 20.0), return_to_launch())
    return Mission(HOME, items, autopilot)


@pytest.mark.parametrize("autopilot", registered())
def test_items_are_numbered_as_in_the_file_and_done_in_order(autopilot: Autopilot) -> None:
    predicted = estimate(out_and_back(autopilot, change_speed(8.0)))
    assert [item.seq for item in predicted.items] == [1, 2, 3, 4, 5]
    times = [item.done_s for item in predicted.items]
    assert times == sorted(times)
    assert predicted.total_s == times[-1]
    assert all(item.low_s <= item.done_s <= item.high_s for item in predicted.items)


@pytest.mark.parametrize("autopilot", registered())
def test_a_jump_is_flown_as_often_as_it_asks(autopilot: Autopilot) -> None:
    once = estimate(out_and_back(autopilot))
    jump = Item(Command.DO_JUMP, Frame.MISSION, (2.0, 2.0, 0.0, 0.0))
    mission = Mission(HOME, (takeoff(HOME, 20.0), waypoint(HOME, 20.0), waypoint(EAST, 20.0), jump), autopilot)
    predicted = estimate(mission)
    assert [item.seq for item in predicted.items] == [1, 2, 3, 2, 3, 2, 3]
    leg = once.items[2].duration_s
    assert predicted.total_s == pytest.approx(once.items[1].done_s + 5 * leg, rel=0.15)


@pytest.mark.parametrize("autopilot", registered())
def test_a_loop_without_end_has_no_time(autopilot: Autopilot) -> None:
    jump = Item(Command.DO_JUMP, Frame.MISSION, (2.0, -1.0, 0.0, 0.0))
    with refuses("endless-flight", "item 3: param2"):
        estimate(out_and_back(autopilot, jump))


@pytest.mark.parametrize("autopilot", registered())
def test_a_hold_lasts_at_least_as_long_as_it_says(autopilot: Autopilot) -> None:
    plain = estimate(out_and_back(autopilot))
    mission = out_and_back(autopilot)
    holding = replace(mission, items=(*mission.items[:1], waypoint(HOME, 20.0, hold_s=30.0), *mission.items[2:]))
    assert estimate(holding).items[1].duration_s - plain.items[1].duration_s == pytest.approx(30.0, abs=1.0)
    assert estimate(holding).total_s - plain.total_s == pytest.approx(30.0, abs=4.0)


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("seconds", [math.inf, 1e6, 86_401.0])
def test_a_hold_of_more_than_a_day_has_no_time(autopilot: Autopilot, seconds: float) -> None:
    for held in (
        waypoint(HOME, 20.0, hold_s=seconds),
        Item(Command.NAV_DELAY, Frame.MISSION, (seconds, 0.0, 0.0, 0.0)),
    ):
        with refuses("endless-flight", "item 2: param1", "86400 s"):
            estimate(Mission(HOME, (takeoff(HOME, 20.0), held, land(HOME)), autopilot))


@pytest.mark.parametrize("autopilot", registered())
def test_the_holds_of_a_loop_count_each_time(autopilot: Autopilot) -> None:
    loop = waypoint(HOME, 20.0, hold_s=30_000.0), Item(Command.DO_JUMP, Frame.MISSION, (2.0, 2.0, 0.0, 0.0))
    with refuses("endless-flight", "item 2: param1", "86400 s"):
        estimate(Mission(HOME, (takeoff(HOME, 20.0), *loop, land(HOME)), autopilot))


@pytest.mark.parametrize(
    ("autopilot", "name"), [(Autopilot.PX4, "RTL_LAND_DELAY"), (Autopilot.ARDUPILOT, "RTL_LOIT_TIME")]
)
def test_a_wait_of_more_than_a_day_before_landing_has_no_time(autopilot: Autopilot, name: str) -> None:
    with refuses("endless-flight", name, "86400 s"):
        estimate(out_and_back(autopilot), {name: 1e9})


@pytest.mark.parametrize("autopilot", registered())
def test_parameters_count_by_the_autopilots_names_and_unused_ones_do_not(autopilot: Autopilot) -> None:
    mission = Mission(HOME, (takeoff(HOME, 20.0), waypoint(HOME, 20.0), waypoint(EAST, 20.0), land(EAST)), autopilot)
    slow = {Autopilot.ARDUPILOT: {"WPNAV_SPEED": 200.0}, Autopilot.PX4: {"MPC_XY_CRUISE": 2.0}}[autopilot]
    unused = {Autopilot.ARDUPILOT: "FRAME_CLASS", Autopilot.PX4: "SYS_AUTOSTART"}[autopilot]
    assert estimate(mission, {**slow, unused: 7.0}).total_s > estimate(mission).total_s + 10.0
    with refuses("unknown-parameter", "", "NONSENSE", kind=BadInput):
        estimate(mission, {**slow, "NONSENSE": 7.0})


@pytest.mark.parametrize("autopilot", registered())
def test_the_route_lasts_from_its_first_place_to_its_last_waypoint(autopilot: Autopilot) -> None:
    items = (takeoff(HOME, 20.0), change_speed(5.0), waypoint(HOME, 20.0, 0.1, 2.0), waypoint(EAST, 20.0, 0.1, 2.0))
    predicted = estimate(Mission(HOME, (*items, return_to_launch()), autopilot))
    assert predicted.route_s == pytest.approx(predicted.items[3].done_s - predicted.items[0].done_s)
    assert math.isnan(estimate(Mission(HOME, (takeoff(HOME, 20.0),), autopilot)).route_s)


def test_a_result_is_one_line_to_look_at() -> None:
    assert re.fullmatch(
        r"<Estimate: [\d.]+ s, between \d+ and \d+; 4 items>", repr(estimate(out_and_back(Autopilot.PX4)))
    )


def test_quite_another_number_is_quoted_for_qgroundcontrol() -> None:
    mission = replace(out_and_back(Autopilot.PX4), cruise_speed=10.0)
    distance = 86.4  # 0.001 degrees of longitude at 39.1 north, radius 6371 km
    expected = 20.0 / 3.0 + distance / 10.0 + distance / 10.0 + 20.0 / 1.0
    assert estimate(mission).qgroundcontrol_s == pytest.approx(expected, abs=0.2)
