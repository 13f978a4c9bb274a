"""Quirks measured on ArduCopter 4.7 and PX4 1.17."""

from collections.abc import Sequence

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.checks.check import check_mission
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import (
    Ack,
    ClearAll,
    CommandAck,
    CommandLong,
    CommandResult,
    Count,
    Current,
    Event,
    ItemAt,
    Message,
    MissionType,
    Reached,
    Request,
    Result,
    SetCurrent,
    Text,
)
from ipoa_mission.mission.items import Item, Mission, change_speed, land, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.fly import fly_built_in
from ipoa_mission.simulator.situation import Conditions, FlightMode
from tests.link_pair import CLIENT, HOME, plain
from tests.simulator.flown import Flown

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
OK = Result.ACCEPTED


def short(*extra: Item) -> list[Item]:
    return [takeoff(HOME, 10.0), waypoint(Geodetic(47.4001, 8.5), 10.0), *extra]


def test_px4_accepts_a_take_off_too_low_and_then_reports_it_invalid() -> None:
    flown = Flown(PX4, [takeoff(HOME, 0.0), waypoint(HOME, 20.0)])
    assert Ack(OK) in flown.uploaded
    assert any(isinstance(message, Event) for message in flown.uploaded)
    assert flown.current == Current(0, 2, 1)
    assert flown.command(176, 1.0, 4.0, 4.0) == OK  # on the ground it shows any mode
    assert flown.command(400, 1.0) == CommandResult.TEMPORARILY_REJECTED


def test_ardupilot_will_not_start_a_mission_without_take_off() -> None:
    flown = Flown(ARDUPILOT, [waypoint(HOME, 20.0)])
    assert flown.command(400, 1.0) == OK
    answers = flown.hear(CommandLong(300))
    assert any(isinstance(answer, Text) and answer.text == "Auto: Missing Takeoff Cmd" for answer in answers)


@pytest.mark.parametrize(("disarm_delay", "lasts"), [(10.0, 10.0), (0.0, 110.0)])
def test_ardupilot_waits_armed_before_its_take_off_as_long_as_it_may(disarm_delay: float, lasts: float) -> None:
    # ArduPilot's copter_nav_delay_takeoff.txt on ArduCopter 4.7.0-dev: disarmed after 10.0 s, else 110.0 s
    items = (
        change_speed(10.0),
        Item(Command.NAV_DELAY, Frame.MISSION, (60.0, 0.0, 0.0, 0.0)),
        takeoff(HOME, 20.0),
        return_to_launch(),
    )
    mission = Mission(HOME, items, ARDUPILOT, parameters={"DISARM_DELAY": disarm_delay})
    record = fly_built_in(mission)
    assert (record.completed, record.total_s) == (disarm_delay == 0.0, pytest.approx(lasts, abs=1.0))
    assert [finding.code for finding in check_mission(mission)] == ["disarms-waiting"] * (disarm_delay > 0.0)


@pytest.mark.parametrize("autopilot", registered())
def test_the_first_item_of_a_list_without_home_vanishes_on_ardupilot(autopilot: Autopilot) -> None:
    mock = Mock(autopilot, HOME)
    for message in (Count(2), ItemAt(0, takeoff(HOME, 10.0)), ItemAt(1, waypoint(HOME, 10.0))):
        mock.receive(message, CLIENT, 1.0)
    assert Ack(OK) in [plain(message) for message, _ in mock.outgoing()]
    first = mock.transfers.listed(MissionType.MISSION)[0].command
    assert first == (22 if autopilot is PX4 else 16)
    arm_and_start(flown := Flown(autopilot, [], mock))
    assert (flown.mock.flight.mode is FlightMode.MISSION) == (autopilot is PX4)


def test_ardupilot_takes_a_mission_then_arms_and_has_a_position_last() -> None:
    flown = Flown(ARDUPILOT, [], Mock(ARDUPILOT, HOME, conditions=Conditions(cold=True)))
    assert Ack(Result.NO_SPACE) in flown.hear(Count(3))
    flown.now = 4.0
    assert Request(0, legacy=True) in flown.hear(Count(3))
    for now, result, words in ((10.0, 4, "Arm: Gyros inconsistent"), (24.0, 0, "Arming motors")):
        flown.now = now
        messages = flown.hear(CommandLong(400, (1.0, *(0.0,) * 6)))
        at = messages.index(CommandAck(400, result))
        assert messages[at + 1] == Text(6 if result == OK else 2, words)


def test_current_item_before_a_flight_and_after_orders_is_as_flown() -> None:
    ardupilot, px4 = Flown(ARDUPILOT, short()), Flown(PX4, short())
    assert (ardupilot.current, px4.current) == (Current(0, 2, 2), Current(0, 2, 2))  # home is not counted
    assert ardupilot.command(224, 2.0, 1.0) == OK
    assert ardupilot.current == Current(2, 2, 3)
    assert ardupilot.command(176, 1.0, 3.0) == OK
    assert ardupilot.command(176, 1.0, 4.0) == OK
    assert ardupilot.current == Current(2, 2, 2)
    px4.hear(SetCurrent(1))
    assert px4.current == Current(1, 2, 2)
    for flown, seq in ((ardupilot, 2), (px4, 1)):
        flown.upload(short(north(30.0)))
        assert flown.current.seq == seq  # kept over an upload


@pytest.mark.parametrize("autopilot", registered())
def test_setting_the_current_item_out_of_range(autopilot: Autopilot) -> None:
    flown = Flown(autopilot, short())
    assert flown.command(224, 77.0) == (CommandResult.DENIED if autopilot is ARDUPILOT else CommandResult.UNSUPPORTED)
    assert not any(isinstance(each, Current) for each in flown.hear(SetCurrent(77)))
    first = 1 if autopilot is ARDUPILOT else 0
    assert any(isinstance(each, Current) and each.seq == first + 1 for each in flown.hear(SetCurrent(first + 1)))


@pytest.mark.parametrize("autopilot", registered())
def test_an_item_is_told_as_reached_with_the_words_of_the_firmware(autopilot: Autopilot) -> None:
    flown = Flown(autopilot, short(return_to_launch()))
    assert flown.command(400, 1.0) == OK
    assert flown.command(*((300,) if autopilot is ARDUPILOT else (176, 1.0, 4.0, 4.0))) == OK
    heard = flown.fly(25.0)
    assert Reached(flown.first) in heard
    assert (Text(6, "Mission: 2 WP") in heard) == (Text(6, "Reached command #2") in heard) == (autopilot is ARDUPILOT)
    assert Text(6, "Reached command #1") not in heard  # no text for the take-off


# --- in flight ------------------------------------------------------------------------------------------------------


def arm_and_start(flown: Flown) -> Flown:
    flown.command(400, 1.0)
    flown.command(*((300,) if flown.first else (176, 1.0, 4.0, 4.0)))
    return flown


def north(meters: float) -> Item:
    return waypoint(Geodetic(47.4 + meters / 111_195.0, 8.5), 10.0)


LEGS = [takeoff(HOME, 10.0), north(60.0), north(120.0), north(180.0), return_to_launch()]


def under_way(autopilot: Autopilot, items: Sequence[Item] = LEGS) -> Flown:
    flown = arm_and_start(Flown(autopilot, items))
    while flown.mock.flight.current < 2:
        flown.fly(0.5)
    return flown


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize(
    "items", [LEGS, [takeoff(HOME, 10.0), north(60.0), north(90.0), north(150.0), north(200.0)]], ids=["same", "new"]
)
def test_a_mission_uploaded_in_flight_goes_on_at_the_current_item(autopilot: Autopilot, items: list[Item]) -> None:
    flown = under_way(autopilot)
    before = float(flown.mock.flight.place[1])
    assert Ack(OK) in flown.upload(items)
    assert flown.current == Current(flown.first + 2, len(items), 3)
    assert flown.mock.flight.mode is FlightMode.MISSION
    assert flown.mock.flight.place[1] > before


@pytest.mark.parametrize("autopilot", registered())
def test_a_shorter_mission_uploaded_in_flight_begins_anew(autopilot: Autopilot) -> None:
    flown = under_way(autopilot)
    assert Ack(OK) in flown.upload(LEGS[:2])
    assert flown.current.seq <= flown.first + 1


@pytest.mark.parametrize("autopilot", registered())
def test_the_current_item_is_set_in_flight_as_each_firmware_knows_it(autopilot: Autopilot) -> None:
    flown = under_way(autopilot)
    flown.hear(SetCurrent(flown.first + 3))
    assert flown.current.seq == flown.first + 3
    assert flown.command(224, flown.first + 1.0) == (OK if autopilot is ARDUPILOT else CommandResult.UNSUPPORTED)
    assert flown.current.seq == flown.first + (1 if autopilot is ARDUPILOT else 3)


@pytest.mark.parametrize("autopilot", registered())
@pytest.mark.parametrize("order", [Count(0), ClearAll()], ids=["count 0", "clear"])
def test_clearing_in_flight_stops_the_vehicle(autopilot: Autopilot, order: Message) -> None:
    flown = under_way(autopilot)
    assert Ack(OK) in flown.hear(order)
    assert flown.current == Current(0, 0 if autopilot is ARDUPILOT else 65535, 1)
    flown.fly(15.0)
    assert flown.mock.flight.mode is FlightMode.HOLD
    assert max(map(abs, flown.mock.flight.motion)) < 0.5
    assert not flown.mock.flight.on_ground


def reached(flown: Flown) -> list[int]:
    """Return the numbers reported as reached until disarmed, as in a file: home is 0."""
    seqs: list[int] = []
    while flown.mock.flight.armed:
        seqs += [message.seq + 1 - flown.first for message in flown.fly(1.0) if isinstance(message, Reached)]
    return seqs


def test_px4_omits_reached_before_do_jump_and_rtl_and_repeats_the_rest() -> None:
    jump = Item(177, 2, (1.0, 1.0, 0.0, 0.0))
    items = [takeoff(HOME, 10.0), north(20.0), change_speed(4.0), north(40.0), jump, north(60.0), return_to_launch()]
    seqs = reached(arm_and_start(Flown(PX4, items)))
    assert set(seqs) == {1, 3, 7}
    assert seqs.count(7) == 11


def test_ardupilot_reports_reached_items_once_but_no_final_landing() -> None:
    flown = arm_and_start(
        Flown(ARDUPILOT, [takeoff(HOME, 10.0), north(20.0), change_speed(4.0), north(40.0), land(HOME)])
    )
    assert reached(flown) == [1, 3, 4]
    assert flown.current.seq == 1  # the mission rewinds
    assert reached(arm_and_start(Flown(ARDUPILOT, [takeoff(HOME, 10.0), north(20.0), return_to_launch()]))) == [1, 2, 3]


def test_ardupilot_flies_its_mission_on_after_an_interrupted_return() -> None:
    items = [takeoff(HOME, 10.0), north(100.0), north(160.0), land(HOME)]
    flown = arm_and_start(Flown(ARDUPILOT, items))
    flown.fly(18.0)
    assert flown.command(Command.NAV_RETURN_TO_LAUNCH) == OK
    flown.fly(3.0)
    assert flown.command(176, 1.0, 3.0) == OK
    assert reached(flown) == [2, 3]
