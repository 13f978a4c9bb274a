"""Serve the built-in autopilot in real time or faster."""

import logging
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.errors import BadInput
from ipoa_mission.link.channel import Channel, Peer
from ipoa_mission.simulator.faults import PERFECT, Faults, Pipe
from ipoa_mission.simulator.station import Station

log = logging.getLogger(__name__)


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
