import logging
import time

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import Peer, open_channel
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.messages import NO_AUTOPILOT, CommandLong, Count, Heartbeat, Message, MissionType
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.station import Server, Station

HOME = Geodetic(47.397742, 8.545594, 488.0)


class Slow(Station):
    """Every tick takes a twentieth of a second; keeps the reported times."""

    times: list[float]

    def tick(self, now: float) -> None:
        time.sleep(0.05)
        self.times.append(now)
        super().tick(now)


def test_the_clock_of_a_busy_machine_is_slowed_and_said(caplog: pytest.LogCaptureFixture) -> None:
    channel = open_channel("udpin:127.0.0.1:0")
    try:
        station = Slow(BuiltInAutopilot(Autopilot.PX4, HOME), 1)
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
        "the machine is too slow for speed 1000: the clock is slowed"
    ]


STATION, VEHICLE = Target(255, 190), Target(1, 1)


class Beside:
    """A channel to one station on a clock that each look moves by a microsecond at least."""

    def __init__(self) -> None:
        self.sent = 0
        self._now = 0.0
        self._coming: list[tuple[bytes, Peer]] = []
        self._codec = Codec(*STATION)

    def now(self) -> float:
        return self._now

    def unix_s(self) -> float:
        return 1_767_225_600.0 + self._now

    def say(self, message: Message) -> None:
        self._coming.append((self._codec.encode(message, VEHICLE, self.unix_s()), "station"))

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        coming, self._coming = self._coming, []
        self._now = self._now if coming else max(self._now + 1e-6, until)
        return coming

    def send(self, data: bytes, peer: Peer | None) -> None:
        self.sent += 1

    def close(self) -> None:
        return None


def beside(family: Autopilot, speedup: float) -> tuple[Beside, BuiltInAutopilot, Server]:
    channel, autopilot = Beside(), BuiltInAutopilot(family, HOME)
    server = Server(channel, Station(autopilot), speedup)
    channel.say(Heartbeat(6, NO_AUTOPILOT))
    server.step()
    return channel, autopilot, server


def run(server: Server, channel: Beside, until: float) -> None:
    while channel.now() < until:
        server.step()


@pytest.mark.parametrize("family", registered())
def test_sender_of_a_list_has_as_long_as_with_a_real_vehicle(family: Autopilot) -> None:
    channel, autopilot, server = beside(family, 100.0)
    channel.say(Count(3, MissionType.MISSION))
    begun = channel.now()
    run(server, channel, begun + 4.0)
    assert autopilot.awaits_somebody
    run(server, channel, begun + 9.0)
    assert not autopilot.awaits_somebody
    sent = channel.sent
    run(server, channel, begun + 10.0)
    assert channel.sent > sent + 50  # a hundred seconds' worth of telemetry


@pytest.mark.parametrize("family", registered())
def test_armed_vehicle_waits_as_long_as_a_real_one(family: Autopilot) -> None:
    channel, autopilot, server = beside(family, 100.0)
    channel.say(CommandLong(Command.COMPONENT_ARM_DISARM, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    begun = channel.now()
    run(server, channel, begun + 8.0)
    assert autopilot.flight.armed
    run(server, channel, begun + 12.0)
    assert not autopilot.flight.armed


def test_no_more_is_said_than_a_busy_station_reads() -> None:
    channel, _, server = beside(Autopilot.PX4, 1000.0)
    begun, sent = channel.now(), channel.sent
    run(server, channel, begun + 3.0)
    at_once = 12  # its streams, when all are due
    assert (
        0.8 * 3.0 * Server.FRAMES_HZ < channel.sent - sent <= 3.0 * Server.FRAMES_HZ + Server.FRAMES_AT_ONCE + at_once
    )
