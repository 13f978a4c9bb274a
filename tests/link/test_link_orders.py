"""Commands, the current item, arming, starting, parameters, the logbook: message by message."""

import struct

import pytest

from ipoa_mission.link import orders
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange, NoAnswer
from ipoa_mission.link.logbook import LOST_S, Logbook, brings_down, watch
from ipoa_mission.link.messages import (
    ARMED_FLAG,
    AutopilotVersion,
    CommandAck,
    CommandLong,
    Current,
    Heartbeat,
    HomePosition,
    Message,
    ParamRequestRead,
    ParamValue,
    Position,
    Reached,
    SetCurrent,
    Text,
)
from ipoa_mission.vehicle import Autopilot
from ipoa_mission.world.frame import Geodetic

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME = Geodetic(47.4, 8.5, 400.0)
BEAT = Heartbeat(2, 12)


def lead(dialogue: Dialogue[object], *answers: list[Message]) -> Exchange[object]:
    """Each thing said gets the next of the answers; then there is silence."""
    exchange, now, script = Exchange(dialogue, 0.0, SPECIFIED), 0.0, list(answers)
    while not exchange.finished:
        said = exchange.outgoing()
        for _ in said:
            for answer in script.pop(0) if script else []:
                now += 0.2
                exchange.receive(answer, now)
        if not said:
            now = max(now, exchange.deadline)
            exchange.tick(now)
    return exchange


def said_by(dialogue: Dialogue[object], *answers: list[Message]) -> list[Message]:
    exchange, now, said = Exchange(dialogue, 0.0, SPECIFIED), 0.0, []
    for answer in answers:
        said += exchange.outgoing()
        for message in answer:
            now += 0.2
            exchange.receive(message, now)
    return said + exchange.outgoing()


def test_a_command_is_answered_with_its_result_and_words() -> None:
    answers = [BEAT, CommandAck(9, 0), Text(3, "no position"), CommandAck(400, 4), Text(2, "no compass")]
    assert lead(orders.command(400, 1.0), answers).result == (4, "no position; no compass")


def test_a_command_in_progress_is_waited_for() -> None:
    assert lead(orders.command(300), [CommandAck(300, 5), BEAT, CommandAck(300, 0)]).result == (0, "")
    with pytest.raises(NoAnswer, match="was begun, but never ended"):
        lead(orders.command(300), [CommandAck(300, 5)])


def test_arming_is_tried_until_the_vehicle_is_ready() -> None:
    assert lead(orders.arm(), [CommandAck(400, 1)], [CommandAck(400, 4)], [CommandAck(400, 0)]).finished
    with pytest.raises(orders.CommandRefused, match="arm: the vehicle answered DENIED: no mission"):
        lead(orders.arm(1), [CommandAck(400, 2), Text(2, "no mission")])


def test_the_vehicle_is_heard_out_between_two_attempts_to_arm() -> None:
    exchange = Exchange(orders.arm(), 0.0, SPECIFIED)
    exchange.receive(CommandAck(400, 4), 0.1)
    exchange.tick(0.4)  # its words have had their time
    exchange.receive(BEAT, 1.0)
    assert exchange.outgoing() == [CommandLong(400, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))]
    exchange.tick(1.4)
    assert len(exchange.outgoing()) == 1


def test_each_firmware_is_started_in_its_own_way() -> None:
    ok = [[CommandAck(176, 0)], [CommandAck(300, 0)]]
    assert said_by(orders.start(ARDUPILOT), *ok) == [
        CommandLong(176, (1, 3, 0.0, 0.0, 0.0, 0.0, 0.0)),
        CommandLong(300),
    ]
    assert said_by(orders.start(PX4), ok[0]) == [CommandLong(176, (1, 4, 4, 0.0, 0.0, 0.0, 0.0))]
    for refused in ([[CommandAck(176, 2)]], [[CommandAck(176, 0)], [CommandAck(300, 77)]]):
        with pytest.raises(orders.CommandRefused, match="start the mission"):
            lead(orders.start(ARDUPILOT), *refused)
    assert orders.mission_custom_mode(PX4) == 0x04040000
    assert orders.mission_custom_mode(ARDUPILOT) == 3


def test_the_current_item_is_set_by_command_or_by_the_older_message() -> None:
    assert lead(orders.set_current(3), [CommandAck(224, 0)]).finished
    with pytest.raises(orders.CommandRefused, match="go to item 3"):
        lead(orders.set_current(3), [CommandAck(224, 2)])
    assert said_by(orders.set_current(3), [CommandAck(224, 3)])[-1] != SetCurrent(3)  # words are waited for first
    assert lead(orders.set_current(3), [CommandAck(224, 3)], [Current(1), Current(3)]).finished
    with pytest.raises(NoAnswer, match="is there one"):
        lead(orders.set_current(3), [CommandAck(224, 3)], [Current(1)])


def test_home_is_asked_for_until_it_comes_or_is_unknown() -> None:
    place = HomePosition(47.0, 8.0, 400.0)
    assert lead(orders.home(), [CommandAck(512, 0), BEAT, place]).result == Geodetic(47.0, 8.0, 400.0)
    assert lead(orders.home(), [CommandAck(512, 0)], [place]).result == Geodetic(47.0, 8.0, 400.0)
    assert lead(orders.home(), [CommandAck(512, 2)]).result is None


def test_capabilities_are_nothing_where_they_are_not_told() -> None:
    assert lead(orders.capabilities(), [BEAT, AutopilotVersion(36)]).result == 36
    assert lead(orders.capabilities(), [CommandAck(512, 0), AutopilotVersion(36)]).result == 36
    assert lead(orders.capabilities(), [CommandAck(512, 0)]).result == 0
    assert lead(orders.capabilities(), [CommandAck(512, 3)]).result == 0
    assert lead(orders.capabilities()).result == 0


def test_streams_are_asked_for_by_name() -> None:
    assert lead(orders.stream("ATTITUDE", 0.1), [CommandAck(511, 0)]).result is True
    assert lead(orders.stream("ATTITUDE", 0.1), [CommandAck(511, 3)]).result is False
    assert said_by(orders.stream("ATTITUDE", 0.1)) == [CommandLong(511, (30, 100_000, 0.0, 0.0, 0.0, 0.0, 0.0))]


def test_parameters_are_read_by_name_and_whole_numbers_as_each_firmware_sends_them() -> None:
    bits = struct.unpack("<f", struct.pack("<i", 4001))[0]
    answers = [[BEAT, ParamValue("A", bits, 6, 2, 0)], [ParamValue("B", 2.5, 9, 2, 1)]]
    assert lead(orders.parameters(("A", "B"), PX4), *answers).result == {"A": 4001.0, "B": 2.5}
    assert lead(orders.parameters(("A",), ARDUPILOT), [ParamValue("A", 7.0, 6, 1, 0)]).result == {"A": 7.0}
    assert lead(orders.parameters(("A", "NONE"), ARDUPILOT), [ParamValue("A", 7.0, 9, 1, 0)]).result == {"A": 7.0}
    assert said_by(orders.parameters(("A",), PX4)) == [ParamRequestRead("A")]
    with pytest.raises(NoAnswer):
        lead(orders.parameters(("A",), PX4))


# --- the logbook ----------------------------------------------------------------------------------------------------


def at(seconds: float) -> Position:
    return Position(seconds, 47.4, 8.5, 430.0, 30.0, (3.0, 4.0, 0.0))


def armed(yes: bool) -> Heartbeat:
    return Heartbeat(2, 12, ARMED_FLAG if yes else 0)


def noted(logbook: Logbook, *messages: Message) -> Logbook:
    for message in messages:
        logbook.note(message)
    return logbook


def test_a_flight_is_timed_by_the_vehicles_own_clock_from_its_start() -> None:
    logbook = noted(Logbook(3, first=1, lands=False), at(100.0), Reached(1), armed(True))
    logbook.begin()
    noted(logbook, at(105.0), Reached(1), at(107.0), Reached(1), Text(6, "words"), at(110.0), Current(3))
    noted(logbook, at(112.0), Reached(3), at(115.0), armed(False), BEAT)
    record = logbook.record()
    assert record.item_reached_s == {0: 5.0, 1: 10.0, 2: 12.0}
    assert record.total_s == 12.0
    assert record.completed
    assert record.messages == ("words",)
    assert [sample.time_s for sample in record.path] == [5.0, 7.0, 10.0, 12.0, 15.0]
    assert record.path[0].speed == 5.0
    assert logbook.disarmed_s == 15.0


def test_a_mission_that_lands_is_over_when_the_motors_stop() -> None:
    """PX4 reports RTL as it begins, and says that the mission is complete; ArduCopter never reports a final LAND."""
    for last in (Reached(1), Current(1, 2, 5)):
        logbook = noted(Logbook(2, first=0, lands=True), armed(True))
        logbook.begin()
        noted(logbook, at(60.0), Reached(0), last)
        assert logbook.record().item_reached_s == {0: 60.0}
        record = noted(logbook, at(190.0), armed(False)).record()
        assert record.item_reached_s == {0: 60.0, 1: 190.0}
        assert record.total_s == 190.0


def test_a_flight_that_breaks_off_is_not_complete() -> None:
    logbook = noted(Logbook(3, first=0, lands=True), armed(True))
    logbook.begin()
    noted(logbook, at(4.0), Reached(0), Current(77), Current(1), at(9.0), armed(False))
    record = logbook.record()
    assert not record.completed
    assert record.item_reached_s == {0: 4.0}
    assert record.total_s == 9.0
    assert logbook.done == 1


def test_a_record_of_a_flight_under_way_ends_now() -> None:
    logbook = Logbook(2, first=0, lands=True)
    logbook.begin()
    assert noted(logbook, at(3.0)).record().total_s == 3.0


def test_watching_ends_with_the_flight_and_tells_of_progress() -> None:
    told: list[int] = []
    for lands, last in ((True, armed(False)), (False, Current(1, 2, 5))):
        logbook = noted(Logbook(2, first=0, lands=lands), armed(True))
        logbook.begin()
        exchange = Exchange(watch(logbook, told.append), 0.0, SPECIFIED)
        for now, message in enumerate([at(1.0), Reached(0), BEAT, last] if not lands else [at(1.0), Reached(0), last]):
            logbook.note(message)
            exchange.receive(message, float(now))
        assert exchange.finished
    assert told == [0, 1, 0, 1]


def test_a_lost_vehicle_is_an_error() -> None:
    exchange = Exchange(watch(Logbook(2, 0, lands=True), lambda done: None), 0.0, SPECIFIED)
    with pytest.raises(NoAnswer, match="not heard any more"):
        exchange.tick(LOST_S)


def test_a_mission_comes_down_with_a_landing_or_a_return() -> None:
    assert [command for command in (16, 20, 21, 22, 178) if brings_down(command)] == [20, 21]
