"""Pause, continue and return, as flown on ArduCopter 4.7.0-dev and PX4 1.17.0 in simulation.

Within a take-off ArduCopter refuses command 193, and is put into BRAKE; on its way to a waypoint it stops within two
seconds and stays in AUTO. PX4 changes to AUTO.LOITER.
"""

from collections.abc import Callable

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange
from ipoa_mission.link.flight_order import SHOWN_S, enter, go_on, hold, in_flight
from ipoa_mission.link.messages import CommandAck, CommandResult, Message, Position, Text
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotReady, VehicleState
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.simulator.fly import board
from tests.refused import refuses
from tools import REPOSITORY

MISSIONS = REPOSITORY / "missions"
PAUSED = {Autopilot.ARDUPILOT: "AUTO", Autopilot.PX4: "AUTO.LOITER"}
AGAIN = {Autopilot.ARDUPILOT: "AUTO", Autopilot.PX4: "AUTO.MISSION"}
HOME = {Autopilot.ARDUPILOT: "RTL", Autopilot.PX4: "AUTO.RTL"}


def flying(name: str) -> tuple[Mission, Vehicle]:
    mission = read_mission(MISSIONS / name)
    vehicle = board(mission)
    vehicle.upload(mission)
    vehicle.prepare()
    vehicle.start()
    return mission, vehicle


def later(vehicle: Vehicle, seconds: float) -> Position:
    until = vehicle.connection.now() + seconds
    while vehicle.connection.now() < until:
        for message in vehicle.connection.receive(until):
            if message.message is not None:
                vehicle.state.note(message.message)
    assert vehicle.state.position is not None
    return vehicle.state.position


def moved(vehicle: Vehicle, seconds: float) -> float:
    """Return its movement [degrees, and m of height]."""
    before, after = later(vehicle, 0.5), later(vehicle, seconds)
    return max(
        abs(after.latitude_deg - before.latitude_deg) * 111e3,
        abs(after.longitude_deg - before.longitude_deg) * 75e3,
        abs(after.height - before.height),
    )


@pytest.mark.parametrize("name", ["campus.plan", "sitl.plan"])
def test_vehicle_pauses_resumes_and_returns(name: str) -> None:
    mission, vehicle = flying(name)
    with vehicle:
        later(vehicle, 25.0)
        assert moved(vehicle, 2.0) > 5.0
        vehicle.pause()
        assert vehicle.mode == PAUSED[mission.autopilot]
        later(vehicle, 5.0)
        assert moved(vehicle, 10.0) < 2.0  # PX4 returns to where it was told to stay
        vehicle.resume()
        assert vehicle.mode == AGAIN[mission.autopilot]
        assert moved(vehicle, 5.0) > 5.0
        vehicle.return_to_launch()
        assert vehicle.mode == HOME[mission.autopilot]
        landed_by = vehicle.connection.now() + 200.0
        while vehicle.state.armed and vehicle.connection.now() < landed_by:
            later(vehicle, 1.0)
        assert vehicle.state.armed is False


def test_arducopter_brakes_where_it_cannot_pause() -> None:
    _, vehicle = flying("campus.plan")
    with vehicle:
        assert moved(vehicle, 5.0) > 1.0
        vehicle.pause()
        assert vehicle.mode == "BRAKE"
        later(vehicle, 5.0)
        assert moved(vehicle, 5.0) < 1.0
        vehicle.resume()
        assert vehicle.mode == "AUTO"
        assert moved(vehicle, 5.0) > 1.0


@pytest.mark.parametrize("name", ["campus.plan", "sitl.plan"])
def test_a_vehicle_on_the_ground_is_told_nothing(name: str) -> None:
    with board(read_mission(MISSIONS / name)) as vehicle:
        for order in (vehicle.pause, vehicle.resume, vehicle.return_to_launch):
            with refuses("not-in-the-air", kind=NotReady):
                order()
        assert vehicle.state.armed is False


def test_a_vehicle_whose_mission_is_gone_says_why_it_does_not_go_on() -> None:
    _, vehicle = flying("campus.plan")
    with vehicle:
        later(vehicle, 25.0)
        vehicle.return_to_launch()
        vehicle.clear()
        with refuses("not-ready", "", "Mode change to AUTO failed: init failed") as refused:
            vehicle.resume()
        assert "the vehicle is armed and in the air" in str(refused.value.hint)
        assert vehicle.mode == "RTL"


def test_px4_says_why_it_takes_back_its_yes() -> None:
    """Its first answer is only that the order was heard."""
    _, vehicle = flying("sitl.plan")
    with vehicle:
        later(vehicle, 25.0)
        vehicle.return_to_launch()
        vehicle.clear()
        begun = vehicle.connection.now()
        with refuses("not-ready", "", "Switching to Mission is currently not available") as refused:
            vehicle.resume()
        assert vehicle.connection.now() - begun < SHOWN_S
        assert "in AUTO.RTL" in str(refused.value.hint)


def paused(state: VehicleState) -> Dialogue[None]:
    return in_flight(state, hold(state))


def resumed(state: VehicleState) -> Dialogue[None]:
    return in_flight(state, go_on(state, is_paused=False))


def returned(state: VehicleState) -> Dialogue[None]:
    return in_flight(state, enter(state, state.autopilot.modes.returning))


def answered(*answers: Message) -> Exchange[None]:
    """A vehicle in AUTO.MISSION, ordered home, that answers this and shows nothing."""
    state = VehicleState(Autopilot.PX4, armed=True, custom_mode=Autopilot.PX4.modes.mission)
    exchange = Exchange(returned(state), 0.0, SPECIFIED)
    for n, answer in enumerate(answers, start=1):
        exchange.receive(answer, 0.2 * n)
    return exchange


def test_a_later_refusal_without_words_is_named_by_its_result() -> None:
    yes, no = (CommandAck(VehicleCommand.DO_SET_MODE, each) for each in (CommandResult.ACCEPTED, CommandResult.DENIED))
    of_arming = CommandAck(Command.COMPONENT_ARM_DISARM, CommandResult.DENIED)
    exchange = answered(yes, of_arming, no)
    with refuses("not-ready", "", "AUTO.RTL", "DENIED"):
        exchange.tick(SHOWN_S)


def test_a_mode_that_is_accepted_and_not_shown_is_no_return() -> None:
    state = VehicleState(Autopilot.PX4, armed=True, custom_mode=Autopilot.PX4.modes.mission)
    exchange = Exchange(returned(state), 0.0, SPECIFIED)
    exchange.receive(CommandAck(VehicleCommand.DO_SET_MODE, CommandResult.ACCEPTED), 0.1)
    exchange.tick(SHOWN_S)
    with refuses("not-ready", "", "AUTO.RTL") as unseen:
        exchange.tick(0.1 + SHOWN_S)
    assert "AUTO.MISSION" in str(unseen.value.hint)


@pytest.mark.parametrize("order", [paused, resumed, returned])
@pytest.mark.parametrize("family", registered())
def test_a_verb_does_not_repeat_its_order_after_the_pilot_took_over(
    family: Autopilot, order: Callable[[VehicleState], Dialogue[None]]
) -> None:
    modes = family.modes
    state = VehicleState(family, armed=True, custom_mode=modes.mission)
    if order is resumed and not family.protocol_profile.pauses_in_mission:
        state.custom_mode = modes.hold
    exchange = Exchange(order(state), 0.0, SPECIFIED)
    assert exchange.outgoing()
    exchange.tick(exchange.deadline)
    assert exchange.outgoing()  # the first is lost
    state.custom_mode = modes.landing
    with refuses("not-ready", "", "took over", modes.name(state.custom_mode)):
        exchange.receive(Text(6, ""), exchange.deadline - 0.1)
