"""Ends of a link: the built-in autopilot's, and a loopback to it."""

import math
from typing import Protocol

from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT
from ipoa_mission.link.routes import Routes
from ipoa_mission.link.signing import Signer
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.faults import PERFECT, Faults, Pipe

#: 2026-01-01 00:00 UTC: logs are reproducible.
EPOCH_S = 1_767_225_600.0


class Station:
    """Answer the sender, and stations with its ids; send streams to all stations heard."""

    def __init__(self, autopilot: BuiltInAutopilot, system: int = 1, signer: Signer | None = None) -> None:
        self.autopilot = autopilot
        self._codec = Codec(system, AUTOPILOT_COMPONENT, signer)
        self._routes = Routes()
        self._now = 0.0

    def receive(self, data: bytes, peer: Peer, now: float) -> None:
        """Ignore bytes that are no frame, not signed with our key, or for others."""
        self._now = now
        for frame in self._routes.frames(data, peer):
            heard = self._codec.decode(frame)
            if heard is None:
                continue
            name = Target(heard.system, heard.component)
            self._routes.learn(name, peer, now)
            if heard.message is not None and heard.is_for(self._codec.system, self._codec.component):
                self.autopilot.receive(heard.message, name, now)

    def tick(self, now: float) -> None:
        self._now = now
        self.autopilot.tick(now)

    def outgoing(self) -> list[tuple[bytes, Peer | None]]:
        """None: the peer that the channel was opened for."""
        sent: list[tuple[bytes, Peer | None]] = []
        for message, target in self.autopilot.outgoing():
            frame = self._codec.encode(message, target, EPOCH_S + self._now)
            sent += [(frame, peer) for peer in self._routes.to(target) or {None}]
        return sent

    @property
    def deadline(self) -> float:
        return self.autopilot.deadline


class FarEnd(Protocol):
    def receive(self, data: bytes, peer: Peer, now: float) -> None: ...

    def tick(self, now: float) -> None: ...

    def outgoing(self) -> list[tuple[bytes, Peer | None]]: ...

    @property
    def deadline(self) -> float: ...


class Loopback:
    """A channel whose virtual clock only `receive` moves."""

    PEER = "loopback"

    def __init__(self, far: FarEnd, faults: Faults = PERFECT, seed: int = 0) -> None:
        self.far = far
        self._there = Pipe[bytes](faults, 2 * seed)
        self._back = Pipe[bytes](faults, 2 * seed + 1)
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
