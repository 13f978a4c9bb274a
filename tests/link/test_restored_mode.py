"""An error before the arming leaves the vehicle in the mode that it had: a PX4 in AUTO.MISSION takes off when armed."""

from functools import partial
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, VehicleKind, registered
from ipoa_mission.checks.unsafe import NotAtStart
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.preflight import LowBattery
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.departure import restore_mode
from ipoa_mission.link.dialogue import Cancelled, Dialogue, TimeUp
from ipoa_mission.link.messages import CommandAck, CommandLong, CommandResult, Message
from ipoa_mission.link.orders import CommandRefused
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotFlown
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff
from ipoa_mission.progress import silent
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from tests.link.scripted import ARDUPILOT, ARM, PX4, SET_MODE, Scripted
from tests.link.suited import met, suited
from tests.link_pair import connection_of, far_end

HOME = Geodetic(47.4, 8.5, 400.0)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), return_to_launch()))
#: POSCTL and LOITER.
BEFORE = {PX4: 3 << 16, ARDUPILOT: 5}
LEFT = {PX4: "it is in AUTO.MISSION: it takes off when armed", ARDUPILOT: "it is in GUIDED"}


def loaded(family: Autopilot, before: int | None = None) -> tuple[Vehicle, BuiltInAutopilot]:
    vehicle = met(family)
    vehicle.upload(suited(vehicle, MISSION))
    mock = far_end(connection_of(vehicle)).autopilot
    mock.vehicle.set_mode(BEFORE[family] if before is None else before)
    vehicle.home()
    return vehicle, mock


def refuse(mock: BuiltInAutopilot, number: int, *modes: int) -> None:
    """Let it refuse a command; if `modes` are given, changes to these only."""
    receive = mock.receive

    def refused(message: Message, source: Any, now: float) -> None:
        if isinstance(message, CommandLong) and message.command == number:
            wanted = mock.profile.autopilot.modes.mode_of(*message.params[1:3])
            if not modes or wanted in modes:
                mock.vehicle.send(CommandAck(number, CommandResult.DENIED), source)
                return
        receive(message, source, now)

    mock.receive = refused  # type: ignore[method-assign]


def begin(vehicle: Vehicle) -> None:
    vehicle.prepare()
    vehicle.start()


def forbid(error: BaseException, _: Geodetic) -> None:
    raise error


@pytest.mark.parametrize("error", [LowBattery("low"), NotAtStart("far"), Cancelled("cancelled"), KeyboardInterrupt()])
@pytest.mark.parametrize("family", registered())
def test_forbidden_start_restores_the_mode(family: Autopilot, error: BaseException) -> None:
    vehicle, mock = loaded(family)
    with pytest.raises(type(error)) as ended:
        vehicle.prepare(permit=partial(forbid, error))
    assert mock.vehicle.mode == BEFORE[family]
    assert str(ended.value) == str(error)
    assert not mock.flight.armed
    begin(vehicle)
    assert vehicle.state.replaced_mode is None


@pytest.mark.parametrize("family", registered())
def test_a_mode_that_is_refused_is_replaced_by_hold(family: Autopilot) -> None:
    vehicle, mock = loaded(family)
    refuse(mock, SET_MODE, BEFORE[family])
    with pytest.raises(LowBattery, match=r"^low$"):
        vehicle.prepare(permit=partial(forbid, LowBattery("low")))
    assert mock.vehicle.mode == family.modes.hold


@pytest.mark.parametrize("family", registered())
def test_the_mission_s_mode_is_replaced_by_hold(family: Autopilot) -> None:
    """It is one of the new mission."""
    vehicle, mock = loaded(family, family.modes.mission)
    with pytest.raises(LowBattery, match=r"^low$"):
        vehicle.prepare(permit=partial(forbid, LowBattery("low")))
    assert mock.vehicle.mode == family.modes.hold


@pytest.mark.parametrize("error", [LowBattery("low"), Cancelled("low"), KeyboardInterrupt("low")])
@pytest.mark.parametrize("family", registered())
def test_a_mode_that_is_not_restored_is_in_the_message(family: Autopilot, error: BaseException) -> None:
    vehicle, mock = loaded(family)
    refuse(mock, SET_MODE, BEFORE[family], family.modes.hold)
    with pytest.raises(Cancelled if isinstance(error, KeyboardInterrupt) else type(error)) as ended:
        vehicle.prepare(permit=partial(forbid, error))
    assert mock.vehicle.mode == family.modes.arming
    assert str(ended.value).endswith(f"; {LEFT[family]}")
    assert isinstance(ended.value, MissionError)
    assert ended.value.known["mode_left"] == LEFT[family]


@pytest.mark.parametrize("family", registered())
def test_a_broken_link_names_the_mode(family: Autopilot, monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle, _ = loaded(family)

    def broken(_: Geodetic) -> None:
        def hold(*_: object) -> None:
            raise LinkDown("the link broke")

        monkeypatch.setattr(vehicle, "_run", hold)
        vehicle.home()

    with pytest.raises(LinkDown, match=f"^the link broke; {LEFT[family]}$"):
        vehicle.prepare(permit=broken)


@pytest.mark.parametrize("family", registered())
def test_refused_arming_restores_the_mode(family: Autopilot) -> None:
    vehicle, mock = loaded(family)
    vehicle.prepare()
    refuse(mock, ARM)
    with pytest.raises(CommandRefused) as refused:
        vehicle.start()
    assert mock.vehicle.mode == BEFORE[family]
    assert refused.value.hint == f"when last heard, the vehicle is disarmed, in {family.modes.name(BEFORE[family])}"


@pytest.mark.parametrize("family", registered())
def test_the_end_of_the_time_restores_the_mode(family: Autopilot, monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle, mock = loaded(family)
    monkeypatch.setattr(mock.vehicle, "arming_refusal", lambda: "Compass not calibrated")
    vehicle.give_up_after(6.0)
    with pytest.raises(TimeUp if family is ARDUPILOT else CommandRefused) as late:
        begin(vehicle)
    assert mock.vehicle.mode == BEFORE[family]
    assert str(late.value.hint).endswith(f"disarmed, in {family.modes.name(BEFORE[family])}")


def test_another_vehicle_is_sent_nothing() -> None:
    vehicle, mock = loaded(PX4)
    received = list[Message]()

    def replaced(_: Geodetic) -> None:
        mock.receive = lambda message, *_: received.append(message)  # type: ignore[method-assign]
        raise NotFlown(VehicleKind(12, 1))

    with pytest.raises(NotFlown):
        vehicle.prepare(permit=replaced)
    assert not [message for message in received if isinstance(message, CommandLong)]


def test_a_vehicle_that_somebody_armed_keeps_its_mode() -> None:
    vehicle, mock = loaded(PX4)

    def armed(_: Geodetic) -> None:
        vehicle.state.armed = True
        raise LowBattery("low")

    with pytest.raises(LowBattery, match=r"^low$"):
        vehicle.prepare(permit=armed)
    assert mock.vehicle.mode == PX4.modes.mission
    scripted = Scripted(PX4)

    def armed_at_the_refusal(message: Message) -> list[Message]:
        scripted.armed = True
        return [CommandAck(SET_MODE, CommandResult.DENIED)]

    def restored(departure: Any) -> Dialogue[None]:
        departure.state.armed = False
        return restore_mode(departure.state, BEFORE[PX4])

    scripted.answer = armed_at_the_refusal  # type: ignore[method-assign]
    scripted.hold(restored)
    assert scripted.state.armed
    assert scripted.commands == []


@pytest.mark.parametrize("family", registered())
def test_a_vehicle_starts_at_its_departure_and_waits_in_its_own_mode(family: Autopilot) -> None:
    vehicle, mock = loaded(family)
    now = vehicle.connection.now
    departs_s = now() + 90.0
    words: list[str] = []
    vehicle.count_down(lambda share, left: words.append(left), departs_s, 60.0)
    assert (mock.vehicle.mode, words[0]) == (BEFORE[family], "departure in 90 s")
    assert now() == pytest.approx(departs_s - 60.0, abs=1.0)
    vehicle.prepare()
    vehicle.count_down(silent, departs_s)
    vehicle.start(departs_s=departs_s)
    assert mock.flight.armed
    assert now() == pytest.approx(departs_s, abs=4.0)
