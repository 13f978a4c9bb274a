"""The other side of every dialogue, one vehicle: what it has said of itself, and how long one waits for it."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Self, TypeVar

from ipoa_mission.link import conversations, orders
from ipoa_mission.link.codec import Target
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Patience, Tempo
from ipoa_mission.link.discovery import FoundVehicle
from ipoa_mission.link.line import Carrier, converse
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, Message
from ipoa_mission.link.telemetry import AutopilotVersion
from ipoa_mission.link.vehicle_state import VehicleState
from ipoa_mission.vehicles.version import Version

T = TypeVar("T")


class RemoteVehicle:
    """One vehicle on a line, with which dialogues are held."""

    def __init__(
        self, line: Carrier, heard: FoundVehicle, patience: Patience = SPECIFIED, round_trip_s: float | None = None
    ) -> None:
        self.line = line
        self.system = heard.system
        self.autopilot = heard.kind.autopilot
        self.state = VehicleState(self.autopilot, heard.kind, heard.is_ready, heard.armed)
        self.overhearing: Callable[[Message], None] = lambda message: None
        """Told everything that the vehicle says while something is done with it."""
        self._about: AutopilotVersion | None = None
        self._patience = patience
        self._tempo = Tempo(patience)
        if round_trip_s is not None:
            self._tempo.sample(round_trip_s)
        self._until = math.inf

    def firmware_version(self) -> Version | None:
        """The version that the vehicle says of its firmware, AUTOPILOT_VERSION; None where it does not say."""
        with self._in_time():
            return Version.said(self._told().flight_sw_version)

    @property
    def version_heard(self) -> Version | None:
        """The same as far as it was asked for; None before."""
        return None if self._about is None else Version.said(self._about.flight_sw_version)

    def send(self, message: Any) -> None:
        """Say one of pymavlink's messages (`MAVLink_command_long_message`, ...), to whom its own fields name.

        Raises:
            BadInput: it is none, or of a dialect that `connect` was not given.
        """
        from ipoa_mission.link.mavutil_channel import own_line, payload_of

        own_line(self.line).say(*payload_of(message))

    def messages(self, seconds: float, *names: str) -> list[Any]:
        """What is heard from the vehicle in so many `seconds`, as pymavlink's messages; `names`: only those."""
        from ipoa_mission.link.mavutil_channel import messages_from, own_line

        return messages_from(own_line(self.line), self.system, seconds, names, self._overhear)

    def give_up_after(self, seconds: float) -> None:
        """Raise TimeUp in what is under way so many seconds from now: the watching of a flight, too."""
        self._until = self.line.now() + seconds

    def close(self) -> None:
        """Close the line."""
        self.line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _tell(self, dialogue: Dialogue[T]) -> T:
        """Hold a dialogue that changes something, with a vehicle on which it is known to mean what is meant."""
        self.state.expect_flown()
        return self._hold(conversations.noting(dialogue, lambda heard: self.state.expect_flown()))

    def _hold(self, dialogue: Dialogue[T], quiet_s: float = math.inf) -> T:
        """Hold a dialogue; `quiet_s`: how long the vehicle may be silent in it."""
        patience, tempo = self._patience, self._tempo
        return converse(self.line, self._target, dialogue, patience, tempo, self._overhear, self._until, quiet_s)

    @property
    def _target(self) -> Target:
        return Target(self.system, AUTOPILOT_COMPONENT)

    @contextmanager
    def _in_time(self) -> Iterator[None]:
        """What is said in here must be over when the user's patience is."""
        before = self._until
        self._until = min(before, self.line.now() + self._patience.total_s)
        try:
            yield
        finally:
            self._until = before

    def _overhear(self, message: Message) -> None:
        self.state.note(message)
        if self.state.owns(message):
            self._heed(message)
            self.overhearing(message)

    def _heed(self, message: Message) -> None:
        """The vehicle has said something."""

    def _told(self) -> AutopilotVersion:
        """What the autopilot says of itself; it is asked once."""
        if self._about is None:
            self._about = self._hold(orders.about()) or AutopilotVersion(0)
        return self._about
