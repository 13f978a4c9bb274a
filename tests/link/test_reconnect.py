import logging
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.flight.preflight import without_station
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.interrupts import Interrupt
from ipoa_mission.link import reconnect
from ipoa_mission.link.channel import LinkDown, Peer
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import Cancelled, NoAnswer
from ipoa_mission.link.messages import CommandLong, Heartbeat, Message, MissionType, Position
from ipoa_mission.link.reconnect import GIVE_UP_S, SILENT_S
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.examples import some
from tests.link.suited import suited
from tests.px4_waypoints import waypoint
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
THERE, BEYOND = Geodetic(47.4010, 8.5, 400.0), Geodetic(47.4015, 8.5, 400.0)
MISSION = Mission(HOME, (takeoff(HOME, 5.0), waypoint(THERE, 5.0), waypoint(BEYOND, 5.0), land(BEYOND)))
OTHER = replace(MISSION, items=(*MISSION.items[:2], land(THERE)))
ORDERS = frozenset({VehicleCommand.DO_SET_MODE, Command.DO_PAUSE_CONTINUE, Command.COMPONENT_ARM_DISARM})
ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4


class Air(Loopback):
    """Lost while `ends_s` is ahead: silent, or broken until opened again."""

    ends_s = -1.0
    breaks = deaf = False

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        if self.breaks:
            raise LinkDown("gone")
        while True:
            got = super().receive(until)
            if got and not self.is_lost:
                return got
            if self.now() >= until:
                return []

    def send(self, data: bytes, peer: Peer | None) -> None:
        if not (self.is_lost or self.deaf):
            super().send(data, peer)

    @property
    def is_lost(self) -> bool:
        return self.now() < self.ends_s

    def again(self) -> "Air":
        if self.is_lost:
            raise LinkDown("not yet")
        self.breaks = False
        return self

    def rest(self, seconds: float) -> None:
        super().receive(self.now() + seconds)


class Heard(Station):
    def __init__(self, autopilot: Mock, system: int = 1) -> None:
        super().__init__(autopilot, system)
        self.received: list[Message] = []
        receive = autopilot.receive

        def hear(message: Message, *where: Any) -> None:
            self.received.append(message)
            receive(message, *where)

        autopilot.receive = hear  # type: ignore[method-assign,assignment]


class Flight:
    """A vehicle in its mission whose link is lost; `then` happens as it is lost."""

    def __init__(self, family: Autopilot, monkeypatch: pytest.MonkeyPatch, opens: bool = True) -> None:
        self.station = Heard(Mock(family, HOME))
        self.air = Air(self.station)
        self.connection = Connection(self.air, Codec(245, 190), again=self.air.again if opens else None)
        monkeypatch.setattr(reconnect, "time", SimpleNamespace(sleep=self.air.rest))
        self.vehicle = meet(self.connection)
        self.vehicle.upload(suited(self.vehicle, MISSION))
        self.vehicle.link_loss.meanwhile = without_station(self.vehicle)
        self.vehicle.prepare()
        self.vehicle.start()
        self.words: list[str] = []
        self.received_before = 0
        self.at_loss: Callable[[], None] = lambda: None
        self.in_loss: Callable[[], None] = lambda: None
        self.on_return: Callable[[], None] = lambda: None

    def lose(self, seconds: float, breaks: bool = False, at_m: float = 4.0) -> Any:
        vehicle, air = self.vehicle, self.air

        def overhear(message: Message) -> None:
            if isinstance(message, Position) and message.height > at_m and air.ends_s < 0.0:
                air.ends_s, air.breaks = air.now() + seconds, breaks
                self.received_before = len(self.station.received)
                self.at_loss()
            if vehicle.mode_change:
                self.on_return()

        def progress(share: float, words: str) -> None:
            self.words.append(words)
            if "link lost" in words:
                assert vehicle.link_loss.seconds is not None
                self.in_loss()

        vehicle.overhearing = overhear
        return vehicle.watch(progress)

    def order_elsewhere(self, mode: int) -> None:
        main, sub, *_ = (*self.vehicle.autopilot.modes.numbers(mode), 0.0)
        order = CommandLong(VehicleCommand.DO_SET_MODE, (1.0, main, sub, 0.0, 0.0, 0.0, 0.0))
        self.station.autopilot.receive(order, Target(254, 190), self.air.now())

    def replaced_by(self, mock: Mock, system: int = 1) -> Heard:
        station = self.air.far = Heard(mock, system)
        return station


def is_order(message: Message) -> bool:
    return isinstance(message, CommandLong) and message.command in ORDERS


def loaded(family: Autopilot, mission: Mission) -> Mock:
    mock = Mock(family, HOME)
    twin = meet(Connection(Loopback(Station(mock)), Codec(245, 190)))
    twin.upload(suited(twin, mission))
    return mock


@pytest.mark.parametrize("breaks", [False, True])
@pytest.mark.parametrize("seconds", some(1, [10.0, 3.2, 30.0]))
@pytest.mark.parametrize("family", registered())
def test_a_flight_is_watched_on_where_it_is_when_the_link_is_there_again(
    family: Autopilot, seconds: float, breaks: bool, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    flight = Flight(family, monkeypatch)
    flight.in_loss = flight.vehicle.order.hold
    record = flight.lose(seconds, breaks)
    assert record.completed, record.why_not
    assert not any(map(is_order, flight.station.received[flight.received_before :]))
    assert flight.vehicle.order.words.endswith("was not ordered: the link is lost")
    warnings = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert warnings[0].startswith("the link is lost")
    assert "without its ground station the vehicle continues" in warnings[0]
    assert "it is the same vehicle, with the mission that was uploaded" in warnings[1]
    assert len(warnings) == 2
    assert sum("link lost for" in words for words in flight.words) >= seconds - SILENT_S
    assert flight.vehicle.link_loss.seconds is None
    lost = [b.time_s - a.time_s for a, b in zip(record.path, record.path[1:], strict=False)]
    assert seconds - 0.5 < max(lost) < seconds + 4.0
    assert len(record.item_reached_s) == len(MISSION.items)


def test_reconnect_reads_after_a_suspended_process_count_later(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    flight = Flight(PX4, monkeypatch)
    receive, stood = flight.air.receive, list[float]()
    flight.at_loss = lambda: stood.append(SILENT_S + 1.0)

    def late(until: float) -> list[tuple[bytes, Peer]]:
        got = receive(until)
        if got and stood:
            flight.air._now += stood.pop()
        return got

    monkeypatch.setattr(flight.air, "receive", late)
    record = flight.lose(0.0)
    assert record.completed, record.why_not
    warnings = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert warnings[0].startswith("the link is lost")
    assert "it is the same vehicle" in warnings[1]


def test_one_that_has_left_its_mission_unheard_is_told_of_when_it_is_heard(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    flight = Flight(PX4, monkeypatch)
    flight.at_loss = lambda: flight.order_elsewhere(PX4.modes.hold)
    flight.on_return = lambda: flight.order_elsewhere(PX4.modes.mission)
    assert flight.lose(20.0).completed
    assert ", and its reason may not have been heard" in caplog.text
    assert "the vehicle continues its mission" in caplog.text


@pytest.mark.parametrize("family", registered())
def test_an_unconfirmed_order_is_not_repeated_after_a_link_loss(
    family: Autopilot, monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = Flight(family, monkeypatch)
    flight.at_loss = flight.vehicle.order.hold
    record = flight.lose(20.0)
    assert record.completed
    assert "was ordered, and the link was lost before the vehicle showed it" in flight.vehicle.order.words


@pytest.mark.parametrize("family", registered())
def test_one_that_came_home_unheard_is_told_as_it_stands(
    family: Autopilot, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    flight = Flight(family, monkeypatch)
    mode = family.modes.returning
    flight.at_loss = lambda: flight.order_elsewhere(mode)
    record = flight.lose(120.0)
    assert not record.completed
    assert (
        "it was last heard at item 1 of 4, and landed while the link was lost, 167 m from the place of its LAND"
        in record.why_not
    )
    assert (f"in {family.modes.name(mode)}" in record.why_not) is (family is ARDUPILOT)  # PX4 changes it
    assert not record.armed
    assert "it landed while the link was lost, at the latest" in caplog.text


def test_one_that_ended_its_mission_unheard_has_completed_it_if_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    record = Flight(PX4, monkeypatch).lose(120.0)
    assert record.completed, record.why_not
    record = Flight(ARDUPILOT, monkeypatch).lose(120.0)  # restarts its mission on the ground
    assert record.why_not.startswith("it was last heard at item 1 of 4, and landed while the link was lost, ")


@pytest.mark.parametrize("family", registered())
def test_another_kind_in_its_place_is_told_nothing(family: Autopilot, monkeypatch: pytest.MonkeyPatch) -> None:
    flight, others = Flight(family, monkeypatch), list[Heard]()
    other_family = next(autopilot for autopilot in registered() if autopilot is not family)
    flight.at_loss = lambda: others.append(flight.replaced_by(Mock(other_family, HOME)))
    with refuses("other-kind", "", "ArduPilot") as unlike:
        flight.lose(10.0)
    assert {type(message) for message in others[0].received} <= {Heartbeat}
    assert unlike.value.hint is not None
    assert "when last heard, the vehicle is armed and in the air" in unlike.value.hint


@pytest.mark.parametrize("family", registered())
def test_another_mission_is_told_nothing_and_that_is_said(family: Autopilot, monkeypatch: pytest.MonkeyPatch) -> None:
    flight, others, mock = Flight(family, monkeypatch), list[Heard](), loaded(family, OTHER)
    flight.at_loss = lambda: others.append(flight.replaced_by(mock))
    flight.in_loss = lambda: flight.vehicle.order.give(family.modes.returning)
    with refuses("not-the-same-vehicle", "", "vehicle 1"):
        flight.lose(10.0)
    assert not any(map(is_order, others[0].received))
    assert not flight.vehicle.record().completed


def test_a_vehicle_that_was_restarted_or_tells_another_version_is_another(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = Flight(PX4, monkeypatch)
    flight.at_loss = lambda: setattr(flight.vehicle._logbook, "clock_s", 1e5)
    with refuses("not-the-same-vehicle"):
        flight.lose(5.0)
    flight = Flight(PX4, monkeypatch)
    assert flight.vehicle._about is not None
    flight.vehicle._about = replace(flight.vehicle._about, uid=7)
    with refuses("not-the-same-vehicle", "", "AUTOPILOT_VERSION"):
        flight.lose(5.0)


def test_other_system_ids_are_named_until_the_vehicle_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    flight, others = Flight(PX4, monkeypatch), list[Heard]()
    flight.at_loss = lambda: others.append(flight.replaced_by(Mock(PX4, HOME), 7))
    with refuses("link-lost", "", "300", "vehicle 7", kind=NoAnswer):
        flight.lose(5.0)
    assert {type(message) for message in others[0].received} <= {Heartbeat}
    assert flight.air.now() > GIVE_UP_S


def test_one_that_is_heard_and_does_not_answer_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = Flight(ARDUPILOT, monkeypatch)
    flight.at_loss = lambda: setattr(flight.air, "deaf", True)
    with refuses("link-lost", "", "300", kind=NoAnswer):
        flight.lose(5.0)
    assert any("link lost for 100 s; it was heard, but" in words for words in flight.words)


def test_a_vehicle_that_holds_another_mission_already_is_known_without_it(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    flight = Flight(PX4, monkeypatch)
    flight.at_loss = lambda: setattr(flight.vehicle._onboard_lists[MissionType.MISSION], "changed", "it is another")
    assert flight.lose(10.0).why_not == "the mission on the vehicle is no longer ours: it is another"
    assert "it is the same vehicle\n" in caplog.text


@pytest.mark.parametrize("refuses", [False, True])
def test_streams_that_were_forgotten_are_asked_for_again(refuses: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    flight = Flight(ARDUPILOT, monkeypatch)
    schedule = flight.station.autopilot._schedule

    def forget() -> None:
        for name in [*schedule._due]:
            if name != "HEARTBEAT":
                del schedule._due[name], schedule._intervals[name]
        if refuses:
            monkeypatch.setattr(schedule, "set_interval", lambda *_: False)

    flight.at_loss = forget
    record = flight.lose(10.0)
    assert record.completed is not refuses  # watched by heartbeats only
    assert not record.armed


def test_a_link_that_was_lent_is_not_opened_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = Flight(PX4, monkeypatch, opens=False)
    assert not flight.connection.reopens
    with refuses("link-down", "", "gone"):
        flight.lose(10.0, breaks=True)


def test_ctrl_c_ends_the_watch_while_the_link_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = Flight(PX4, monkeypatch)
    monkeypatch.setattr(Interrupt, "take", lambda self: flight.vehicle.link_loss.seconds is not None)
    with pytest.raises(Cancelled):
        flight.lose(10.0)
