"""Open connection strings; send and receive bytes: the owner of sockets, serial ports and the real clock.

Writing never blocks: a full buffer loses bytes. The default host is the loopback, for safety.
"""

import os
import re
import select
import socket
import time
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from ipoa_mission.errors import BadInput, MissionError, imported

Peer: TypeAlias = Hashable
MAX_READ = 65536
LOOPBACK = "127.0.0.1"
DEFAULT_BAUD = 57600
SELECTABLE_FILES = 1024  # FD_SETSIZE: `select` refuses greater numbers


class Transport(StrEnum):
    UDP_IN = "udpin"
    UDP_OUT = "udpout"
    TCP_OUT = "tcp"
    TCP_IN = "tcpin"
    SERIAL = "serial"


@dataclass(frozen=True)
class Address:
    transport: Transport
    host: str = LOOPBACK
    port: int = 0
    device: str = ""
    baud: int = DEFAULT_BAUD

    def __str__(self) -> str:
        if self.transport is Transport.SERIAL:
            return f"serial:{self.device}:{self.baud}"
        return f"{self.transport}:{self.host}:{self.port}"


def parse_address(url: str) -> Address:
    if match := re.fullmatch(r"serial:(//)?(?P<device>[^:]+)(:(?P<baud>\d{1,9}))?", url, re.ASCII):
        return Address(Transport.SERIAL, device=match["device"], baud=int(match["baud"] or DEFAULT_BAUD))
    host = r"(?P<host>\[[0-9a-fA-F:.]+\]|[^:/\[\]]*)"
    address = rf"(?P<kind>udp|udpin|udpout|tcp|tcpout|tcpin):(//)?{host}:(?P<port>\d{{1,9}})/?"
    match = re.fullmatch(address, url, re.ASCII)
    if match is None:
        raise BadInput(
            f"expected udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD, "
            f"not {url!r}",
            hint="for instance udpin:127.0.0.1:14550",
            place="link",
        )
    port = int(match["port"])
    if port > 65535:
        raise BadInput(f"expected a port up to 65535, not {port}", place="link")
    kind = {"udp": "udpin", "tcpout": "tcp"}.get(match["kind"], match["kind"])  # udp: as in MAVSDK and mavutil
    return Address(Transport(kind), match["host"].strip("[]") or LOOPBACK, port)


class LinkDown(MissionError, code="link-down"):
    """The link cannot be opened, or broke."""


class Channel(Protocol):
    def now(self) -> float: ...

    def unix_s(self) -> float: ...

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        """Return received bytes at once, or none at `until`."""

    def send(self, data: bytes, peer: Peer | None) -> None:
        """Send to one peer; None: to the channel's remote address, if any."""

    def close(self) -> None: ...


def open_channel(url: str) -> Channel:
    address = parse_address(url)
    try:
        match address.transport:
            case Transport.UDP_IN | Transport.UDP_OUT:
                return UdpChannel(address)
            case Transport.TCP_OUT | Transport.TCP_IN:
                return TcpChannel(address)
            case _:
                return SerialChannel(address)
    except (OSError, ValueError) as error:
        hint = "is another ground station using it?" if "in use" in str(error) else None
        if isinstance(error, ConnectionRefusedError):
            hint = "nothing listens there: is the autopilot (or the simulation) running?"
        words = f"cannot be opened: {_reason(error)}"
        raise LinkDown(words, hint=hint, code="link-not-opened", place=address) from error


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


class RealTime:
    def __init__(self) -> None:
        self._epoch = time.time() - time.monotonic()

    def now(self) -> float:
        return time.monotonic()

    def unix_s(self) -> float:
        return self._epoch + time.monotonic()


def readable(files: Sequence[Any], seconds: float) -> list[Any]:
    """Return sockets or file numbers with data, none after `seconds`."""
    by_number = {file if isinstance(file, int) else file.fileno(): file for file in files}
    if os.name != "posix" or max(by_number) < SELECTABLE_FILES:
        return select.select(files, [], [], seconds)[0]
    poll = select.poll()
    for number in by_number:
        poll.register(number, select.POLLIN)
    return [by_number[number] for number, _ in poll.poll(1000.0 * seconds)]


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


class UdpChannel(RealTime):
    """`udpin` waits at its port; `udpout` sends first."""

    def __init__(self, address: Address) -> None:
        super().__init__()
        self._socket = socket.socket(_family(address.host), socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)  # PX4 sends thousands of frames a second
        self._remote: Any = None
        try:
            if address.transport is Transport.UDP_OUT:
                self._remote = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)[0][4]
                host = self._remote[0]
                self._socket.bind((host if host.startswith("127.") or host == "::1" else "", 0))
            else:
                self._socket.bind((address.host, address.port))
        except (OSError, ValueError):
            self._socket.close()
            raise

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        """Return one datagram: its answer may be urgent."""
        try:
            ready = readable([self._socket], max(0.0, until - self.now()))
            return [self._socket.recvfrom(MAX_READ)] if ready else []
        except (BlockingIOError, ConnectionError):  # a datagram met a closed port
            return []
        except OSError as error:
            raise LinkDown(f"the link broke: {_reason(error)}") from error

    def send(self, data: bytes, peer: Peer | None) -> None:
        """Ignore a peer that cannot be reached."""
        to: Any = peer or self._remote
        if to is None:
            return
        try:
            self._socket.sendto(data, to)
        except (BlockingIOError, ConnectionError):
            return
        except OSError as error:
            if peer is None:
                raise LinkDown(f"the link broke: {_reason(error)}") from error

    def close(self) -> None:
        self._socket.close()


class TcpChannel(RealTime):
    MAX_CONNECTIONS = 16

    def __init__(self, address: Address) -> None:
        super().__init__()
        self._listener: socket.socket | None = None
        self._connections: list[socket.socket] = []
        if address.transport is Transport.TCP_IN:
            place = (address.host, address.port)
            self._listener = socket.create_server(place, family=_family(address.host), backlog=self.MAX_CONNECTIONS)
            self._listener.setblocking(False)
        else:
            connection = socket.create_connection((address.host, address.port), timeout=5.0)
            self._adopt(connection)
            with suppress(AttributeError):  # close after 10 s without progress
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 10_000)

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        watched = [*self._connections, *([self._listener] if self._listener else [])]
        if not watched:
            raise _closed()
        got: list[tuple[bytes, Peer]] = []
        for connection in readable(watched, max(0.0, until - self.now())):
            if connection is self._listener:
                self._accept()
                continue
            try:
                data = connection.recv(MAX_READ)
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            if data:
                got.append((data, connection))
            else:
                self._drop(connection)
        return got

    def send(self, data: bytes, peer: Peer | None) -> None:
        for connection in [*self._connections] if peer is None else [peer]:
            if not isinstance(connection, socket.socket) or connection not in self._connections:
                continue
            try:
                sent = connection.send(data)
            except BlockingIOError:
                continue
            except OSError:
                self._drop(connection)
                continue
            if 0 < sent < len(data):
                self._finish(connection, data[sent:])

    def close(self) -> None:
        for connection in [*self._connections]:
            connection.close()
        self._connections = []
        if self._listener:
            self._listener.close()

    def _adopt(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._connections.append(connection)

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()  # type: ignore[union-attr]
        except OSError:
            return
        if len(self._connections) >= self.MAX_CONNECTIONS:
            connection.close()
        else:
            self._adopt(connection)

    def _finish(self, connection: socket.socket, unsent: bytes) -> None:
        """Send the remaining bytes within 0.5 s, else drop the connection."""
        connection.settimeout(0.5)
        try:
            connection.sendall(unsent)
            connection.setblocking(False)
        except OSError:
            self._drop(connection)

    def _drop(self, connection: socket.socket) -> None:
        self._connections.remove(connection)
        connection.close()
        if self._listener is None:
            raise _closed()


def _closed() -> LinkDown:
    return LinkDown("the other side closed the connection", "check whether the autopilot, or what relays it, restarted")


class SerialChannel(RealTime):
    MAX_UNSENT = 2048  # bytes: 0.3 s at 57600 baud

    def __init__(self, address: Address) -> None:
        super().__init__()
        serial = imported("serial", "serial links need pyserial", "serial", LinkDown)
        if not Path(address.device).exists() and not address.device.upper().startswith("COM"):
            raise LinkDown("there is no such device", code="link-not-opened", place=address)
        self._port = serial.Serial(address.device, address.baud, timeout=0, write_timeout=0)
        self._unsent = b""

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        data = self._move()
        while not data and (left := until - self.now()) > 0:
            self._wait(left)
            data = self._move()
        return [(data, "serial")] if data else []

    def send(self, data: bytes, peer: Peer | None) -> None:
        """Queue a whole frame, or drop it while the line does not drain."""
        if len(self._unsent) + len(data) <= self.MAX_UNSENT:
            self._unsent += data
        with _broken_by_errors():
            self._write()

    def close(self) -> None:
        self._port.close()

    def _move(self) -> bytes:
        with _broken_by_errors():
            self._write()
            data: bytes = self._port.read(MAX_READ)
        return data

    def _wait(self, seconds: float) -> None:
        """Wait for bytes, or for room for unsent ones. Windows cannot wait for a port."""
        if os.name != "posix":
            time.sleep(min(seconds, 0.002))
            return
        with _broken_by_errors():
            select.select([self._port], [self._port] if self._unsent else [], [], seconds)

    def _write(self) -> None:
        """Write only what the line takes at once: else pyserial blocks for ever."""
        if self._unsent and (os.name != "posix" or select.select([], [self._port], [], 0)[1]):
            self._unsent = self._unsent[self._port.write(self._unsent) :]


class MavutilChannel(RealTime):
    """An open connection of pymavlink's mavutil. Nobody else may read it meanwhile."""

    def __init__(self, connection: Any) -> None:
        super().__init__()
        if not hasattr(connection, "recv") or getattr(connection, "fd", None) is None:
            raise BadInput(
                f"expected a connection string, an open connection of mavutil, or MAVSDK's System, "
                f"not {type(connection).__name__}",
                place="connect",
            )
        self._connection = connection

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        with _broken_by_errors():
            ready = readable([self._connection.fd], max(0.0, until - self.now()))
            data = self._connection.recv(MAX_READ) if ready else b""
        return [(bytes(data), "mavutil")] if data else []  # it does not report the sender

    def send(self, data: bytes, peer: Peer | None) -> None:
        with _broken_by_errors():
            self._connection.write(data)

    def close(self) -> None:
        """Do nothing: its owner closes it."""


@contextmanager
def _broken_by_errors() -> Iterator[None]:
    try:
        yield
    except (OSError, TypeError, ValueError) as error:
        raise LinkDown(f"the link broke: {_reason(error)}", hint="check the plug, or the other end") from error


def serial_ports() -> tuple[str, ...]:
    try:
        from serial.tools.list_ports import comports
    except ImportError:
        return ()
    return tuple(sorted(str(port.device) for port in comports()))
