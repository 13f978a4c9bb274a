import fcntl
import resource
import socket
import time
from collections.abc import Iterator
from contextlib import closing
from types import SimpleNamespace

import pytest

from ipoa_mission.link.channel import SELECTABLE_FILES, LinkDown, MavutilChannel, TcpChannel, UdpChannel, parse_address
from tests.link_pair import port_of
from tests.refused import refuses


class Failing:
    def __init__(self, error: OSError) -> None:
        self._error = error

    def __getattr__(self, name: str) -> object:
        def call(*_: object) -> None:
            if name not in ("settimeout", "close", "setblocking"):
                raise self._error

        return call


@pytest.fixture
def served() -> Iterator[TcpChannel]:
    with closing(TcpChannel(parse_address("tcpin:127.0.0.1:0"))) as channel:
        yield channel


def joined(channel: TcpChannel) -> socket.socket:
    """Return a client's end of a new connection."""
    client = socket.create_connection(("127.0.0.1", port_of(channel)), timeout=5.0)
    channel.receive(channel.now() + 0.2)
    return client


def test_link_is_down_if_its_udp_socket_breaks_not_for_a_lost_peer() -> None:
    with closing(UdpChannel(parse_address("udpout:127.0.0.1:9"))) as channel:
        channel._socket.close()
        channel._socket = Failing(OSError(100, "Network is down"))  # type: ignore[assignment]
        with refuses("link-down", "", "Network is down"):
            channel.receive(0.0)
        with refuses("link-down", "", "Network is down"):
            channel.send(b"x", None)
        channel.send(b"x", ("240.0.0.1", 1))
        channel._socket = Failing(ConnectionRefusedError())  # type: ignore[assignment]
        channel.send(b"x", None)
        assert channel.receive(0.0) == []


def test_tcp_connection_stays_closed_and_a_full_one_is_not_waited_for() -> None:
    with closing(TcpChannel(parse_address("tcpin:127.0.0.1:0"))) as far:
        channel = TcpChannel(parse_address(f"tcp:127.0.0.1:{port_of(far)}"))
        (connection,) = channel._connections
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 10_000
    for _ in range(2):
        with refuses("link-down", "", "closed"):
            channel.receive(channel.now() + 1.0)


def test_nobody_has_spoken_yet_and_so_nobody_is_answered() -> None:
    with closing(UdpChannel(parse_address("udpin:127.0.0.1:0"))) as channel:
        channel.send(b"x", None)
        assert channel.receive(0.0) == []


def test_one_connection_that_ends_leaves_the_others(served: TcpChannel) -> None:
    with joined(served) as first, joined(served) as second:
        first.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # closed by a reset
        first.close()
        time.sleep(0.05)
        served.send(b"a", "no connection of ours")
        assert served.receive(served.now() + 0.2) == []
        served.send(b"b", None)
        assert second.recv(10) == b"b"


def test_more_connections_than_are_served_are_closed(served: TcpChannel) -> None:
    clients = [joined(served) for _ in range(TcpChannel.MAX_CONNECTIONS + 1)]
    try:
        assert clients[-1].recv(1) == b""
        served.send(b"x", None)
        assert {client.recv(1) for client in clients[:-1]} == {b"x"}
    finally:
        for client in clients:
            client.close()


def test_a_client_that_does_not_read_loses_frames_and_then_its_connection(served: TcpChannel) -> None:
    frame = bytes(50_000)
    with joined(served) as client:
        began = time.monotonic()
        while served._connections and time.monotonic() - began < 20.0:
            served.send(frame, None)
        assert not served._connections
        client.settimeout(5.0)
        got = 0
        while data := client.recv(1 << 20):
            got += len(data)
        assert got > len(frame)


def test_a_connection_that_breaks_while_it_is_written_to_is_dropped(served: TcpChannel) -> None:
    with joined(served) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
    time.sleep(0.05)
    for _ in range(3):
        served.send(b"x", None)
    assert not served._connections


def test_a_connection_that_was_announced_and_is_gone_again_is_no_error(served: TcpChannel) -> None:
    served._accept()
    assert not served._connections


def test_a_serial_link_without_pyserial_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    from ipoa_mission.link.channel import open_channel

    monkeypatch.setitem(__import__("sys").modules, "serial", None)
    with refuses("package-missing", kind=LinkDown) as down:
        open_channel("serial:/dev/null")
    assert down.value.hint == "pip install 'ipoa-mission[serial]'"


class Stubborn(socket.socket):
    """Reads nothing, and sends one byte at once."""

    left = b""

    def recv(self, *_: object) -> bytes:
        raise BlockingIOError

    def send(self, data: bytes, *_: object) -> int:  # type: ignore[override]
        if not data:
            raise BlockingIOError
        return 1

    def sendall(self, data: bytes, *_: object) -> None:  # type: ignore[override]
        self.left = data


def test_a_socket_that_is_not_ready_gets_the_rest_of_a_frame_later(served: TcpChannel) -> None:
    with joined(served) as client:
        (connection,) = served._connections
        stubborn = Stubborn(fileno=connection.detach())
        served._connections[:] = [stubborn]
        client.send(b"x")
        assert served.receive(served.now() + 0.2) == []
        served.send(b"frame", None)
        assert stubborn.left == b"rame"
        served.send(b"", None)
        assert served._connections == [stubborn]


@pytest.fixture
def many_files() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 2 * SELECTABLE_FILES), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def with_a_great_number(small: socket.socket) -> socket.socket:
    """Return the same socket with a file number that `select` refuses."""
    with small:
        return socket.socket(fileno=fcntl.fcntl(small.fileno(), fcntl.F_DUPFD, SELECTABLE_FILES))


@pytest.mark.usefixtures("many_files")
def test_udp_receives_by_a_file_number_over_1023() -> None:
    with closing(UdpChannel(parse_address("udpin:127.0.0.1:0"))) as channel:
        channel._socket = with_a_great_number(channel._socket)
        assert channel.receive(channel.now() + 0.01) == []
        with closing(UdpChannel(parse_address(f"udpout:127.0.0.1:{port_of(channel)}"))) as far:
            far.send(b"x", None)
            assert [data for data, _ in channel.receive(channel.now() + 5.0)] == [b"x"]


@pytest.mark.usefixtures("many_files")
def test_tcp_receives_by_a_file_number_over_1023(served: TcpChannel) -> None:
    with joined(served) as client:
        served._connections[:] = [with_a_great_number(connection) for connection in served._connections]
        assert served.receive(served.now() + 0.01) == []
        client.send(b"x")
        assert [data for data, _ in served.receive(served.now() + 5.0)] == [b"x"]


@pytest.mark.usefixtures("many_files")
def test_mavutil_receives_by_a_file_number_over_1023() -> None:
    small, theirs = socket.socketpair()
    with with_a_great_number(small) as ours, theirs:
        channel = MavutilChannel(SimpleNamespace(fd=ours.fileno(), recv=ours.recv, write=ours.send))
        theirs.send(b"x")
        assert [data for data, _ in channel.receive(channel.now() + 5.0)] == [b"x"]
