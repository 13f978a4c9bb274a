import logging
import random
from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.forecast.conformance import ConformanceMonitor
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.codec import Codec, Heard, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.flight_order import PositionLoss
from ipoa_mission.link.messages import (
    CommandAck,
    CommandLong,
    CommandResult,
    Current,
    ExtendedState,
    Heartbeat,
    Message,
    Position,
)
from ipoa_mission.link.orders import command_long
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.flight_record import Deviation, DeviationKind, OnDeviation
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link_pair import connection_of, far_end
from tests.px4_waypoints import waypoint
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)


def place(east: float, north: float) -> Geodetic:
    return LocalFrame(HOME).geodetic(np.array([east, north, 0.0]))


def mission(family: Autopilot, *places: Geodetic) -> Mission:
    return Mission(HOME, (takeoff(HOME, 5.0), *(waypoint(at, 5.0) for at in places), land(places[-1])), family)


def begun(family: Autopilot, forecast: Mission | None = None) -> tuple[Vehicle, list[CommandLong]]:
    """Fly 150 m east and 60 m north, against another forecast."""
    vehicle = meet(Connection(Loopback(Station(Mock(family, HOME))), Codec(245, 190)))
    flown = mission(family, place(150.0, 0.0), place(150.0, 60.0))
    vehicle.upload(flown)
    vehicle.conformance.begin(ConformanceMonitor(Forecast(forecast or flown)))
    vehicle.prepare()
    vehicle.start()
    mock, commands = far_end(connection_of(vehicle)).autopilot, list[CommandLong]()
    heard = mock.receive

    def receive(message: Message, source: Target, now: float) -> None:
        if isinstance(message, CommandLong):
            commands.append(message)
        heard(message, source, now)

    mock.receive = receive
    return vehicle, commands


def elsewhere(family: Autopilot) -> Mission:
    return mission(family, place(60.0, 0.0), place(60.0, 60.0))


@pytest.mark.parametrize("family", registered())
def test_a_flight_as_forecast_is_not_disturbed(family: Autopilot) -> None:
    vehicle, _ = begun(family)
    record = vehicle.watch()
    assert record.completed, record.why_not
    assert record.deviations == ()
    assert record.failure == ""


@pytest.mark.parametrize("lasting", [True, False])
@pytest.mark.parametrize("family", registered())
def test_a_loss_of_positions_alone_is_warned_of_and_ends_the_comparison(
    family: Autopilot, lasting: bool, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    vehicle, commands = begun(family)
    whole = Connection.receive
    requests = list[CommandLong]()

    def receive(connection: Connection, until: float) -> list[Heard]:
        requests[:] = [each for each in commands if each.command == 511 and each.params[1] > 0.0]
        is_heard = len(requests) >= 2 and not lasting
        return [each for each in whole(connection, until) if is_heard or not is_high(each.message)]

    monkeypatch.setattr(Connection, "receive", receive)
    record = vehicle.watch()
    words = "the flight was not compared for {} s: no position was heard"
    warned = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert warned[0] == words.format(3) + "; its stream is requested again"
    assert not record.completed
    assert record.failure == words.format(int(record.failure.split()[6]))
    assert (int(record.failure.split()[6]) > 20) is lasting
    assert (len(requests) > 5) is lasting
    assert {each.params[:2] for each in requests} == {(33.0, 50_000.0)}


def is_high(message: Message | None) -> bool:
    return isinstance(message, Position) and message.height > 4.0


@pytest.mark.parametrize("interval_s", [0.05, 1.0])
def test_losses_of_a_radio_are_no_loss_of_positions(interval_s: float) -> None:
    chance = random.Random(5)
    positions = PositionLoss()
    others = (Heartbeat(2, 12), Current(1), Heartbeat(2, 12), ExtendedState(2))
    for tick in range(12_000):  # 10 minutes with half of all messages lost, in bursts of up to 2.5 s also all
        is_silent = tick % 400 < 50
        is_due = tick % round(interval_s / 0.05) == 0
        for message in (*others[: 1 + tick % 2], *[Position(0.0, 47.4, 8.5, 400.0, 20.0)] * is_due):
            if not is_silent and chance.random() < 0.5:
                assert not positions.note(message, 0.05 * tick, is_compared=True)
    assert positions.words == ""


@pytest.mark.parametrize("family", registered())
def test_one_that_deviates_holds_and_the_watching_ends(family: Autopilot, caplog: pytest.LogCaptureFixture) -> None:
    vehicle, commands = begun(family, elsewhere(family))
    reported = list[Deviation]()
    vehicle.conformance.report = reported.append
    record = vehicle.watch()
    assert [deviation.kind for deviation in record.deviations] in ([DeviationKind.OUTSIDE], [DeviationKind.PASSED])
    assert tuple(reported) == record.deviations
    assert (record.completed, record.armed, record.in_air) == (False, True, True)
    assert record.failure == f"it holds, because {record.deviations[0]}"
    assert record.deviations[0].time_s == pytest.approx(record.path[-1].time_s, abs=3.0)
    assert vehicle.conformance.is_held
    warned = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert warned[0] == f"{record.deviations[0]}; hold is ordered"
    orders = [command for command in commands if command.command in (Command.DO_PAUSE_CONTINUE, 176)]
    assert len(orders) == 1
    assert Command.COMPONENT_ARM_DISARM not in {command.command for command in commands}
    aside = LocalFrame(HOME).local(Geodetic(record.path[-1].latitude_deg, record.path[-1].longitude_deg, 400.0))
    assert 60.0 < aside[0] < 60.0 + 65.0


@pytest.mark.parametrize("family", registered())
def test_one_that_deviates_returns_if_that_was_chosen(family: Autopilot) -> None:
    vehicle, commands = begun(family, elsewhere(family))
    vehicle.conformance.on_deviation = OnDeviation.RTL
    record = vehicle.watch()
    assert (record.completed, record.armed, record.in_air) == (False, False, False)
    assert record.failure == f"rtl was ordered, because {record.deviations[0]}"
    assert Command.COMPONENT_ARM_DISARM not in {command.command for command in commands}


@pytest.mark.parametrize("family", registered())
def test_one_that_deviates_flies_on_if_only_a_report_was_chosen(family: Autopilot) -> None:
    vehicle, commands = begun(family, elsewhere(family))
    vehicle.conformance.on_deviation = OnDeviation.REPORT
    record = vehicle.watch()
    assert record.completed, record.why_not
    assert {each.kind for each in record.deviations} == {DeviationKind.OUTSIDE, DeviationKind.PASSED}
    assert record.failure.startswith("item 2: ")
    assert not {each.command for each in commands} & {Command.DO_PAUSE_CONTINUE, 176, Command.COMPONENT_ARM_DISARM}


@pytest.mark.parametrize("result", [CommandResult.DENIED, None])
@pytest.mark.parametrize("reaction", [OnDeviation.HOLD, OnDeviation.RTL])
@pytest.mark.parametrize("family", registered())
def test_a_flight_that_disobeyed_its_order_is_incomplete(
    family: Autopilot, reaction: OnDeviation, result: CommandResult | None
) -> None:
    """None: it does not answer."""
    vehicle, _ = begun(family, elsewhere(family))
    vehicle.conformance.on_deviation = reaction
    mock = far_end(connection_of(vehicle)).autopilot
    heard = mock.receive

    def receive(message: Message, source: Target, now: float) -> None:
        if not isinstance(message, CommandLong) or message.command not in (Command.DO_PAUSE_CONTINUE, 176):
            heard(message, source, now)
        elif result is not None:
            mock.vehicle.send(CommandAck(message.command, result), source)

    mock.receive = receive
    record = vehicle.watch()
    assert (record.completed, record.armed) == (False, False)
    assert record.why_not.startswith(f"{reaction} was ordered, because {record.deviations[0]}; ")
    assert ("DENIED" if result else "6 times") in record.why_not
    vehicle.conformance.begin(None)
    assert vehicle.conformance.why_not == ""


@pytest.mark.parametrize("reaction", [OnDeviation.HOLD, OnDeviation.RTL])
@pytest.mark.parametrize("family", registered())
def test_a_refused_order_is_given_again_until_the_vehicle_obeys(
    family: Autopilot, reaction: OnDeviation, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    vehicle, _ = begun(family, elsewhere(family))
    vehicle.conformance.on_deviation = reaction
    monitor = vehicle.conformance._monitor
    assert monitor is not None
    see = monitor.see
    monkeypatch.setattr(monitor, "see", lambda *seen: None if vehicle.conformance.deviations else see(*seen))
    mock = far_end(connection_of(vehicle)).autopilot
    heard, times_s = mock.receive, list[float]()

    def receive(message: Message, source: Target, now: float) -> None:
        is_order = isinstance(message, CommandLong) and message.command in (Command.DO_PAUSE_CONTINUE, 176)
        if isinstance(message, CommandLong) and is_order and (not times_s or now - times_s[0] < 9.0):
            times_s.append(now)
            mock.vehicle.send(CommandAck(message.command, CommandResult.TEMPORARILY_REJECTED), source)
        else:
            heard(message, source, now)

    mock.receive = receive
    record = vehicle.watch()
    assert 5.0 < times_s[-1] - times_s[0] < 7.0
    assert record.failure.startswith(("it holds" if reaction is OnDeviation.HOLD else "rtl was ordered") + ", because ")
    assert "REJECTED" not in record.failure
    assert (record.in_air, vehicle.conformance.is_held) == ((reaction is OnDeviation.HOLD,) * 2)
    nothing = f"nothing was done: the vehicle flies on; take it over; {reaction} is ordered again in 5 s"
    assert [each.getMessage() for each in caplog.records].count(nothing) == 2


@pytest.mark.parametrize("reaction", [OnDeviation.HOLD, OnDeviation.RTL])
@pytest.mark.parametrize("family", registered())
def test_no_order_is_repeated_after_the_pilot_took_over(family: Autopilot, reaction: OnDeviation) -> None:
    vehicle, _ = begun(family, elsewhere(family))
    vehicle.conformance.on_deviation = reaction
    mock, modes = far_end(connection_of(vehicle)).autopilot, family.modes
    chosen = modes.landing
    main, sub, *_ = (*modes.numbers(chosen), 0.0)
    heard, times_s = mock.receive, list[float]()

    def receive(message: Message, source: Target, now: float) -> None:
        if isinstance(message, CommandLong) and message.command in (Command.DO_PAUSE_CONTINUE, 176):
            times_s.append(now)  # and is lost
        else:
            heard(message, source, now)

    def overhear(message: Message) -> None:
        now = vehicle.connection.now()
        if times_s and now > times_s[0] + 0.5 and not taken_s:
            taken_s.append(now)
            heard(CommandLong(176, (1.0, main, sub, 0.0, 0.0, 0.0, 0.0)), Target(254, 190), now)

    taken_s = list[float]()
    mock.receive = receive
    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert times_s[-1] < taken_s[0] + 1.5  # until the next heartbeat
    assert not record.completed
    assert record.why_not.startswith(f"{reaction} was ordered, because {record.deviations[0]}; ")
    assert f"the pilot or the autopilot took over, in {modes.name(chosen)}" in record.why_not


@pytest.mark.parametrize("family", registered())
def test_watcher_may_order_the_mission_to_go_on(family: Autopilot) -> None:
    vehicle, _ = begun(family, elsewhere(family))
    vehicle.conformance.ends_held = False
    hold_times = list[float]()

    def overhear(message: Message) -> None:
        if isinstance(message, Position) and vehicle.conformance.is_held:
            hold_times.append(message.time_s)
            if hold_times[-1] - hold_times[0] > 10.0:
                vehicle.conformance.begin(None)
                vehicle.order.go_on()

    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert hold_times
    assert record.completed, record.why_not


@pytest.mark.parametrize("family", registered())
def test_watching_ends_in_the_air_when_the_user_s_time_is_up(family: Autopilot) -> None:
    vehicle, commands = begun(family)
    vehicle.give_up_after(25.0)
    with refuses("time-up") as ended:
        vehicle.watch()
    assert "armed and in the air" in (ended.value.hint or "")
    assert not {each.command for each in commands} & {Command.DO_PAUSE_CONTINUE, 176, Command.COMPONENT_ARM_DISARM}


@pytest.mark.parametrize("family", registered())
def test_a_pilot_who_takes_over_is_not_compared(family: Autopilot) -> None:
    vehicle, commands = begun(family)
    compared = vehicle.conformance
    monitor = ConformanceMonitor(Forecast(elsewhere(family)))
    compared.begin(monitor)
    vehicle.state.custom_mode = family.modes.hold
    vehicle.state.armed, vehicle.state.landed_state = True, 2
    far = place(900.0, 900.0)
    for time in range(5):
        assert (
            list(compared.observe(Position(float(time), far.latitude_deg, far.longitude_deg, 420.0, 20.0), 0.0)) == []
        )
    assert compared.deviations == []
    assert commands == []


@pytest.mark.parametrize("ours", [False, True])
@pytest.mark.parametrize("family", registered())
def test_pause_by_another_station_is_named_and_followed(
    family: Autopilot, ours: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """Its pause, or its end of ours; ArduCopter 4.8 stays in AUTO and reports a paused mission."""
    vehicle, commands = begun(family)
    compared = vehicle.conformance
    heard = far_end(connection_of(vehicle)).autopilot.receive
    paused_s = list[float]()
    places = list[Position]()

    def order(resumes: bool) -> None:
        modes = family.modes
        number, *params = (176, 1.0, *modes.numbers(modes.mission if resumes else modes.hold))
        if family.protocol_profile.pauses_in_mission:
            number, *params = (Command.DO_PAUSE_CONTINUE, float(resumes))
        heard(command_long(number, *params), Target(254, 190), vehicle.connection.now())

    def overhear(message: Message) -> None:
        if not isinstance(message, Position):
            return
        if len(paused_s) == 0 and message.longitude_deg > place(60.0, 0.0).longitude_deg:
            paused_s.append(message.time_s)
            if ours:
                vehicle.order.hold()
            else:
                order(resumes=False)
        if len(paused_s) == 1 and message.time_s > paused_s[0] + 40.0:
            paused_s.append(message.time_s)
            places.append(message)
            assert vehicle.order.is_held
            order(resumes=True)
        if len(paused_s) == 2 and message.time_s < paused_s[1] + 10.0:
            places.append(message)

    vehicle.overhearing = overhear
    record = vehicle.watch()
    assert record.completed, record.why_not
    assert compared.deviations == []
    assert not vehicle.order.is_held
    orders = [each for each in commands if each.command in (Command.DO_PAUSE_CONTINUE, 176)]
    assert len(orders) == 2
    assert places[-1].longitude_deg > places[0].longitude_deg + 1e-4
    warned = [each.getMessage() for each in caplog.records if each.levelno == logging.WARNING]
    paused = "a pilot or a station paused the mission: the vehicle is armed and in the air 5 m above home, in AUTO"
    left = "the vehicle has left its mission: the vehicle is armed and in the air 5 m above home, in AUTO.LOITER"
    assert warned[0].startswith(paused if family.protocol_profile.pauses_in_mission else left)
    assert warned[1:] == ["the vehicle continues its mission"]


@pytest.mark.parametrize("moved", [2.9, 9.6])
@pytest.mark.parametrize("family", registered())
def test_home_that_moves_in_flight_is_a_deviation(
    family: Autopilot, moved: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on PX4 1.17: it corrects its home by up to 3 m; DO_SET_HOME of another station shifted a whole climb."""
    vehicle, _ = begun(family)
    whole = Connection.receive

    def shifted(each: Heard) -> Heard:
        at = each.message
        if not isinstance(at, Position) or at.longitude_deg < place(60.0, 0.0).longitude_deg:
            return each
        return replace(each, message=replace(at, altitude=at.altitude + moved))

    monkeypatch.setattr(Connection, "receive", lambda link, until: [shifted(each) for each in whole(link, until)])
    record = vehicle.watch()
    assert [each.kind for each in record.deviations] == [DeviationKind.HOME] * (moved > 4.0)
    if moved > 4.0:
        words = "item 2: the vehicle's home moved by +9.6 m in height, and its heights count from there"
        assert record.failure == f"it holds, because {words}"
        assert record.deviations[0].as_json()["found"] == pytest.approx(9.6, abs=0.01)


@pytest.mark.parametrize("family", registered())
def test_a_height_is_above_the_vehicles_home_unless_an_item_is_amsl(family: Autopilot) -> None:
    flown = mission(family, place(150.0, 0.0), place(150.0, 60.0))
    amsl = replace(flown, items=(flown.items[0], replace(flown.items[1], frame=0, altitude=420.0), *flown.items[2:]))
    at = Geodetic(HOME.latitude_deg, HOME.longitude_deg, 431.0)
    assert ConformanceMonitor(Forecast(flown)).local(at, 20.0)[2] == pytest.approx(20.0)
    assert ConformanceMonitor(Forecast(amsl)).local(at, 20.0)[2] == pytest.approx(31.0)
