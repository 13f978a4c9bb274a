"""The built-in autopilot behind a channel, in real time or faster: what `ipoa-mission mock` runs."""

import logging
import math
from collections.abc import Callable

from ipoa_mission.errors import BadInput
from ipoa_mission.link.channel import Channel, Peer, open_channel
from ipoa_mission.link.signing import Signer
from ipoa_mission.simulator.autopilot import BuiltInAutopilot
from ipoa_mission.simulator.faults import BadPipe, Faults
from ipoa_mission.simulator.station import Station

PERFECT = Faults()
LONGEST_WAIT_S = 0.1
MOST_LATE_S = 1.0  # by which the autopilot's clock may be beyond what it should have done
WORTH_A_WORD_S = 10.0
log = logging.getLogger(__name__)
MOST_PIPES = 32


def serve(
    url: str,
    autopilot: BuiltInAutopilot,
    speedup: float = 1.0,
    faults: Faults = PERFECT,
    system: int = 1,
    seed: int = 0,
    signer: Signer | None = None,
    until: Callable[[], bool] = lambda: False,
) -> None:
    """Run `autopilot` at `url` until `until` says so (asked ten times a second), or Ctrl-C.

    Raises:
        BadInput, LinkDown: the link cannot be opened.
    """
    if not 0.01 <= speedup <= 1000.0:
        raise BadInput(f"speedup: expected 0.01 to 1000, not {speedup}")
    channel = open_channel(url)
    try:
        station = Station(autopilot, system, signer, channel.datagrams)
        Server(channel, station, speedup, faults, seed).run(until)
    finally:
        channel.close()


class Server:
    """One station behind one channel; its clock runs `speedup` times as fast as the channel's."""

    def __init__(
        self, channel: Channel, station: Station, speedup: float = 1.0, faults: Faults = PERFECT, seed: int = 0
    ) -> None:
        self._channel = channel
        self._station = station
        self._speedup = speedup
        self._faults = faults
        self._seed = seed
        self._epoch = channel.now()
        self._lost_s = 0.0
        self._inward: dict[Peer, BadPipe] = {}
        self._outward: dict[Peer | None, BadPipe] = {}

    def run(self, until: Callable[[], bool]) -> None:
        """Serve until told to stop."""
        while not until():
            self.step()

    def step(self) -> None:
        """Wait for bytes or for the next deadline, and act."""
        wake = min(self._real(self._station.deadline), *self._pipes_wake(), self._channel.now() + LONGEST_WAIT_S)
        for data, peer in self._channel.receive(wake):
            self._pipe(self._inward, peer, 1).push(data, self._channel.now())
        now = self._channel.now()
        self._slow_down(now)
        for peer, pipe in self._inward.items():
            for data in pipe.pop(now):
                self._station.receive(data, peer, self._virtual(now))
        self._station.tick(self._virtual(now))
        for data, to in self._station.outgoing():
            self._pipe(self._outward, to, 2).push(data, now)
        for to, pipe in self._outward.items():
            for data in pipe.pop(now):
                self._channel.send(data, to)

    def _slow_down(self, now: float) -> None:
        """Let the clock fall behind rather than jump, where the machine is too busy for so many times as fast."""
        late_s = self._virtual(now) - self._station.deadline - MOST_LATE_S
        if late_s > 0:
            self._epoch += late_s / self._speedup
            if self._lost_s <= WORTH_A_WORD_S < self._lost_s + late_s:
                log.warning("the machine cannot keep up with %g times as fast: the clock is slowed", self._speedup)
            self._lost_s += late_s

    def _virtual(self, real: float) -> float:
        return (real - self._epoch) * self._speedup

    def _real(self, virtual: float) -> float:
        return self._epoch + virtual / self._speedup

    def _pipe(self, pipes: dict[Peer, BadPipe] | dict[Peer | None, BadPipe], peer: Peer, way: int) -> BadPipe:
        if peer not in pipes:
            while len(pipes) >= MOST_PIPES:
                del pipes[next(iter(pipes))]
            pipes[peer] = BadPipe(self._faults, self._seed * 1000 + way * 100 + len(pipes))
        return pipes[peer]

    def _pipes_wake(self) -> list[float]:
        return [pipe.deadline for pipe in (*self._inward.values(), *self._outward.values())] or [math.inf]
