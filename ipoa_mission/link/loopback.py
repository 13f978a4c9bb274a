"""A channel within one process on a virtual clock, which only `receive` moves."""

import math
from typing import Protocol

from ipoa_mission.link.channel import Peer

#: 2026-01-01 00:00 UTC: logs are reproducible.
EPOCH_S = 1_767_225_600.0


class FarEnd(Protocol):
    def receive(self, data: bytes, peer: Peer, now: float) -> None: ...

    def tick(self, now: float) -> None: ...

    def outgoing(self) -> list[tuple[bytes, Peer | None]]: ...

    @property
    def deadline(self) -> float: ...


class Pipe:
    """One direction, without faults."""

    def __init__(self) -> None:
        self._waiting: list[bytes] = []

    def push(self, data: bytes, now: float) -> None:
        self._waiting.append(data)

    def pop(self, now: float) -> list[bytes]:
        waiting, self._waiting = self._waiting, []
        return waiting

    @property
    def deadline(self) -> float:
        return -math.inf if self._waiting else math.inf


class Loopback:
    PEER = "loopback"

    def __init__(self, far: FarEnd, there: Pipe | None = None, back: Pipe | None = None) -> None:
        self.far = far
        self._there, self._back = there or Pipe(), back or Pipe()
        self._now = 0.0

    def now(self) -> float:
        return self._now

    def unix_s(self) -> float:
        return EPOCH_S + self._now

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        while True:
            for data in self._there.pop(self._now):
                self.far.receive(data, self.PEER, self._now)
            if self._now >= self.far.deadline:
                self.far.tick(self._now)
            for data, _ in self.far.outgoing():
                self._back.push(data, self._now)
            got: list[tuple[bytes, Peer]] = [(data, self.PEER) for data in self._back.pop(self._now)]
            if got or self._now >= until:
                return got
            wake = min(until, self.far.deadline, self._there.deadline, self._back.deadline)
            if math.isinf(wake):
                raise RuntimeError("both ends wait, and neither has anything to send")
            self._now = max(self._now, wake)

    def send(self, data: bytes, peer: Peer | None) -> None:
        self._there.push(data, self._now)

    def close(self) -> None:
        """Do nothing."""
