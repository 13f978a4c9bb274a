"""`Line`: one end of a link, with a voice (codec), ears that know who speaks (routes), and a memory (tlog).

`converse` is the only loop that joins a dialogue to the world.
"""

import math
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Protocol, TypeVar

from ipoa_mission.link.channel import Channel
from ipoa_mission.link.codec import EVERYONE, Codec, Heard, Target, frames
from ipoa_mission.link.dialogue import Cancelled, Dialogue, Exchange, Patience, Tempo, TimeUp
from ipoa_mission.link.interrupt import noted_interrupts
from ipoa_mission.link.messages import Firmware, Heartbeat, Message
from ipoa_mission.link.routes import Routes
from ipoa_mission.link.tlog import TlogWriter

T = TypeVar("T")
HEARTBEAT_S = 1.0
NOTICE_S = 0.1  # how soon Ctrl-C is noticed
MAV_TYPE_GCS = 6


class Carrier(Protocol):
    """What carries messages to vehicles and back, whoever speaks MAVLink there, and the clock that goes with it."""

    def now(self) -> float:
        """Seconds on a clock that never goes back."""

    def send(self, message: Message, target: Target = EVERYONE) -> None:
        """Say something to one vehicle, or to all."""

    def receive(self, until: float) -> list[Heard]:
        """What was said to us up to this moment, at the latest; returns at once when something came."""

    def prepare(self, message: Message, target: Target) -> None:
        """What will probably be said next, so that it can be made ready while one waits."""

    def close(self) -> None:
        """Give back what was lent."""


class Line:
    """A ground station's end of a link; `close` it, or use it with `with`."""

    def __init__(self, channel: Channel, codec: Codec, log: str | Path | None = None) -> None:
        self.channel = channel
        self.codec = codec
        self._log = TlogWriter(log) if log else None
        self._routes = Routes()
        self._next_heartbeat = channel.now()

    def now(self) -> float:
        """See `Carrier`."""
        return self.channel.now()

    def prepare(self, message: Message, target: Target) -> None:
        """See `Carrier`."""
        self.codec.prepare(message, target)

    def send(self, message: Message, target: Target = EVERYONE) -> None:
        """Say something to one vehicle, or to all."""
        frame = self.codec.encode(message, target, self.channel.unix_s())
        if self._log:
            self._log.write(frame, self.channel.unix_s())
        peers = self._routes.to(target)
        for peer in peers or {None}:
            self.channel.send(frame, peer)

    def receive(self, until: float) -> list[Heard]:
        """What was said to us (or to everyone) up to this moment, at the latest; keeps our own heartbeat going."""
        now = self.channel.now()
        if now >= self._next_heartbeat:
            self._next_heartbeat = now + HEARTBEAT_S
            self.send(Heartbeat(MAV_TYPE_GCS, Firmware.INVALID))
        heard: list[Heard] = []
        for data, peer in self.channel.receive(min(until, self._next_heartbeat)):
            now = self.channel.now()
            for frame in frames(data) if self.channel.datagrams else self._routes.framer(peer).feed(data):
                one = self.codec.decode(frame)
                if one is None or not self._routes.learn(one.system, one.component, peer, now):
                    continue
                if self._log:
                    self._log.write(frame, self.channel.unix_s())
                if one.message is not None and one.is_for(self.codec.system, self.codec.component):
                    heard.append(one)
        return heard

    def close(self) -> None:
        """Close the channel and the log."""
        self.channel.close()
        if self._log:
            self._log.close()

    def __enter__(self) -> "Line":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def converse(
    line: Carrier,
    target: Target,
    dialogue: Dialogue[T],
    patience: Patience,
    tempo: Tempo | None = None,
    overhear: Callable[[Message], None] | None = None,
    until: float = math.inf,
) -> T:
    """Hold a dialogue with one vehicle and return what it returns; other voices on the line are not heard.

    Ctrl-C asks the dialogue to end well (`Cancelled` is raised in it); a second one ends it at once. At `until`
    `TimeUp` is raised in it.
    """
    now = line.now
    with noted_interrupts() as interrupt:
        exchange = Exchange(dialogue, now(), patience, tempo)
        try:
            while not exchange.finished:
                for message in exchange.outgoing():
                    line.send(message, target)
                if exchange.foreseen:
                    line.prepare(exchange.foreseen, target)
                for heard in line.receive(min(exchange.deadline, until, now() + NOTICE_S)):
                    if (heard.system, heard.component) == target and heard.message is not None:
                        if overhear:
                            overhear(heard.message)
                        exchange.receive(heard.message, now())
                exchange.tick(now())
                if interrupt.take():
                    exchange.interrupt(Cancelled("cancelled"), now())
                if now() >= until:
                    until = math.inf
                    exchange.interrupt(TimeUp("the time is up"), now())
        finally:
            for message in exchange.outgoing():
                line.send(message, target)
        return exchange.result
