"""The built-in autopilot behind a port, on a machine that cannot keep up."""

import logging
import time

import pytest

from ipoa_mission.link.channel import open_channel
from ipoa_mission.simulator.autopilot import BuiltInAutopilot
from ipoa_mission.simulator.server import Server
from ipoa_mission.simulator.station import Station
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.world.frame import Geodetic

HOME = Geodetic(47.397742, 8.545594, 488.0)


class Slow(Station):
    """A station whose every tick takes a twentieth of a second; it remembers the times that it was told."""

    times: list[float]

    def tick(self, now: float) -> None:
        time.sleep(0.05)
        self.times.append(now)
        super().tick(now)


def test_the_clock_of_a_busy_machine_is_slowed_and_said(caplog: pytest.LogCaptureFixture) -> None:
    channel = open_channel("udpin:127.0.0.1:0")
    try:
        station = Slow(BuiltInAutopilot(Autopilot.PX4, HOME), 1, None, channel.datagrams)
        station.times = []
        server = Server(channel, station, speedup=1000.0)
        with caplog.at_level(logging.WARNING, "ipoa_mission"):
            for _ in range(20):
                server.step()
    finally:
        channel.close()
    steps = [b - a for a, b in zip(station.times, station.times[1:], strict=False)]
    assert max(steps) < 5.0  # and not 50, as the wall clock has it
    assert [record.message for record in caplog.records] == [
        "the machine cannot keep up with 1000 times as fast: the clock is slowed"
    ]
