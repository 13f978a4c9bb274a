"""Which autopilots are on a link, as their heartbeats tell."""

from collections.abc import Iterable
from dataclasses import dataclass

from ipoa_mission.autopilots.kinds import Kind
from ipoa_mission.link.codec import Heard
from ipoa_mission.link.line import Line
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, STANDBY, Firmware, Heartbeat, Ping


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
