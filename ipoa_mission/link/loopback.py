"""A channel without a network: the far end runs inside, on a virtual clock, so that seventy seconds of a lossy link
take a millisecond. Time passes only while one waits in `receive`.
"""

import math
from typing import Protocol

from ipoa_mission.link.channel import Peer

#: Virtual time begins here (2026-01-01 00:00 UTC), so that logs of virtual flights are the same each time.
EPOCH_S = 1_767_225_600.0


class FarEnd(Protocol):
    """Whoever lives at the other end, without I/O: bytes in, bytes out, and a moment when it wants to act."""

    def receive(self, data: bytes, peer: Peer, now: float) -> None:
        """Bytes have arrived."""

    def tick(self, now: float) -> None:
        """Time has passed."""

    def outgoing(self) -> list[tuple[bytes, Peer | None]]:
        """What is to be sent, and to whom (None: to everyone)."""

    @property
    def deadline(self) -> float:
        """When `tick` is next needed."""


class Pipe(Protocol):
    """One direction of a link."""

    def push(self, data: bytes, now: float) -> None:
        """Bytes enter."""

    def pop(self, now: float) -> list[bytes]:
        """The bytes that have come through by now."""

    @property
    def deadline(self) -> float:
        """When the next bytes come through."""


class PerfectPipe:
    """No delay, no loss."""

    def __init__(self) -> None:
        self._held: list[bytes] = []

    def push(self, data: bytes, now: float) -> None:
        """Bytes enter."""
        self._held.append(data)

    def pop(self, now: float) -> list[bytes]:
        """All that has entered."""
        held, self._held = self._held, []
        return held

    @property
    def deadline(self) -> float:
        """At once, if there is something."""
        return -math.inf if self._held else math.inf


class Loopback:
    """A `Channel` to a far end in the same process."""

    datagrams = True
    PEER = "loopback"

    def __init__(self, far: FarEnd, there: Pipe | None = None, back: Pipe | None = None) -> None:
        self.far = far
        self._there = there or PerfectPipe()
        self._back = back or PerfectPipe()
        self._now = 0.0

    def now(self) -> float:
        """Virtual seconds since the beginning."""
        return self._now

    def unix_s(self) -> float:
        """Virtual seconds since 1970."""
        return EPOCH_S + self._now

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        """Let the far end live until something comes, or until that moment."""
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
                raise RuntimeError("both ends wait for ever")
            self._now = max(self._now, wake)

    def send(self, data: bytes, peer: Peer | None) -> None:
        """Bytes leave for the far end."""
        self._there.push(data, self._now)

    def close(self) -> None:
        """Nothing was lent."""
