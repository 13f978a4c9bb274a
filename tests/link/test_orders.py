import random
import struct
from collections.abc import Sequence
from typing import TypeVar

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import orders
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange, NoAnswer, SendOnce
from ipoa_mission.link.messages import (
    AutopilotVersion,
    CommandAck,
    CommandLong,
    Current,
    Heartbeat,
    HomePosition,
    Message,
    ParamRequestRead,
    ParamSet,
    ParamValue,
    SetCurrent,
    Text,
)
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Faults, Loopback, Station
from tests.link.scripted_answers import lead_by
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME = Geodetic(47.4, 8.5, 400.0)
BEAT = Heartbeat(2, 12)
T = TypeVar("T")


def lead(dialogue: Dialogue[T], *answers: Sequence[Message]) -> Exchange[T]:
    script = list(answers)
    return lead_by(dialogue, lambda message: script.pop(0) if script else ())


def said_by(dialogue: Dialogue[object], *answers: list[Message]) -> list[Message]:
    exchange, now, sent = Exchange(dialogue, 0.0, SPECIFIED), 0.0, []
    for answer in answers:
        sent += exchange.outgoing()
        for message in answer:
            now += 0.2
            exchange.receive(message, now)
    return sent + exchange.outgoing()


def test_a_command_is_answered_with_its_result_and_words() -> None:
    answers = [BEAT, CommandAck(9, 0), Text(3, "no position"), CommandAck(400, 4), Text(2, "no compass")]
    assert lead(orders.send(400, 1.0), answers).result == (4, "no position; no compass")


def test_a_command_in_progress_is_waited_for() -> None:
    assert lead(orders.send(300), [CommandAck(300, 5), BEAT, CommandAck(300, 0)]).result == (0, "")
    with refuses("command-not-ended", kind=NoAnswer):
        lead(orders.send(300), [CommandAck(300, 5)])


def test_the_current_item_is_set_by_command_or_by_the_older_message() -> None:
    assert lead(orders.set_current(3, 0), [CommandAck(224, 0)]).finished
    with refuses("command-refused", "", "item 4"):
        lead(orders.set_current(3, 0), [CommandAck(224, 2)])
    assert said_by(orders.set_current(3, 0), [CommandAck(224, 3)])[-1] != SetCurrent(3)  # words are waited for first
    assert lead(orders.set_current(3, 0), [CommandAck(224, 3)], [Current(1), Current(3)]).finished
    with refuses("no-such-item", "", "item 4", kind=NoAnswer):
        lead(orders.set_current(3, 0), [CommandAck(224, 3)], [Current(1)])


def test_home_is_asked_for_until_it_comes_or_is_unknown() -> None:
    place = HomePosition(47.0, 8.0, 400.0)
    assert lead(orders.request_home(), [CommandAck(512, 0), BEAT, place]).result == Geodetic(47.0, 8.0, 400.0)
    assert lead(orders.request_home(), [CommandAck(512, 0)], [place]).result == Geodetic(47.0, 8.0, 400.0)
    assert lead(orders.request_home(), [CommandAck(512, 2)]).result is None


def test_a_vehicle_without_home_is_asked_for_some_seconds_only() -> None:
    """ArduPilot without GPS accepts every request for HOME_POSITION, and sends none."""
    patient = lead(orders.request_home(), *([CommandAck(512, 0)] for _ in range(99)))
    assert patient.result is None


def test_a_refusal_of_an_earlier_request_is_no_refusal_of_this_one() -> None:
    place = HomePosition(47.0, 8.0, 400.0)
    assert lead(orders.request_home(), [CommandAck(512, 3)], [place]).result == Geodetic(47.0, 8.0, 400.0)


def test_an_autopilot_tells_what_it_is_or_nothing() -> None:
    version = AutopilotVersion(36, 0x04070000)
    assert lead(orders.request_version(), [BEAT, version]).result == version
    assert lead(orders.request_version(), [CommandAck(512, 0), version]).result == version
    assert lead(orders.request_version(), [CommandAck(512, 0)]).result is None
    assert lead(orders.request_version(), [CommandAck(512, 3)]).result is None
    assert lead(orders.request_version()).result is None


def test_streams_are_asked_for_by_name() -> None:
    assert lead(orders.request_stream("ATTITUDE", 0.1), [CommandAck(511, 0)]).result is True
    assert lead(orders.request_stream("ATTITUDE", 0.1), [CommandAck(511, 3)]).result is False
    assert said_by(orders.request_stream("ATTITUDE", 0.1)) == [CommandLong(511, (30, 100_000, 0.0, 0.0, 0.0, 0.0, 0.0))]


def value_of(name: str, value: float, kind: int = 9) -> ParamValue:
    return ParamValue(name, value, kind, 2, 0)


def test_parameters_are_read_by_name_and_integers_by_each_firmwares_coding() -> None:
    bits = struct.unpack("<f", struct.pack("<i", 4001))[0]
    answers: list[list[Message]] = [[BEAT, value_of("A", bits, 6)], [value_of("B", 2.5)]]
    both = lead(orders.request_parameters([["A"], ["B"]], PX4), *answers).result
    assert {name: value.param_value for name, value in both.items()} == {"A": 4001.0, "B": 2.5}
    as_it_is = lead(orders.request_parameters([["A"]], ARDUPILOT), [value_of("A", 7.0, 6)]).result
    assert as_it_is["A"].param_value == 7.0
    assert said_by(orders.request_parameters([["A"]], PX4)) == [ParamRequestRead("A"), ParamRequestRead("MAV_SYS_ID")]
    with refuses("no-answer", "", "for A"):
        lead(orders.request_parameters([["A"]], PX4))


def test_a_parameter_with_several_names_has_the_first_one_answered() -> None:
    answers: list[list[Message]] = [[], [value_of("WPNAV_SPEED", 500.0)]]
    known = lead(orders.request_parameters([["WP_SPD", "WPNAV_SPEED"]], ARDUPILOT), *answers).result
    assert {name: value.param_value for name, value in known.items()} == {"WPNAV_SPEED": 500.0}


def test_a_parameter_that_does_not_exist_is_left_out() -> None:
    known = lead(orders.request_parameters([["A"], ["NONE"]], ARDUPILOT), [value_of("A", 7.0)]).result
    assert list(known) == ["A"]


def found_over(loss: float, seed: int) -> set[str]:
    """Ask for one parameter that exists and one that does not, with a share of frames lost in each direction."""
    chance, inbox, heard = random.Random(seed), list[Message](), None
    dialogue = orders.request_parameters([["MPC_XY_CRUISE"], ["NONE"]], PX4)
    try:
        while True:
            match dialogue.send(heard):
                case SendOnce(ParamRequestRead(name)):
                    heard = None
                    if name != "NONE" and min(chance.random(), chance.random()) >= loss:
                        inbox.append(value_of(name, 1.0))
                case _:
                    heard = inbox.pop(0) if inbox else None
    except StopIteration as ended:
        return set(ended.value)


@pytest.mark.parametrize("loss", [0.0, 0.1, 0.3])
def test_existing_parameter_is_found_over_a_lossy_link(loss: float) -> None:
    missed = [seed for seed in range(2000) if found_over(loss, seed) != {"MPC_XY_CRUISE"}]
    assert len(missed) <= 6  # 2 of 2,000 by the chance that is allowed


@pytest.mark.parametrize(("delay_s", "within_s"), [(0.0, 0.5), (0.3, 4.0), (0.9, 8.0)])
@pytest.mark.parametrize("family", registered())
def test_missing_parameters_cost_little_time_and_late_answers_count(
    family: Autopilot, delay_s: float, within_s: float
) -> None:
    faults = Faults(delay_s=delay_s)
    vehicle = meet(Connection(Loopback(Station(Mock(family, HOME)), faults), Codec(245, 190)))
    there = "WPNAV_SPEED" if family is ARDUPILOT else "MPC_XY_CRUISE"
    begun = vehicle.connection.now()
    assert vehicle.parameters(["NO_SUCH_FENCE", "NOR_THIS"]) == {}
    assert vehicle.connection.now() - begun <= within_s
    assert vehicle.parameters([there, "NO_SUCH_FENCE"]).keys() == {there}


@pytest.mark.parametrize("seed", range(10))
def test_over_a_bad_radio_what_it_has_is_found_all_the_same(seed: int) -> None:
    radio = Faults(loss=0.2, duplicate=0.1, delay_s=0.3, reorder=0.1)
    vehicle = meet(Connection(Loopback(Station(Mock(PX4, HOME)), radio, seed), Codec(245, 190)))
    wanted = ["MPC_XY_CRUISE", "NO_SUCH_NAME", "MPC_ACC_HOR", "GF_ACTION"]
    assert list(vehicle.parameters(wanted)) == ["MPC_XY_CRUISE", "MPC_ACC_HOR", "GF_ACTION"]


def test_a_parameter_is_set_in_the_type_that_it_has_and_read_back() -> None:
    def bits(whole: int) -> float:
        return float(struct.unpack("<f", struct.pack("<i", whole))[0])

    sent = said_by(orders.set_parameter("A", 3.0, PX4), [value_of("A", bits(2), 6), value_of("MAV_SYS_ID", 1.0)])
    assert sent == [ParamRequestRead("A"), ParamRequestRead("MAV_SYS_ID"), ParamSet("A", bits(3), 6)]
    with refuses("unknown-parameter", "", "parameter A", kind=NoAnswer):
        lead(
            orders.set_parameter("A", 3.0, PX4),
            *[[], [value_of("MAV_SYS_ID", 1.0)], [], [value_of("SYS_AUTOSTART", 1.0)]] * 2,
        )
    asked: list[list[Message]] = [[value_of("A", 2.0, 2)], [value_of("MAV_SYSID", 1.0, 2)], []]
    assert lead(orders.set_parameter("A", 3.0, ARDUPILOT), *asked, [value_of("A", 3.0, 2)]).finished
    with refuses("parameter-kept", "A", "3", "2"):
        lead(orders.set_parameter("A", 3.0, ARDUPILOT), *asked, [value_of("A", 2.0, 2)])


@pytest.mark.parametrize("autopilot", [PX4, ARDUPILOT])
def test_reads_in_a_row_do_not_take_late_answers_for_absence(autopilot: Autopilot) -> None:
    vehicle = meet(Connection(Loopback(Station(Mock(autopilot, HOME))), Codec(245, 190)))
    names = list(autopilot.assumed_parameters())
    table = autopilot.parameter_table
    for at in range(0, len(names), 8):
        spelled = [[other for other, _ in table.spellings(name)] for name in names[at : at + 8]]
        there = {name for entry in spelled for name in entry} & {*table.moving, *table.renamed}
        assert there & set(vehicle.parameters(spelled)) or not there
    reported = vehicle.parameters([name for name, _ in table.spellings(older)] for older in table.moving)
    assert table.by_old_names(reported).keys() == table.moving.keys()
