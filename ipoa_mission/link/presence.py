"""Which autopilots are on a link, as their heartbeats tell."""

from collections.abc import Iterable
from dataclasses import dataclass

from ipoa_mission.link.codec import Heard
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.line import Carrier, Line
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, STANDBY, Firmware, Heartbeat, Ping
from ipoa_mission.link.state import VehicleState
from ipoa_mission.vehicles.kind import Kind


@dataclass(frozen=True)
class Found:
    """An autopilot that was heard on a link."""

    system: int
    kind: Kind
    armed: bool
    is_ready: bool


def scan(line: Line, seconds: float = 3.0) -> tuple[Found, ...]:
    """The autopilots that are heard within so many seconds, by system id."""
    autopilots: dict[int, Found] = {}
    until = line.now() + seconds
    while line.now() < until:
        autopilots |= autopilots_in(line.receive(until))
    return tuple(autopilots[system] for system in sorted(autopilots))


def await_booted(line: Carrier, system: int, state: VehicleState, until: float) -> None:
    """Wait for an ArduPilot that is still starting up: it answers every COUNT with NO_SPACE.

    Raises:
        NoAnswer: it has not finished by then.
    """
    while not state.booted:
        if line.now() >= until:
            raise NoAnswer("the vehicle has not finished its start-up")
        for heard in autopilots_in(line.receive(until)).values():
            state.booted |= heard.system == system and heard.is_ready


def autopilots_in(heard: Iterable[Heard]) -> dict[int, Found]:
    """The autopilots whose heartbeats are among what was heard, by system id."""
    return {
        one.system: Found(one.system, Kind(beat.autopilot, beat.type), beat.armed, beat.system_status >= STANDBY)
        for one in heard
        if isinstance(beat := one.message, Heartbeat)
        and one.component == AUTOPILOT_COMPONENT
        and beat.autopilot != Firmware.INVALID
    }


def round_trips_in(heard: Iterable[Heard], now: float) -> dict[int, float]:
    """How long ago those who answer our ping were asked [s]."""
    return {
        one.system: max(now - one.message.time_usec / 1e6, 0.0)
        for one in heard
        if isinstance(one.message, Ping) and one.target.system != 0 and one.component == AUTOPILOT_COMPONENT
    }
