"""A vehicle's state, link and time limit; `Vehicle` adds missions and flights."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Self

from ipoa_mission.autopilot.version import Version
from ipoa_mission.link import conversations, orders
from ipoa_mission.link.codec import Target
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Patience, T, Tempo
from ipoa_mission.link.discovery import FoundVehicle
from ipoa_mission.link.line import Carrier, Listening, converse
from ipoa_mission.link.mavutil_channel import expect_line, messages_from, payload_of
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, AutopilotVersion, Message
from ipoa_mission.link.vehicle_state import VehicleState


class RemoteVehicle:
    def __init__(
        self, line: Carrier, heard: FoundVehicle, patience: Patience = SPECIFIED, round_trip_s: float | None = None
    ) -> None:
        self.line = line
        self.system = heard.system
        self.autopilot = heard.kind.autopilot
        self.state = VehicleState(self.autopilot, heard.kind, heard.is_ready, heard.armed)
        self.overhearing: Callable[[Message], None] = lambda message: None
        """Called with every message of the vehicle while a dialogue is held."""
        self._about: AutopilotVersion | None = None
        self._patience = patience
        self._tempo = Tempo(patience)
        if round_trip_s is not None:
            self._tempo.sample(round_trip_s)
        self._until = math.inf

    def firmware_version(self) -> Version | None:
        with self._in_time():
            return Version.of_flight_sw(self._read_version().flight_sw_version)

    @property
    def version_heard(self) -> Version | None:
        return None if self._about is None else Version.of_flight_sw(self._about.flight_sw_version)

    def send(self, message: Any) -> None:
        """Send to the message's own target; raise BadInput for an unknown dialect."""
        expect_line(self.line).send_payload(*payload_of(message))

    def messages(self, seconds: float, *names: str) -> list[Any]:
        """Return the vehicle's messages as pymavlink's; `names`: only those."""
        return messages_from(expect_line(self.line), self.system, seconds, names, self._overhear)

    def give_up_after(self, seconds: float) -> None:
        """Raise TimeUp in the present verb after this time, also in a watched flight."""
        self._until = self.line.now() + seconds

    def close(self) -> None:
        self.line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _tell(self, dialogue: Dialogue[T]) -> T:
        """The dialogue changes something on a supported multicopter."""
        self.state.expect_flown()
        return self._hold(conversations.observed(dialogue, lambda heard: self.state.expect_flown()))

    def _hold(self, dialogue: Dialogue[T], quiet_s: float = math.inf) -> T:
        target = Target(self.system, AUTOPILOT_COMPONENT)
        listening = Listening(self._overhear, self._until, quiet_s)
        return converse(self.line, target, dialogue, self._tempo, listening)

    @contextmanager
    def _in_time(self) -> Iterator[None]:
        before = self._until
        self._until = min(before, self.line.now() + self._patience.total_s)
        try:
            yield
        finally:
            self._until = before

    def _overhear(self, message: Message) -> None:
        self.state.note(message)
        if self.state.owns(message):
            self._handle(message)
            self.overhearing(message)

    def _handle(self, message: Message) -> None: ...

    def _read_version(self) -> AutopilotVersion:
        if self._about is None:
            self._about = self._hold(orders.request_version()) or AutopilotVersion(0)
        return self._about
