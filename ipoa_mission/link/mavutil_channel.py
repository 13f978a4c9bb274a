"""Use an open connection of pymavlink's mavutil as a channel."""

from collections.abc import Callable, Collection
from typing import Any

from ipoa_mission.errors import BadInput
from ipoa_mission.link.channel import MAX_READ, LinkDown, Peer, RealTime, readable
from ipoa_mission.link.codec import number_of
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.definitions import DEFINITIONS, Definition, dialect_of
from ipoa_mission.link.messages import Message


class MavutilChannel(RealTime):
    """Nobody else may read the connection meanwhile."""

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
        try:
            ready = readable([self._connection.fd], max(0.0, until - self.now()))
            data = self._connection.recv(MAX_READ) if ready else b""
        except (OSError, ValueError) as error:
            raise LinkDown(f"the link broke: {error}") from error
        return [(bytes(data), "mavutil")] if data else []  # it does not report the sender

    def send(self, data: bytes, peer: Peer | None) -> None:
        try:
            self._connection.write(data)
        except (OSError, ValueError) as error:
            raise LinkDown(f"the link broke: {error}") from error

    def close(self) -> None:
        """Do nothing: its owner closes it."""


def payload_of(message: Any) -> tuple[Definition, bytes]:
    number = getattr(message, "get_msgId", lambda: None)()
    definition = None if number is None else DEFINITIONS.get(int(number))
    if definition is None or definition.name != message.get_type():
        words = f"expected one of pymavlink's, not {type(message).__name__}"
        raise BadInput(words, hint="add_dialect(NAME) makes another dialect known", place="message")
    fields = {name: getattr(message, name) for name in definition.names if hasattr(message, name)}
    return definition, definition.pack({k: v.encode() if isinstance(v, str) else v for k, v in fields.items()})


def as_pymavlink(frame: bytes) -> Any:
    return dialect_of(number_of(frame)).MAVLink(None).decode(bytearray(frame))


def expect_connection(connection: object) -> Connection:
    if not isinstance(connection, Connection):
        raise BadInput("messages of pymavlink's: expected a link of our own, not MAVSDK's", code="backend-cannot")
    return connection


def messages_from(
    connection: Connection, system: int, seconds: float, names: Collection[str], note: Callable[[Message], object]
) -> list[Any]:
    """Return those in `names` (empty: all); `note` all."""
    messages = []
    until = connection.now() + seconds
    while connection.now() < until:
        for heard in [frame for frame in connection.overhear(until) if frame.system == system]:
            messages += [as_pymavlink(heard.raw)] if heard.raw else []
            if heard.message is not None and connection.is_for_us(heard):
                note(heard.message)
    return [message for message in messages if not names or message.get_type() in names]
