import socket
from types import SimpleNamespace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.channel import MavutilChannel
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import connect, meet, open_connection
from ipoa_mission.link.dialogue import wait
from ipoa_mission.link.messages import CommandAck, Heartbeat, Message
from ipoa_mission.simulator.station import Loopback
from tests.link.suited import met
from tests.link.test_strangers import Net, connection_on, station
from tests.refused import refuses


def test_an_open_connection_is_read_written_and_left_open() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        lent = SimpleNamespace(fd=ours.fileno(), recv=ours.recv, write=ours.send)
        channel = MavutilChannel(lent)
        assert channel.receive(channel.now()) == []
        channel.send(b"there", None)
        assert theirs.recv(9) == b"there"
        theirs.send(b"back")
        assert [data for data, _ in channel.receive(channel.now() + 5.0)] == [b"back"]
        channel.close()
        assert ours.fileno() >= 0
    with refuses("link-down"):
        channel.receive(channel.now())
    with refuses("link-down"):
        channel.send(b"there", None)


def test_a_line_is_laid_on_what_is_open_and_not_opened_anew() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        connection = open_connection(SimpleNamespace(fd=ours.fileno(), recv=ours.recv, write=ours.send))
        assert isinstance(connection.channel, MavutilChannel)
        assert not connection.reopens


def test_wrong_connections_are_bad_input() -> None:
    with refuses("bad-input", "connect"):
        MavutilChannel(object())


def test_the_version_is_asked_for_once_and_then_known() -> None:
    vehicle = met(Autopilot.PX4)
    assert vehicle.version_heard is None
    assert vehicle.firmware_version() == vehicle.version_heard != None  # noqa: E711  # asked, and then heard


def test_only_the_requested_of_two_vehicles_on_a_link_is_heard() -> None:
    vehicle = meet(connection_on(Net(one=station(), other=station(Autopilot.ARDUPILOT, 2))), 2)
    heard: list[Message] = []
    vehicle.overhearing = heard.append
    vehicle._run(wait(3.0))
    assert {message.autopilot for message in heard if isinstance(message, Heartbeat)} == {
        Autopilot.ARDUPILOT.mav_autopilot
    }


def test_a_message_to_another_station_is_not_noted() -> None:
    vehicle = met(Autopilot.PX4)
    channel = getattr(vehicle.connection, "channel", None)
    assert isinstance(channel, Loopback)
    autopilot = Codec(1, 1)
    for command, station_system in ((16, 200), (17, 245)):
        answer = autopilot.encode(CommandAck(command, 0), Target(station_system, 190), 0.0)
        channel._back.push(answer, channel.now())
    noted: list[Message] = []
    vehicle.overhearing = noted.append
    vehicle._run(wait(0.5))
    assert [message.command for message in noted if isinstance(message, CommandAck)] == [17]


def test_a_system_of_mavsdks_is_borrowed(monkeypatch: pytest.MonkeyPatch) -> None:
    system = SimpleNamespace(get_system_id=lambda: 7)
    monkeypatch.setattr("ipoa_mission.link.mavsdk_backend.borrow", lambda system, log: (system, log))
    assert connect(system, log="x.tlog") == (system, "x.tlog")
