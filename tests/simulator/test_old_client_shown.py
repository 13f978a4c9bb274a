"""Faults of client 0.1.0 on real autopilots appear on the built-in one; answers are those of the real ones."""

from collections.abc import Sequence

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import (
    Ack,
    CommandAck,
    CommandLong,
    Count,
    Current,
    Heartbeat,
    ItemAt,
    Message,
    MissionType,
    ParamRequestRead,
    ParamSet,
    ParamValue,
    Position,
    Reached,
    Request,
    RequestList,
    Result,
    SetCurrent,
    Text,
)
from ipoa_mission.mission.items import Item, land, takeoff, waypoint
from ipoa_mission.mission.stored_mission import home_item
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as BuiltIn
from ipoa_mission.simulator.situation import Conditions
from tests.link_pair import CLIENT, HOME, STRANGER

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
AWAY = Geodetic(47.4002, 8.5)
LEGS = (takeoff(HOME, 10.0), waypoint(AWAY, 10.0), waypoint(Geodetic(47.4004, 8.5), 10.0), land(AWAY))


class Session:
    """A vehicle, and whatever it says to a ground station."""

    def __init__(self, autopilot: Autopilot, cold: bool = False) -> None:
        self.vehicle = BuiltIn(autopilot, HOME, conditions=Conditions(cold=cold))
        self.now = 1.0
        self.first = int(autopilot is ARDUPILOT)

    def say(self, *messages: Message) -> list[Message]:
        for message in messages:
            self.vehicle.receive(message, CLIENT, self.now)
        return [message for message, _ in self.vehicle.outgoing()]

    def order(self, number: int, *params: float) -> list[object]:
        messages = self.say(CommandLong(number, (*params, *(0.0,) * (7 - len(params)))))  # type: ignore[arg-type]
        return [
            message.result if isinstance(message, CommandAck) else message.text
            for message in messages
            if isinstance(message, CommandAck | Text)
        ]

    def wait(self, seconds: float) -> list[Message]:
        until, messages = self.now + seconds, []
        while self.now < until:
            self.now += 0.05
            self.vehicle.tick(self.now)
            messages += [message for message, _ in self.vehicle.outgoing()]
        return messages

    def upload(self, items: Sequence[Item], kind: int = MissionType.MISSION) -> list[Message]:
        wire = [home_item(HOME), *items] if self.first and kind == MissionType.MISSION else items
        return self.say(Count(len(wire), kind), *(ItemAt(seq, item, kind) for seq, item in enumerate(wire)))

    def land(self) -> list[Message]:
        messages: list[Message] = []
        while self.vehicle.flight.armed:
            messages += self.wait(1.0)
        return messages


def test_px4_flown_again_begins_where_it_was_broken_off() -> None:
    session = Session(PX4)
    session.upload(LEGS)
    session.order(400, 1.0)
    session.order(176, 1.0, 4.0, 4.0)
    while session.vehicle.flight.current < 2:
        session.wait(0.5)
    session.order(176, 1.0, 4.0, 5.0)
    session.land()
    session.upload(LEGS)
    session.order(400, 1.0)
    words = session.order(176, 1.0, 4.0, 4.0)
    flown = {message.seq for message in session.land() if isinstance(message, Reached)}
    assert "Climb to 10.0 meters above home\t" in [str(word) for word in words] or flown
    assert 0 not in flown
    session.say(SetCurrent(0))  # what the client says now
    assert next(message for message in session.wait(1.5) if isinstance(message, Current)).seq == 0


def test_ardupilot_reports_only_waypoints_unasked() -> None:
    session = Session(ARDUPILOT)
    session.upload(LEGS)
    session.order(400, 1.0)
    session.order(300)
    messages = session.land()
    kinds = {type(message) for message in messages}
    assert not kinds & {Current, Position}
    assert len(LEGS) not in {message.seq for message in messages if isinstance(message, Reached)}


def test_fence_items_come_back_with_another_flag() -> None:
    circle = Item(5003, 3, (100.0, 0.0, 0.0, 0.0), 47.4, 8.5, 0.0)
    for autopilot in registered():
        session = Session(autopilot)
        session.upload([circle], MissionType.FENCE)
        messages = session.say(RequestList(MissionType.FENCE), Request(0, MissionType.FENCE))
        assert [message.item.autocontinue for message in messages if isinstance(message, ItemAt)] == [False]


def test_ardupilot_without_a_position_arms_and_refuses_the_mission() -> None:
    session = Session(ARDUPILOT, cold=True)
    session.now = 25.0
    session.upload(LEGS)
    assert session.order(400, 1.0) == [0, "Arming motors"]
    assert session.order(300) == [4, "Mode change to AUTO failed: requires position"]
    assert session.vehicle.flight.armed
    assert "Disarming motors" in [each.text for each in session.wait(11.0) if isinstance(each, Text)]  # DISARM_DELAY
    assert session.order(176, 1.0, 4.0)[0] == 0  # disarmed, it takes any mode
    assert session.order(400, 1.0) == [4, "Arm: Need Position Estimate"]
    assert session.order(401) == [0, "PreArm: Need Position Estimate"]
    session.wait(10.0)
    assert session.order(400, 1.0) == [0, "Arming motors"]


def test_ardupilot_cannot_arm_a_second_flight_in_the_mode_of_the_first() -> None:
    session = Session(ARDUPILOT)
    session.upload(LEGS)
    session.order(400, 1.0)
    session.order(300)
    session.land()
    assert session.order(400, 1.0) == [4, "Arm: AUTO mode not armable"]
    session.order(176, 1.0, 4.0)
    assert session.order(400, 1.0) == [0, "Arming motors"]
    assert session.order(300)[0] == 0


def test_ardupilot_knows_no_way_to_clear_everything_at_once() -> None:
    from ipoa_mission.link.messages import ClearAll

    session = Session(ARDUPILOT)
    session.upload(LEGS)
    assert Ack(Result.UNSUPPORTED, MissionType.ALL) in session.say(ClearAll(MissionType.ALL))


def test_ardupilot_climbs_by_command_in_guided_alone() -> None:
    session = Session(ARDUPILOT)
    session.order(400, 1.0)
    assert session.order(22, *(0.0,) * 6, 8.0) == [4]
    session.order(176, 1.0, 4.0)
    assert session.order(22, *(0.0,) * 6, 8.0) == [0]
    session.wait(15.0)
    assert session.vehicle.flight.place[2] == pytest.approx(8.0, abs=0.3)
    assert session.order(400, 0.0) == [4]


@pytest.mark.parametrize("autopilot", registered())
def test_nobody_ends_the_heartbeat_for_another(autopilot: Autopilot) -> None:
    session = Session(autopilot)
    session.vehicle.receive(Heartbeat(6, 8), STRANGER, session.now)
    assert session.order(511, 0.0, -1.0) == [0 if autopilot is ARDUPILOT else 4]
    assert sum(isinstance(message, Heartbeat) for message in session.wait(5.0)) == 5


@pytest.mark.parametrize(
    ("autopilot", "name", "kind", "expected"),
    [
        (ARDUPILOT, "FENCE_ENABLE", 2, 0.0),
        (ARDUPILOT, "RTL_ALT", 6, 1500.0),
        (PX4, "GF_ACTION", 6, 2.802596928649634e-45),
        (PX4, "MPC_XY_CRUISE", 9, 5.0),
    ],
)
def test_a_parameter_has_the_type_that_its_firmware_declares(
    autopilot: Autopilot, name: str, kind: int, expected: float
) -> None:
    session = Session(autopilot)
    (value,) = [message for message in session.say(ParamRequestRead(name)) if isinstance(message, ParamValue)]
    assert (value.param_type, value.param_value) == (kind, expected)
    session.say(ParamSet(name, 1.0, 9))
    assert session.vehicle.table.values[name] == (1.0 if autopilot is ARDUPILOT or kind == 9 else 2.0)
