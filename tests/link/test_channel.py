import os
import select
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.channel import LinkDown, SerialChannel, UdpChannel, open_channel, parse_address, serial_ports
from ipoa_mission.link.codec import EVERYONE, Codec, Framer, frames
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import SPECIFIED, NoAnswer, TimeUp
from ipoa_mission.link.messages import Heartbeat, Text
from ipoa_mission.link.vehicle import ConnectionOptions
from tests.quick_link import hurry
from tests.refused import refuses

pytest.importorskip("serial")
AUTOPILOT = Codec(1, 1).encode(Heartbeat(2, Autopilot.PX4.mav_autopilot), EVERYONE, 0.0)


class Cable:
    """A serial line: `vehicle` is the vehicle's end, a file."""

    def __init__(self) -> None:
        self.vehicle, self._ours = os.openpty()
        tty.setraw(self._ours)
        self.url = f"serial:{os.ttyname(self._ours)}:57600"

    def pull_out(self) -> None:
        for end in (self.vehicle, self._ours):
            if end >= 0:
                os.close(end)
        self.vehicle = self._ours = -1


@pytest.fixture
def cable() -> Iterator[Cable]:
    line = Cable()
    yield line
    line.pull_out()


@pytest.fixture
def serial(cable: Cable) -> Iterator[SerialChannel]:
    channel = open_channel(cable.url)
    assert isinstance(channel, SerialChannel)
    yield channel
    channel.close()


def test_frames_pass_both_ways_over_a_serial_line(cable: Cable, serial: SerialChannel) -> None:
    serial.send(AUTOPILOT, None)
    assert list(frames(os.read(cable.vehicle, 1000))) == [AUTOPILOT]
    os.write(cable.vehicle, AUTOPILOT)
    assert serial.receive(serial.now() + 5.0) == [(AUTOPILOT, "serial")]


@pytest.mark.skipif(os.name != "posix", reason="Windows cannot wait for a port")
def test_a_silent_serial_line_is_waited_for_without_polling(
    cable: Cable, serial: SerialChannel, monkeypatch: pytest.MonkeyPatch
) -> None:
    reads = iter(range(1000))
    read = serial._port.read
    monkeypatch.setattr(serial._port, "read", lambda most: read(most + 0 * next(reads)))
    assert serial.receive(serial.now() + 0.3) == []
    assert next(reads) == 2
    threading.Timer(0.1, os.write, (cable.vehicle, AUTOPILOT)).start()
    began = serial.now()
    assert serial.receive(began + 5.0) == [(AUTOPILOT, "serial")]
    assert serial.now() - began < 2.0


def test_a_serial_line_is_asked_again_and_again_on_windows(
    cable: Cable, serial: SerialChannel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ipoa_mission.link.channel.os", SimpleNamespace(name="nt"))
    threading.Timer(0.1, os.write, (cable.vehicle, AUTOPILOT)).start()
    assert serial.receive(serial.now() + 5.0) == [(AUTOPILOT, "serial")]


def test_unsent_bytes_leave_while_a_serial_line_is_silent(cable: Cable, serial: SerialChannel) -> None:
    while not serial._unsent:
        serial.send(AUTOPILOT * 20, None)
    os.read(cable.vehicle, 100_000)
    assert serial.receive(serial.now() + 0.3) == []
    assert serial._unsent == b""


def test_a_blocked_serial_line_loses_whole_frames_and_never_waits(cable: Cable, serial: SerialChannel) -> None:
    codec, began = Codec(245, 190), time.monotonic()
    sent = [codec.encode(Text(6, f"{n:050}"), EVERYONE, 0.0) for n in range(3000)]
    for frame in sent:
        serial.send(frame, None)
    assert time.monotonic() - began < 5.0
    assert len(serial._unsent) <= SerialChannel.MAX_UNSENT
    framer = Framer()
    got: list[bytes] = []
    while data := (os.read(cable.vehicle, 100_000) if _is_readable(cable.vehicle) else b""):
        got += framer.feed(data)
        serial.receive(serial.now())
    order = [sent.index(frame) for frame in got]  # a busy kernel may take a few more
    assert order == sorted(set(order))
    assert 20 < len(got) < len(sent)


def _is_readable(file: int) -> bool:
    return bool(select.select([file], [], [], 0.05)[0])


def test_verb_on_a_blocked_serial_line_ends_at_its_timeout(
    cable: Cable, serial: SerialChannel, monkeypatch: pytest.MonkeyPatch
) -> None:
    hurry(monkeypatch.setattr)
    full = Codec(245, 190).encode(Text(6, "x" * 50), EVERYONE, 0.0)
    for _ in range(2000):
        serial.send(full, None)
    os.write(cable.vehicle, AUTOPILOT)
    vehicle = meet(
        Connection(serial, Codec(245, 190)),
        options=ConnectionOptions(retry_policy=replace(SPECIFIED, total_s=0.5), fast=False),
    )
    began = time.monotonic()
    with pytest.raises((TimeUp, NoAnswer)):
        vehicle.clear()
    assert time.monotonic() - began < 2.0


@pytest.mark.parametrize(
    "use", [lambda channel: channel.receive(channel.now() + 1.0), lambda channel: channel.send(AUTOPILOT * 10, None)]
)
def test_a_serial_line_that_is_pulled_out_is_a_link_that_is_down(
    cable: Cable, serial: SerialChannel, use: Callable[[SerialChannel], object]
) -> None:
    cable.pull_out()
    with refuses("link-down"):
        use(serial)


@pytest.mark.parametrize(
    "url",
    [
        f"udpout:{'a' * 70}:14550",
        "udpin:a..b:14550",
        "serial:/dev/null:57600",
        "serial:/dev:57600",
        "serial:/dev/no\0thing:57600",
        "tcp:127.0.0.1:0",
    ],
)
def test_channels_that_cannot_be_opened_are_refused_in_words(url: str) -> None:
    with refuses("link-not-opened", kind=LinkDown):
        open_channel(url)


def test_an_address_that_cannot_be_answered_does_not_break_the_link() -> None:
    channel = UdpChannel(parse_address("udpin:127.0.0.1:0"))
    try:
        channel.send(b"\xfd", ("127.0.0.1", 0))
        channel.send(b"\xfd", ("255.255.255.255", 9))
    finally:
        channel.close()


def test_serial_ports_are_listed_by_name_and_are_none_without_pyserial(monkeypatch: pytest.MonkeyPatch) -> None:
    ports = [SimpleNamespace(device=name) for name in ("/dev/ttyUSB1", "/dev/ttyACM0")]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: ports)
    assert serial_ports() == ("/dev/ttyACM0", "/dev/ttyUSB1")
    monkeypatch.setitem(sys.modules, "serial.tools.list_ports", None)
    assert serial_ports() == ()
