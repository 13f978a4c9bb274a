"""Vehicles on a link, and a session with one."""

import math
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from typing import Self

from ipoa_mission.autopilot.autopilot import VehicleKind
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import Heard, Target
from ipoa_mission.link.connection import Connection, Listening, MessageLink, run_dialogue
from ipoa_mission.link.conversations import observed
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, RetryPolicy, RoundTrip, T
from ipoa_mission.link.orders import request_version
from ipoa_mission.link.vehicle_state import VehicleState


@dataclass(frozen=True)
class FoundVehicle:
    system: int
    kind: VehicleKind
    armed: bool
    is_ready: bool


def scan(connection: Connection, seconds: float = 3.0) -> tuple[FoundVehicle, ...]:
    autopilots: dict[int, FoundVehicle] = {}
    until = connection.now() + seconds
    while connection.now() < until:
        autopilots |= autopilots_in(connection.receive(until))
    return tuple(autopilots[system] for system in sorted(autopilots))


def version_of(connection: Connection, system: int) -> Version | None:
    """Return a heard vehicle's version; None if it does not say it within three seconds."""
    policy = replace(SPECIFIED, answer_s=0.7, retries=3, alive_retries=3, adapt=False)
    target = Target(system, m.AUTOPILOT_COMPONENT)
    about = run_dialogue(connection, target, request_version(), RoundTrip(policy))
    return None if about is None else Version.of_flight_sw(about.flight_sw_version)


def autopilots_in(heard: Iterable[Heard]) -> dict[int, FoundVehicle]:
    autopilots: dict[int, FoundVehicle] = {}
    for received in heard:
        beat = received.message
        if isinstance(beat, m.Heartbeat) and beat.vehicle is not None and received.component == m.AUTOPILOT_COMPONENT:
            is_ready = beat.system_status >= m.STANDBY
            autopilots[received.system] = FoundVehicle(received.system, beat.vehicle, beat.armed, is_ready)
    return autopilots


def round_trips_in(heard: Iterable[Heard], now: float) -> dict[int, float]:
    return {
        ping.system: max(now - ping.message.time_usec / 1e6, 0.0)
        for ping in heard
        if isinstance(ping.message, m.Ping) and ping.target.system != 0 and ping.component == m.AUTOPILOT_COMPONENT
    }


class VehicleSession:
    def __init__(
        self,
        connection: MessageLink,
        heard: FoundVehicle,
        retry_policy: RetryPolicy = SPECIFIED,
        round_trip_s: float | None = None,
    ) -> None:
        self.connection = connection
        self.system = heard.system
        self.autopilot = heard.kind.autopilot
        self.state = VehicleState(self.autopilot, heard.kind, heard.is_ready, heard.armed)
        self._about: m.AutopilotVersion | None = None
        self._retry_policy = retry_policy
        self._rtt = RoundTrip(retry_policy)
        if round_trip_s is not None:
            self._rtt.sample(round_trip_s)
        self._until = math.inf

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self.connection.close()

    def give_up_after(self, seconds: float) -> None:
        """Raise TimeUp in the present verb after this time, also in a watched flight."""
        self._until = self.connection.now() + seconds

    @property
    def version_heard(self) -> Version | None:
        return None if self._about is None else Version.of_flight_sw(self._about.flight_sw_version)

    def firmware_version(self) -> Version | None:
        with self._in_time():
            return Version.of_flight_sw(self._read_version().flight_sw_version)

    def _run_order(self, dialogue: Dialogue[T]) -> T:
        """Run a dialogue that may change the vehicle; raise NotFlown."""
        self.state.expect_flown()
        return self._run(observed(dialogue, lambda heard: self.state.expect_flown()))

    def _run_unlimited(self, dialogue: Dialogue[None]) -> None:
        with self._limited_to(math.inf):
            self._run_order(dialogue)

    def _run(self, dialogue: Dialogue[T], quiet_s: float = math.inf) -> T:
        target = Target(self.system, m.AUTOPILOT_COMPONENT)
        listening = Listening(self._overhear, self._until, quiet_s)
        return run_dialogue(self.connection, target, dialogue, self._rtt, listening)

    def _in_time(self) -> AbstractContextManager[None]:
        return self._limited_to(min(self._until, self.connection.now() + self._retry_policy.total_s))

    @contextmanager
    def _limited_to(self, until_s: float) -> Iterator[None]:
        before = self._until
        self._until = until_s
        try:
            yield
        finally:
            self._until = before

    def _overhear(self, message: m.Message) -> None:
        self.state.note(message)

    def _read_version(self) -> m.AutopilotVersion:
        if self._about is None:
            self._about = self._run(request_version()) or m.AutopilotVersion(0)
        return self._about
