"""Simulate the target vehicle behind a bad radio, and make its mission."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.address import parse_address
from ipoa_mission.link.channel import Peer, UdpChannel
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.faults import Faults
from ipoa_mission.simulator.mock_server import Server
from ipoa_mission.simulator.station import Station
from ipoa_mission.world.frame import Geodetic

HOME = Geodetic(47.4, 8.5, 400.0)
MISSION_MESSAGES = frozenset({39, 40, 43, 44, 47, 51, 73, 110})


class CountingChannel(UdpChannel):
    """Count the bytes of mission messages."""

    counted = 0
    ended = False

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        got = super().receive(until)
        for data, _ in got:
            self._count(data)
        return got

    def send(self, data: bytes, peer: Peer | None) -> None:
        self._count(data)
        self.ended = self.ended or data[7:10] == b"\x2f\0\0"  # MISSION_ACK
        super().send(data, peer)

    def _count(self, data: bytes) -> None:
        number = int.from_bytes(data[7:10], "little") if data[:1] == b"\xfd" else data[5]
        if number in MISSION_MESSAGES and not self.ended:
            self.counted += len(data)


def mission(autopilot: Autopilot, items: int) -> Mission:
    """Return a mission of `items` whose coordinates need every digit, and whose params every client's file can hold."""
    legs = [waypoint(Geodetic(47.4 + 0.000123457 * n, 8.5 - 0.000098763 * n), 30.0) for n in range(1, items - 1)]
    every = (takeoff(HOME, 20.0), *legs, return_to_launch())
    return Mission(HOME, tuple(replace(item, params=(0.0,) * 4) for item in every), autopilot)


@contextmanager
def vehicle(autopilot: Autopilot, faults: Faults, seed: int) -> Iterator[tuple[Mock, CountingChannel]]:
    """Yield a built-in autopilot behind a bad radio."""
    channel = CountingChannel(parse_address("udpin:127.0.0.1:0"))
    mock = Mock(autopilot, HOME)
    server = Server(channel, Station(mock), 1.0, faults, seed)
    stop = threading.Event()
    thread = threading.Thread(target=server.run, args=(stop.is_set,))
    thread.start()
    try:
        yield mock, channel
    finally:
        stop.set()
        thread.join()
        channel.close()
