"""The built-in autopilot's end of a link with faults, on a virtual clock (`Loopback`) or a real one (`Server`)."""

import heapq
import logging
import math
import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from ipoa_mission.errors import BadInput
from ipoa_mission.link.channel import Channel, Peer
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connection import Routes
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT
from ipoa_mission.link.signing import Signer
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot

log = logging.getLogger(__name__)
#: 2026-01-01 00:00 UTC: logs are reproducible.
EPOCH_S = 1_767_225_600.0
T = TypeVar("T")


@dataclass(frozen=True)
class Faults:
    """Faults of a link, for each frame in each direction.

    Attributes:
        loss: probability that a frame is lost.
        duplicate: probability that it arrives twice.
        delay_s: one-way delay [s].
        reorder: probability that it is held back.
        reorder_s: longest extra delay [s].

    Raises:
        BadInput: a probability is not from 0 to 1, or a time not from 0 to 60 s.

    Example:
        >>> Faults(loss=0.1, delay_s=0.2).duplicate
        0.0
    """

    loss: float = 0.0
    duplicate: float = 0.0
    delay_s: float = 0.0
    reorder: float = 0.0
    reorder_s: float = 0.2

    def __post_init__(self) -> None:
        for name in ("loss", "duplicate", "reorder"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise BadInput(f"expected a probability from 0 to 1, not {getattr(self, name)}", place=name)
        for name in ("delay_s", "reorder_s"):
            if not 0.0 <= getattr(self, name) < 60.0:
                raise BadInput(f"expected 0 to 60 seconds, not {getattr(self, name)}", place=name)


PERFECT = Faults()


class Pipe(Generic[T]):
    """One direction; the same seed gives the same faults."""

    MAX_QUEUED = 100_000

    def __init__(self, faults: Faults, seed: int) -> None:
        self._faults = faults
        self._random = random.Random(seed)
        self._queue: list[tuple[float, int, T]] = []
        self._pushed = 0

    def push(self, data: T, now: float) -> None:
        faults = self._faults
        chance = self._random.random
        for _ in range(2 if chance() < faults.duplicate else 1):
            lost = chance() < faults.loss
            late = chance() * faults.reorder_s if chance() < faults.reorder else 0.0
            if not lost and len(self._queue) < self.MAX_QUEUED:
                self._pushed += 1
                heapq.heappush(self._queue, (now + faults.delay_s + late, self._pushed, data))

    def pop(self, now: float) -> list[T]:
        arrived = list[T]()
        while self._queue and self._queue[0][0] <= now:
            arrived.append(heapq.heappop(self._queue)[2])
        return arrived

    @property
    def deadline(self) -> float:
        return self._queue[0][0] if self._queue else math.inf


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


@dataclass
class Server:
    """Serve one station with a clock up to `speedup` times as fast as real time.

    The clock is real while the autopilot waits for a client, and slows down for a slow reader.
    """

    WAIT_S = 0.1
    CLOCK_LAG_S = 1.0
    REPORTED_LAG_S = 10.0
    FRAMES_HZ = 2000.0  # to a peer: more overrun a ground station's socket
    FRAMES_AT_ONCE = 100  # Linux keeps 277 small ones in an unread socket

    channel: Channel
    station: Station
    speedup: float = 1.0
    faults: Faults = PERFECT
    seed: int = 0
    _virtual_s: float = 0.0
    _lost_s: float = 0.0
    _unread: float = 0.0  # frames above the allowed rate

    def __post_init__(self) -> None:
        if not 0.01 <= self.speedup <= 1000.0:
            raise BadInput(f"expected 0.01 to 1000, not {self.speedup}", place="speedup")
        self._real_s = self.channel.now()
        self._inward = Pipe[tuple[bytes, Peer]](self.faults, 1000 * self.seed + 100)
        self._outward = Pipe[tuple[bytes, Peer | None]](self.faults, 1000 * self.seed + 200)

    def run(self, until: Callable[[], bool]) -> None:
        """Run until `until` returns true (asked ten times a second), or Ctrl-C."""
        while not until():
            self.step()

    def step(self) -> None:
        is_ahead = self._unread > self.FRAMES_AT_ONCE
        waits = is_ahead or self.station.autopilot.awaits_somebody
        hurry = min(self.speedup, 1.0) if waits else self.speedup
        due = self._real_s + max(self.station.deadline - self._virtual_s, 0.0) / hurry
        rested_s = (self._unread - self.FRAMES_AT_ONCE) / self.FRAMES_HZ if is_ahead else math.inf
        arriving = min(self._inward.deadline, self._outward.deadline)
        wake = min(due, self._real_s + rested_s, arriving, self.channel.now() + self.WAIT_S)
        for received in self.channel.receive(wake):
            self._inward.push(received, self.channel.now())
        now = self.channel.now()
        self._advance_clock(now, hurry)
        for data, peer in self._inward.pop(now):
            self.station.receive(data, peer, self._virtual_s)
        self.station.tick(self._virtual_s)
        for sent in self.station.outgoing():
            self._outward.push(sent, now)
        frames = Counter[Peer | None]()
        for data, to in self._outward.pop(now):
            self.channel.send(data, to)
            frames[to] += 1
        self._unread += max(frames.values(), default=0)

    def _advance_clock(self, now: float, hurry: float) -> None:
        passed_s = now - self._real_s
        self._real_s = now
        self._unread = max(self._unread - passed_s * self.FRAMES_HZ, 0.0)
        self._virtual_s += passed_s * hurry
        late_s = self._virtual_s - self.station.deadline - self.CLOCK_LAG_S
        if late_s > 0:
            self._virtual_s -= late_s
            if self._lost_s <= self.REPORTED_LAG_S < self._lost_s + late_s:
                log.warning("the machine is too slow for speed %g: the clock is slowed", self.speedup)
            self._lost_s += late_s
