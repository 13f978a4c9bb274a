from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, VehicleKind, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.departure import NotYet, count_down, depart, depart_when_ready, prepare
from ipoa_mission.link.dialogue import TimeUp
from ipoa_mission.link.messages import CommandAck, CommandLong, Heartbeat, Message
from ipoa_mission.link.vehicle_state import NotFlown, NotReady
from tests.link.scripted import (
    ARDUPILOT,
    ARM,
    PX4,
    RUN_PREARM_CHECKS,
    SET_CURRENT,
    SET_MODE,
    START,
    STREAM,
    TAKEOFF,
    Scripted,
)
from tests.refused import refuses


def test_each_firmware_is_prepared_and_started_in_its_own_order() -> None:
    copter, px4 = Scripted(ARDUPILOT), Scripted(PX4, first=0)
    for vehicle in (copter, px4):
        vehicle.hold(prepare)
        assert not vehicle.armed
        assert vehicle.current == vehicle.first
        assert vehicle.mode == vehicle.autopilot.modes.arming
        vehicle.hold(depart)
        assert vehicle.armed
        assert vehicle.mode == vehicle.autopilot.modes.mission
    assert [command[0] for command in copter.commands] == [SET_CURRENT, SET_MODE, SET_CURRENT, ARM, START]
    assert [command[0] for command in px4.commands] == [SET_CURRENT, SET_MODE, SET_CURRENT, ARM]
    assert copter.commands[0] == (SET_CURRENT, 1, 1, 0)  # resets the counts of jumps


def test_items_done_at_once_may_stand_before_the_one_that_is_current() -> None:
    """ArduCopter, set to a DO item, calls the item behind it current."""
    vehicle = Scripted(ARDUPILOT)
    obey = vehicle.obey
    vehicle.obey = lambda number, params: obey(number, tuple(p + (number == SET_CURRENT) for p in params))  # type: ignore[method-assign]
    vehicle.hold(prepare)
    assert vehicle.current == 2


def test_the_older_message_sets_the_item_where_the_command_is_unknown() -> None:
    vehicle = Scripted(PX4, first=0)
    vehicle.refuses[SET_CURRENT] = (3, "")
    vehicle.hold(prepare)
    assert vehicle.current == 0


def test_a_vehicle_without_a_position_is_waited_for() -> None:
    vehicle = Scripted(ARDUPILOT)
    warnings: list[str] = []
    vehicle.ready_s = 40.0
    vehicle.hold(lambda departure: prepare(replace(departure, progress=lambda share, words: warnings.append(words))))
    assert 40.0 <= vehicle.now < 50.0
    assert warnings
    assert ARM not in [command[0] for command in vehicle.commands]


def test_one_that_does_not_become_ready_is_an_error_with_its_own_reason() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.refuses[SET_MODE] = (4, "Mode change to GUIDED failed: requires position")
    with refuses("not-ready", "", "requires position") as late:
        vehicle.hold(lambda departure: prepare(departure, ready_s=30.0))
    assert late.value.hint == "the vehicle is disarmed, in STABILIZE"


def test_lasting_refusals_are_not_waited_for() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.ready_s = 1e9
    vehicle.refuses[RUN_PREARM_CHECKS] = (4, "PreArm: Hardware safety switch")
    with refuses("arming-refused", "", "PreArm: Hardware safety switch", kind=NotReady):
        vehicle.hold(prepare)
    assert vehicle.now < 20.0
    assert ARM not in [command[0] for command in vehicle.commands]


@pytest.mark.parametrize("autopilot", registered())
def test_an_armed_vehicle_is_left_alone(autopilot: Autopilot) -> None:
    vehicle = Scripted(autopilot)
    vehicle.armed = True
    with refuses("not-on-ground", kind=NotReady):
        vehicle.hold(prepare)
    assert vehicle.commands == []


def test_a_vehicle_that_does_not_stream_is_not_flown() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.streams = False
    vehicle.refuses[STREAM] = (3, "")
    with refuses("streams-missing", "", "GLOBAL_POSITION_INT", "MISSION_CURRENT", "SYS_STATUS", kind=NotReady):
        vehicle.hold(prepare)


def test_a_mission_that_stands_elsewhere_is_not_begun() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.obey = lambda number, params: None  # type: ignore[method-assign]
    with refuses("other-item-current", "", "item 1", "item 5", kind=NotReady):
        vehicle.hold(prepare)


@pytest.mark.parametrize(("words", "times"), [("Arming denied: high throttle", 1), ("", 5)])
def test_an_arming_that_is_refused_for_good_is_an_error(words: str, times: int) -> None:
    """Without a reason it is asked again: a link may have lost it."""
    vehicle = Scripted(PX4, first=0)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (1, words)
    with refuses("command-refused", "", words) as refused:
        vehicle.hold(depart)
    assert not isinstance(refused.value, NotYet)
    assert [command[:2] for command in vehicle.commands if command[0] == ARM] == [(ARM, 1)] * times


@pytest.mark.parametrize("autopilot", registered())
def test_an_arming_that_is_refused_for_what_passes_may_be_tried_again(autopilot: Autopilot) -> None:
    vehicle = Scripted(autopilot, first=0 if autopilot is PX4 else 1)
    vehicle.hold(prepare)
    reason = "Preflight Fail: GPS fix too low" if autopilot is PX4 else "Arm: Need Position Estimate"
    vehicle.refuses[ARM] = (4, reason)
    with refuses("not-yet", "", reason) as refused:
        vehicle.hold(depart)
    assert refused.value.words == reason
    assert [command[:2] for command in vehicle.commands if command[0] == ARM] == [(ARM, 1)]
    vehicle.refuses.clear()
    vehicle.hold(prepare)
    vehicle.hold(depart)
    assert vehicle.armed


@pytest.mark.parametrize(("tries", "passes_s"), [(1, 0.0), (3, 20.0)])
def test_arming_is_tried_again_while_there_is_time(tries: int, passes_s: float) -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (4, "Arm: Need Position Estimate")
    until_s = vehicle.now + passes_s
    with refuses("not-ready", "", "Arm: Need Position Estimate"):
        vehicle.hold(lambda departure: depart_when_ready(departure, lambda: until_s - vehicle.now))
    assert [command[:2] for command in vehicle.commands if command[0] == ARM] == [(ARM, 1)] * tries
    assert vehicle.now >= until_s


@pytest.mark.parametrize("autopilot", [PX4, ARDUPILOT])
def test_arming_is_tried_again_only_with_a_new_permit(autopilot: Autopilot) -> None:
    vehicle = Scripted(autopilot)
    vehicle.hold(prepare)
    reason = "Preflight Fail: GPS fix too low" if autopilot is PX4 else "Arm: Need Position Estimate"
    vehicle.refuses[ARM] = (4, reason)

    def permit(there: Geodetic) -> None:
        raise NotReady(f"low battery at {there.latitude_deg:.0f}")

    with refuses("not-ready", "", "low battery"):
        vehicle.hold(lambda departure: depart_when_ready(replace(departure, permit=permit), lambda: 90.0 - vehicle.now))
    assert [command[:2] for command in vehicle.commands if command[0] == ARM] == [(ARM, 1)]


def test_the_time_to_a_departure_is_counted_down() -> None:
    vehicle = Scripted(ARDUPILOT)
    words: list[str] = []
    vehicle.hold(lambda _: count_down(lambda share, left: words.append(left), lambda: 75.0 - vehicle.now, 60.0))
    assert vehicle.now == pytest.approx(15.0, abs=1.0)
    assert (words[0], words[-1]) == ("departure in 75 s", "departure in 61 s")


@pytest.mark.parametrize("refusals", [0, 4])
def test_none_is_armed_after_its_time(refusals: int) -> None:
    """Refusals without words are repeated; the order may be late on its way."""
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (1, "")
    latest_s = vehicle.now + refusals - 0.1
    with refuses("departure-missed", kind=NotReady):
        vehicle.hold(lambda departure: depart(replace(departure, left_s=lambda: latest_s - vehicle.now)))
    tries = [command[:2] for command in vehicle.commands].count((ARM, 1))
    assert (tries > 0, tries < 5, vehicle.armed) == (refusals > 0, True, False)


def test_one_that_arms_after_its_time_is_disarmed() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    obey = vehicle.obey

    def late(number: int, params: tuple[float, ...]) -> None:
        vehicle.now += 8.0 * (number == ARM)
        obey(number, params)

    vehicle.obey = late  # type: ignore[method-assign]
    latest_s = vehicle.now + 3.0
    with refuses("departure-missed", kind=NotReady):
        vehicle.hold(lambda departure: depart(replace(departure, left_s=lambda: latest_s - vehicle.now)))
    assert not vehicle.armed
    assert [command[:2] for command in vehicle.commands if command[0] in (ARM, START)] == [(ARM, 1), (ARM, 0)]


def test_armed_vehicle_begins_despite_a_late_refusal() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    answer = vehicle.answer

    def late(message: Message) -> list[Message]:
        if isinstance(message, CommandLong) and message.command == ARM:
            vehicle.obey(ARM, message.params)
            return [CommandAck(ARM, 1)]
        return answer(message)

    vehicle.answer = late  # type: ignore[method-assign]
    vehicle.hold(depart)
    assert vehicle.mode == ARDUPILOT.modes.mission


@pytest.mark.parametrize("mav_type", [1, 10, 12, 20])
def test_other_vehicles_are_neither_prepared_nor_armed(mav_type: int) -> None:
    vehicle = Scripted(ARDUPILOT)
    told_by = vehicle.stream

    def stream() -> list[Message]:
        return [replace(message, type=mav_type) if isinstance(message, Heartbeat) else message for message in told_by()]

    vehicle.stream = stream  # type: ignore[method-assign]
    with refuses("not-flown", "", "ArduPilot"):
        vehicle.hold(prepare)
    vehicle = Scripted(ARDUPILOT)
    vehicle.hold(prepare)
    vehicle.state.kind = VehicleKind(3, mav_type)
    count = len(vehicle.commands)
    with pytest.raises(NotFlown):
        vehicle.hold(depart)
    assert len(vehicle.commands) == count


def test_time_that_is_up_before_it_is_ready_says_what_hinders() -> None:
    vehicle = Scripted(ARDUPILOT)
    vehicle.refuses[SET_MODE] = (4, "Battery 1 below minimum arming voltage")
    exchange_ends = TimeUp("the time is up")
    with refuses("time-up", "", "Battery 1 below minimum"):
        vehicle.hold(prepare, cancel_s=20.0, cancel=exchange_ends)
    placeless = Scripted(ARDUPILOT)
    placeless.ready_s = 1e9
    with refuses("time-up"):
        placeless.hold(prepare, cancel_s=4.0, cancel=exchange_ends)
    with refuses("not-ready"):
        placeless.hold(prepare)
    warned = Scripted(ARDUPILOT)
    warned.ready_s = 1e9
    warned.refuses[RUN_PREARM_CHECKS] = (4, "PreArm: Compass not calibrated")
    with refuses("not-ready", "", "PreArm: Compass not calibrated"):
        warned.hold(lambda departure: prepare(departure, ready_s=5.0))


def test_a_stream_that_does_not_come_is_asked_for_again() -> None:
    """The answer was to another request."""
    vehicle = Scripted(ARDUPILOT)
    answer, asked = vehicle.answer, 0
    vehicle.streams = False

    def deaf(message: Message) -> list[Message]:
        nonlocal asked
        if isinstance(message, CommandLong) and message.command == STREAM:
            asked += 1
            vehicle.streams = asked > 5
        return answer(message)

    vehicle.answer = deaf  # type: ignore[method-assign]
    vehicle.hold(prepare)
    assert asked > 5


def test_an_ardupilot_that_begins_with_a_waypoint_climbs_first() -> None:
    vehicle = Scripted(ARDUPILOT, first=4)
    vehicle.hold(prepare)
    vehicle.hold(depart, climb=20.0)
    assert [command[0] for command in vehicle.commands][-3:] == [ARM, TAKEOFF, START]
    assert vehicle.height == 20.0


def test_an_arming_refused_without_a_reason_is_tried_again() -> None:
    vehicle = Scripted(PX4, first=0)
    vehicle.hold(prepare)
    vehicle.refuses[ARM] = (1, "")
    stream = vehicle.stream

    def calmer() -> list[Message]:
        if sum(number == ARM for number, *_ in vehicle.commands) == 2:
            vehicle.refuses.clear()
        return stream()

    vehicle.stream = calmer  # type: ignore[method-assign]
    vehicle.hold(depart)
    assert vehicle.armed
    assert [number for number, *_ in vehicle.commands].count(ARM) == 3
