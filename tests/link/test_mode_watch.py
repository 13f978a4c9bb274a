import logging

import pytest

from ipoa_mission.autopilot.autopilot import QUADROTOR, Autopilot, registered
from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.conversations import REASON_TIMEOUT_S
from ipoa_mission.link.flight_order import ORDER_REPEATS, FlightOrder
from ipoa_mission.link.messages import (
    CommandAck,
    CommandLong,
    CommandResult,
    ExtendedState,
    Heartbeat,
    Message,
    Position,
    Text,
)
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import ON_GROUND, SETTLED_S, ModeWatch, VehicleState
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.examples import some
from tests.link.suited import suited
from tests.link_pair import connection_of, far_end
from tests.px4_waypoints import waypoint

HOME = Geodetic(47.4, 8.5, 400.0)
THERE = Geodetic(47.4010, 8.5, 400.0)
MISSION = Mission(HOME, (takeoff(HOME, 5.0), waypoint(THERE, 5.0), land(THERE)))
PILOT = Target(254, 190)
IN_AIR = 2


def flying(family: Autopilot) -> Vehicle:
    vehicle = meet(Connection(Loopback(Station(Mock(family, HOME))), Codec(245, 190)))
    vehicle.upload(suited(vehicle, MISSION))
    vehicle.prepare()
    vehicle.start()
    return vehicle


def ordered_into(vehicle: Vehicle, mode: int) -> None:
    main, sub, *_ = (*vehicle.autopilot.modes.numbers(mode), 0.0)
    order = CommandLong(VehicleCommand.DO_SET_MODE, (1.0, main, sub, 0.0, 0.0, 0.0, 0.0))
    far_end(connection_of(vehicle)).autopilot.receive(order, PILOT, vehicle.connection.now())


@pytest.mark.parametrize("family", registered())
def test_mode_watch_reports_hold_and_resume_within_seconds(family: Autopilot, caplog: pytest.LogCaptureFixture) -> None:
    vehicle = flying(family)
    held_s: list[float] = []
    told_s: list[float] = []

    def overhear(message: Message) -> None:
        now = vehicle.connection.now()
        if isinstance(message, Position) and message.height > 4.0 and not held_s:
            held_s.append(now)
            ordered_into(vehicle, family.modes.hold)
        if vehicle.mode_change and not told_s:
            told_s.append(now)
            assert f"in {family.modes.name(family.modes.hold)}" in vehicle.mode_change
            assert "it stays in this mode" in vehicle.mode_change
            ordered_into(vehicle, family.modes.mission)

    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert record.completed
    assert told_s[0] - held_s[0] < SETTLED_S + 1.5
    assert vehicle.mode_change == ""
    warnings = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert "`resume` or `rtl` orders it on" in warnings[0]
    assert [words.split(":")[0] for words in warnings] == [
        "the vehicle has left its mission",
        "the vehicle continues its mission",
    ]


@pytest.mark.parametrize("family", registered())
def test_a_vehicle_sent_home_ends_its_flight_with_that_mode(
    family: Autopilot, caplog: pytest.LogCaptureFixture
) -> None:
    vehicle = flying(family)
    changes: list[str] = []

    def overhear(message: Message) -> None:
        if isinstance(message, Position) and message.height > 4.0 and not changes:
            changes.append("")
            ordered_into(vehicle, family.modes.returning)
        if vehicle.mode_change and len(changes) == 1:
            changes.append(vehicle.mode_change)

    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert "it returns home and lands" in changes[1]
    assert "`resume`" not in caplog.text
    assert not record.completed
    assert f"in {family.modes.name(family.modes.returning)}" in record.why_not


def leaving(family: Autopilot, landed: int = IN_AIR) -> tuple[VehicleState, ModeWatch]:
    state = VehicleState(family)
    state.note(ExtendedState(landed))
    return state, ModeWatch(state)


def heard(state: VehicleState, leaving: ModeWatch, *messages: tuple[float, Message]) -> str:
    with leaving.watched(frozenset({state.autopilot.modes.mission})):
        for now, message in messages:
            state.note(message)
            leaving.note(message, now)
        return leaving.words


def beat(family: Autopilot, mode: int, armed: bool = True) -> Heartbeat:
    return Heartbeat(QUADROTOR, family.mav_autopilot, 128 * armed, mode)


@pytest.mark.parametrize("family", registered())
@pytest.mark.parametrize("lost", some(2, [3, 99, 0]))
def test_an_order_to_end_the_flight_is_given_until_the_vehicle_shows_it(
    family: Autopilot, lost: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle, mode = flying(family), family.modes.landing
    mock = far_end(connection_of(vehicle)).autopilot
    heard, messages = mock.receive, list[Message]()

    def receive(message: Message, source: Target, now: float) -> None:
        if isinstance(message, CommandLong) and message.command == VehicleCommand.DO_SET_MODE:
            messages.append(message)
            if len(messages) <= lost:
                return
        heard(message, source, now)

    def overhear(message: Message) -> None:
        if isinstance(message, Position) and message.height > 4.0 and not ordered:
            ordered.append(mode)
            vehicle.order.give(mode)

    ordered: list[int] = []
    monkeypatch.setattr(mock, "receive", receive)
    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert record.completed is (lost == 99)
    assert len(messages) == min(lost + 1, ORDER_REPEATS)
    assert ("does not show it" in vehicle.order.words) is (lost == 99)


@pytest.mark.parametrize("family", registered())
def test_a_refused_order_to_end_the_flight_is_reported_and_not_repeated(family: Autopilot) -> None:
    state, refused = VehicleState(family), CommandAck(VehicleCommand.DO_SET_MODE, CommandResult.DENIED)
    state.note(beat(family, family.modes.mission))
    now = 0.0
    order = FlightOrder(state, lambda: now)
    order.give(family.modes.landing)
    assert len(list(order.observe(refused, 0.0))) == 1  # what was refused before it was another's
    assert list(order.observe(refused, 0.0)) == []
    now = REASON_TIMEOUT_S
    assert list(order.observe(beat(family, family.modes.mission), 0.0)) == []
    assert "DENIED" in order.words
    assert order.is_refused
    assert list(order.observe(beat(family, family.modes.mission), 0.0)) == []


def test_a_refused_order_is_reported_with_the_vehicle_s_reason() -> None:
    family = Autopilot.ARDUPILOT
    state = VehicleState(family)
    state.note(beat(family, family.modes.returning))
    now = 0.0
    order = FlightOrder(state, lambda: now)
    order.go_on()
    assert len(list(order.observe(beat(family, family.modes.returning), 0.0))) == 1
    list(order.observe(CommandAck(VehicleCommand.DO_SET_MODE, CommandResult.FAILED), 0.0))
    list(order.observe(Text(4, "Mode change to AUTO failed: init failed"), 0.0))
    now = REASON_TIMEOUT_S
    list(order.observe(beat(family, family.modes.returning), 0.0))
    assert order.words == "Mode change to AUTO failed: init failed"


@pytest.mark.parametrize("family", registered())
@pytest.mark.parametrize("climbs", [True, False])  # within a take-off ArduCopter does not pause
def test_a_watched_vehicle_holds_and_goes_on_when_ordered(family: Autopilot, climbs: bool) -> None:
    vehicle = flying(family)
    places: list[Position] = []
    paused: list[bool] = []

    def overhear(message: Message) -> None:
        if not isinstance(message, Position):
            return
        if (message.height > 2.0 if climbs else message.latitude_deg > 47.4003) and not places:
            vehicle.order.hold()
        if vehicle.order.is_paused or vehicle.state.custom_mode == family.modes.hold:
            places.append(message)
            paused.append(vehicle.order.is_paused)
            if len(places) > 1 and message.time_s - places[0].time_s > 20.0 and not resting:
                resting.append(message)
                vehicle.order.go_on()

    resting: list[Position] = []
    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert record.completed
    assert vehicle.order.words == ""
    assert all(paused) is (family.protocol_profile.pauses_in_mission and not climbs)
    rested = next(place for place in places if place.time_s - places[0].time_s > 10.0)
    assert abs(rested.height - resting[0].height) < 1.0
    assert abs(rested.latitude_deg - resting[0].latitude_deg) * 111e3 < 1.0


def test_an_order_to_go_on_that_is_refused_is_told() -> None:
    family = Autopilot.ARDUPILOT  # which pauses within its mission
    state = VehicleState(family)
    state.note(beat(family, family.modes.mission))
    now = 0.0
    order = FlightOrder(state, lambda: now)
    order.is_paused = True
    order.go_on()
    assert len(list(order.observe(beat(family, family.modes.mission), 0.0))) == 1
    assert list(order.observe(CommandAck(Command.DO_PAUSE_CONTINUE, CommandResult.IN_PROGRESS), 0.0)) == []
    list(order.observe(CommandAck(Command.DO_PAUSE_CONTINUE, CommandResult.FAILED), 0.0))
    now = REASON_TIMEOUT_S
    list(order.observe(beat(family, family.modes.mission), 0.0))
    assert order.words == "go on: the vehicle answered FAILED"
    assert order.is_paused
    state.note(beat(family, family.modes.mission, armed=False))
    order.go_on()
    assert list(order.observe(beat(family, family.modes.mission, armed=False), 0.0)) == []


@pytest.mark.parametrize("family", registered())
def test_mode_watch_reports_only_current_status_texts(family: Autopilot) -> None:
    hold = beat(family, family.modes.hold)
    old, why, chat = Text(2, "Old trouble"), Text(4, "Fence breached\t"), Text(6, "Reached command #2")
    words = heard(*leaving(family), (1.0, old), (9.0, chat), (9.5, why), (10.0, hold), (11.1, hold))
    assert words.endswith("; it says: Fence breached")
    assert "and does not say why" in heard(*leaving(family), (10.0, hold), (11.1, hold))


@pytest.mark.parametrize("family", registered())
def test_each_mode_that_it_leaves_for_is_told_with_its_own_reason(family: Autopilot) -> None:
    hold, home = beat(family, family.modes.hold), beat(family, family.modes.returning)
    why = Text(4, "Fence breached")
    words = heard(*leaving(family), (9.5, why), (10.0, hold), (11.1, hold), (20.0, home), (21.1, home))
    assert f"in {family.modes.name(family.modes.returning)}: it returns home and lands, and does not say why" in words


@pytest.mark.parametrize("family", registered())
def test_mode_watch_ignores_short_modes_ground_and_unwatched_time(family: Autopilot) -> None:
    hold, mission = beat(family, family.modes.hold), beat(family, family.modes.mission)
    assert heard(*leaving(family), (10.0, hold), (10.5, mission), (12.0, mission)) == ""
    assert heard(*leaving(family), (10.0, hold), (10.5, mission), (11.2, hold)) == ""
    assert heard(*leaving(family, ON_GROUND), (10.0, hold), (12.0, hold)) == ""
    assert heard(*leaving(family), (10.0, beat(family, family.modes.hold, armed=False)), (12.0, mission)) == ""
    state, unwatched = leaving(family)
    state.note(hold)
    unwatched.note(hold, 10.0)
    unwatched.note(hold, 12.0)
    assert unwatched.words == ""
