import socket
from types import SimpleNamespace
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import BadInput
from ipoa_mission.link import definitions
from ipoa_mission.link.channel import MavutilChannel
from ipoa_mission.link.connect import connect, meet, open_connection
from ipoa_mission.link.definitions import add_dialect
from ipoa_mission.link.messages import Heartbeat, Message
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
    vehicle: Any = met(Autopilot.PX4)
    vehicle.connection = object()
    with refuses("backend-cannot", kind=BadInput):
        vehicle.messages(1.0)


def test_messages_of_pymavlinks_are_said_and_heard() -> None:
    vehicle = met(Autopilot.PX4)
    vehicle.send(ardupilotmega.MAVLink_param_request_read_message(1, 1, b"MPC_XY_CRUISE", -1))
    heard = vehicle.messages(2.0)
    assert {"HEARTBEAT", "PARAM_VALUE"} <= {message.get_type() for message in heard}
    assert {message.get_type() for message in vehicle.messages(2.0, "HEARTBEAT")} == {"HEARTBEAT"}
    assert vehicle.version_heard is None
    assert vehicle.firmware_version() == vehicle.version_heard != None  # noqa: E711  # asked, and then heard


def test_only_the_requested_of_two_vehicles_on_a_link_is_heard() -> None:
    vehicle = meet(connection_on(Net(one=station(), other=station(Autopilot.ARDUPILOT, 2))), 2)
    heard: list[Message] = []
    vehicle.overhearing = heard.append
    assert {message.get_srcSystem() for message in vehicle.messages(3.0)} == {2}
    assert {message.autopilot for message in heard if isinstance(message, Heartbeat)} == {
        Autopilot.ARDUPILOT.mav_autopilot
    }


def test_a_message_to_another_station_is_returned_and_not_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    sender = ardupilotmega.MAVLink(None, srcSystem=1, srcComponent=1)
    answer = ardupilotmega.MAVLink_param_value_message(b"RTL_ALT", 1500.0, 9, 1, 0).pack(sender)
    clock = iter((0.0, 0.5, 2.0))
    frame = SimpleNamespace(system=1, raw=answer, message=object())
    vehicle = met(Autopilot.PX4)
    monkeypatch.setattr(vehicle.connection, "now", lambda: next(clock))
    monkeypatch.setattr(vehicle.connection, "overhear", lambda until: [frame])
    monkeypatch.setattr(vehicle.connection, "is_for_us", lambda heard: False)
    noted: list[Message] = []
    vehicle.overhearing = noted.append
    (message,) = vehicle.messages(1.0)
    assert (message.get_type(), noted) == ("PARAM_VALUE", [])


def test_a_system_of_mavsdks_is_borrowed(monkeypatch: pytest.MonkeyPatch) -> None:
    system = SimpleNamespace(get_system_id=lambda: 7)
    monkeypatch.setattr("ipoa_mission.link.mavsdk_backend.borrow", lambda system, log: (system, log))
    assert connect(system, log="x.tlog") == (system, "x.tlog")


def test_a_dialect_is_added_once() -> None:
    add_dialect("ardupilotmega")
    in_use = list(definitions._DIALECTS)
    add_dialect(ardupilotmega)
    assert in_use == definitions._DIALECTS
