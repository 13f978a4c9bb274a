"""Vehicles on a link by their heartbeats, and their firmware versions."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import cycle

from ipoa_mission.autopilot.commands import VehicleCommand
from ipoa_mission.autopilot.vehicle_kind import VehicleKind
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link.codec import Heard, Target
from ipoa_mission.link.line import Line
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, STANDBY, AutopilotVersion, Heartbeat, MavAutopilot, Ping
from ipoa_mission.link.orders import message_request, order

VERSIONS_S = 3.0


@dataclass(frozen=True)
class FoundVehicle:
    system: int
    kind: VehicleKind
    armed: bool
    is_ready: bool


def scan(line: Line, seconds: float = 3.0) -> tuple[FoundVehicle, ...]:
    autopilots: dict[int, FoundVehicle] = {}
    until = line.now() + seconds
    while line.now() < until:
        autopilots |= autopilots_in(line.receive(until))
    return tuple(autopilots[system] for system in sorted(autopilots))


def versions_of(line: Line, systems: Iterable[int], seconds: float = VERSIONS_S) -> dict[int, Version]:
    silent = set(systems)
    versions = dict[int, Version]()
    until = line.now() + seconds
    # today's request and its predecessor
    turns = cycle((message_request("AUTOPILOT_VERSION"), order(VehicleCommand.REQUEST_AUTOPILOT_CAPABILITIES, 1.0)))
    while silent and line.now() < until:
        request = next(turns)
        for system in sorted(silent):
            line.send(request, Target(system, AUTOPILOT_COMPONENT))
        again = min(line.now() + 0.7, until)
        while silent and line.now() < again:
            for heard in line.receive(again):
                if isinstance(heard.message, AutopilotVersion) and heard.system in silent:
                    silent.discard(heard.system)
                    version = Version.of_flight_sw(heard.message.flight_sw_version)
                    if version is not None:
                        versions[heard.system] = version
    return versions


def autopilots_in(heard: Iterable[Heard]) -> dict[int, FoundVehicle]:
    autopilots: dict[int, FoundVehicle] = {}
    for received in heard:
        beat = received.message
        is_autopilot = received.component == AUTOPILOT_COMPONENT
        if is_autopilot and isinstance(beat, Heartbeat) and beat.autopilot != MavAutopilot.INVALID:
            kind = VehicleKind(beat.autopilot, beat.type)
            is_ready = beat.system_status >= STANDBY
            autopilots[received.system] = FoundVehicle(received.system, kind, beat.armed, is_ready)
    return autopilots


def round_trips_in(heard: Iterable[Heard], now: float) -> dict[int, float]:
    return {
        ping.system: max(now - ping.message.time_usec / 1e6, 0.0)
        for ping in heard
        if isinstance(ping.message, Ping) and ping.target.system != 0 and ping.component == AUTOPILOT_COMPONENT
    }
