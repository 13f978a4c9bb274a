"""Serve the built-in autopilot in real time or faster."""

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.errors import BadInput
from ipoa_mission.link.channel import Channel, Peer
from ipoa_mission.simulator.faults import PERFECT, Faults, Pipe
from ipoa_mission.simulator.station import Station

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServerLimits:
    wait_s: float = 0.1
    clock_lag_s: float = 1.0
    reported_lag_s: float = 10.0
    frames_hz: float = 2000.0  # to a peer: more overrun a ground station's socket
    frames_at_once: int = 100  # Linux keeps 277 small ones in an unread socket
    pipes: int = 32


LIMITS = ServerLimits()


class Server:
    """Serve one station with a clock up to `speedup` times as fast as real time.

    The clock is real while the autopilot waits for a client, and slower before it sends more than a client reads.
    """

    def __init__(
        self, channel: Channel, station: Station, speedup: float = 1.0, faults: Faults = PERFECT, seed: int = 0
    ) -> None:
        if not 0.01 <= speedup <= 1000.0:
            raise BadInput(f"expected 0.01 to 1000, not {speedup}", place="speedup")
        self._channel = channel
        self._station = station
        self._speedup = speedup
        self._faults = faults
        self._seed = seed
        self._real_s = channel.now()
        self._virtual_s = 0.0
        self._lost_s = 0.0
        self._unread = 0.0  # frames above the allowed rate
        self._inward: dict[Peer, Pipe] = {}
        self._outward: dict[Peer | None, Pipe] = {}

    def run(self, until: Callable[[], bool]) -> None:
        """Run until `until` returns true (asked ten times a second), or Ctrl-C."""
        while not until():
            self.step()

    def step(self) -> None:
        waits = self._is_ahead or self._station.autopilot.awaits_somebody
        hurry = min(self._speedup, 1.0) if waits else self._speedup
        due = self._real_s + max(self._station.deadline - self._virtual_s, 0.0) / hurry
        rested_s = (self._unread - LIMITS.frames_at_once) / LIMITS.frames_hz if self._is_ahead else math.inf
        pipes = [pipe.deadline for pipe in (*self._inward.values(), *self._outward.values())]
        wake = min(due, self._real_s + rested_s, *pipes, self._channel.now() + LIMITS.wait_s)
        for data, peer in self._channel.receive(wake):
            self._pipe(self._inward, peer, 1).push(data, self._channel.now())
        now = self._channel.now()
        self._advance_clock(now, hurry)
        for peer, pipe in self._inward.items():
            for data in pipe.pop(now):
                self._station.receive(data, peer, self._virtual_s)
        self._station.tick(self._virtual_s)
        for data, to in self._station.outgoing():
            self._pipe(self._outward, to, 2).push(data, now)
        most = 0
        for to, pipe in self._outward.items():
            through = pipe.pop(now)
            for data in through:
                self._channel.send(data, to)
            most = max(most, len(through))
        self._unread += most

    @property
    def _is_ahead(self) -> bool:
        return self._unread > LIMITS.frames_at_once

    def _advance_clock(self, now: float, hurry: float) -> None:
        """Let the clock lag on a slow machine."""
        passed_s = now - self._real_s
        self._real_s = now
        self._unread = max(self._unread - passed_s * LIMITS.frames_hz, 0.0)
        self._virtual_s += passed_s * hurry
        late_s = self._virtual_s - self._station.deadline - LIMITS.clock_lag_s
        if late_s > 0:
            self._virtual_s -= late_s
            if self._lost_s <= LIMITS.reported_lag_s < self._lost_s + late_s:
                log.warning("the machine is too slow for speed %g: the clock is slowed", self._speedup)
            self._lost_s += late_s

    def _pipe(self, pipes: dict[Peer, Pipe] | dict[Peer | None, Pipe], peer: Peer, direction: int) -> Pipe:
        if peer not in pipes:
            while len(pipes) >= LIMITS.pipes:
                del pipes[next(iter(pipes))]
            pipes[peer] = Pipe(self._faults, self._seed * 1000 + direction * 100 + len(pipes))
        return pipes[peer]
