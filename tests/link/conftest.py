import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import TcpChannel, UdpChannel, parse_address
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Server, Station
from tests.link_pair import port_of
from tests.quick_link import hurry

HOME = Geodetic(47.4, 8.5, 400.0)


@dataclass
class Running:
    """A mock under way: where it listens, and what it holds."""

    port: int
    mock: Mock


@contextmanager
def running(
    family: Autopilot, speedup: float = 20.0, transport: str = "udpin", system: int = 1, home: Geodetic = HOME
) -> Iterator[Running]:
    channel = (UdpChannel if transport == "udpin" else TcpChannel)(parse_address(f"{transport}:127.0.0.1:0"))
    mock = Mock(family, home)
    server = Server(channel, Station(mock, system), speedup)
    stop = threading.Event()
    thread = threading.Thread(target=server.run, args=(stop.is_set,))
    thread.start()
    try:
        yield Running(port_of(channel), mock)
    finally:
        stop.set()
        thread.join()
        channel.close()


@pytest.fixture
def run_mock(monkeypatch: pytest.MonkeyPatch) -> Callable[..., object]:
    """Run a mock while a block lasts, many times as fast as real."""
    hurry(monkeypatch.setattr)
    return running
