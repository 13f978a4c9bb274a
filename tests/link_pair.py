"""Both ends of the mission service without I/O."""

import heapq
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import cycle
from typing import Any, TypeVar

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import Target
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange, RetryPolicy
from ipoa_mission.link.messages import Ack, Heartbeat, Message, MissionType
from ipoa_mission.mission.items import Item, takeoff, waypoint
from ipoa_mission.simulator.mission_service import MissionService
from ipoa_mission.simulator.mock_profile import mock_profile
from tests.px4_waypoints import PX4_117

T = TypeVar("T")
HOME = Geodetic(47.4, 8.5, 400.0)
CLIENT, STRANGER = Target(245, 190), Target(255, 190)
LIMIT_S = 6 * 3600.0


def items_of(autopilot: Autopilot, count: int, shift: float = 0.0) -> tuple[Item, ...]:
    """A list of `count` items on the wire; another `shift` makes another list."""
    places = [Geodetic(47.4 + 0.0001 * n + shift, 8.5 - 0.0000123 * n) for n in range(count)]
    flown = [takeoff(HOME, 20.0), *(waypoint(place, 30.0) for place in places)]
    if autopilot is Autopilot.ARDUPILOT:
        flown = [Item(16, 0, (0.0,) * 4, HOME.latitude_deg, HOME.longitude_deg, HOME.altitude), *flown]
    return tuple(flown[:count])


@dataclass(frozen=True)
class Fate:
    """Copies of a message that arrive, and delays."""

    copies: int = 1
    delay_s: float = 0.02


class Vehicle:
    def __init__(self, autopilot: Autopilot) -> None:
        self.outbox: list[tuple[Message, Target]] = []
        self.changed: list[int] = []
        self.transfers = MissionService(
            mock_profile(autopilot, PX4_117.get(autopilot)),
            lambda: HOME,
            lambda message, to: self.outbox.append((message, to)),
            self.changed.append,
        )
        self.transfers.booted = True

    def hear(self, message: Message, now: float = 0.0, source: Target = CLIENT) -> list[Message]:
        """Return its answers to a message."""
        self.transfers.receive(message, source, now)
        return self.take(source)

    def wait(self, until: float, source: Target = CLIENT) -> list[tuple[float, Message]]:
        sent: list[tuple[float, Message]] = []
        while self.transfers.deadline <= until:
            moment = self.transfers.deadline
            self.transfers.tick(moment)
            sent += [(moment, message) for message in self.take(source)]
        return sent

    def take(self, source: Target = CLIENT) -> list[Message]:
        sent, self.outbox = self.outbox, []
        return [message for message, to in sent if to == source]

    def holds(self, kind: int = MissionType.MISSION) -> tuple[Item, ...]:
        return self.transfers.listed(kind)

    def store(self, items: tuple[Item, ...], kind: int = MissionType.MISSION) -> None:
        self.transfers.stores[MissionType(kind)].put(items)


@dataclass
class Air:
    """Carries messages by the fates of a schedule, on a virtual clock."""

    vehicle: Vehicle
    fates: Iterable[Fate] = (Fate(),)
    now: float = 0.0
    heard: list[Message] = field(default_factory=list)
    _flying: list[tuple[float, int, bool, Message]] = field(default_factory=list)
    _count: int = 0

    def __post_init__(self) -> None:
        self._fate: Iterator[Fate] = cycle(self.fates)
        self._beat = 1.0

    def hold(
        self,
        dialogue: Dialogue[T],
        retry_policy: RetryPolicy = SPECIFIED,
        interrupts: dict[float, MissionError] | None = None,
    ) -> T:
        exchange, transfers, flying = Exchange(dialogue, self.now, retry_policy), self.vehicle.transfers, self._flying
        interrupts = dict(interrupts or {})
        while not exchange.finished:
            self._launch(exchange.outgoing(), to_vehicle=True)
            landing = flying[0][0] if flying else math.inf
            stop = min(interrupts, default=math.inf)
            wake = min(exchange.deadline, landing, transfers.deadline, self._beat, stop)
            assert wake < LIMIT_S, "the conversation does not end"
            self.now = max(self.now, wake)
            while flying and flying[0][0] <= self.now:
                _, _, to_vehicle, message = heapq.heappop(flying)
                if to_vehicle:
                    self._launch(self.vehicle.hear(message, self.now), to_vehicle=False)
                else:
                    self.heard.append(message)
                    exchange.receive(message, self.now)
            if self._beat <= self.now:
                self._beat += 1.0
                self._launch([Heartbeat(2, 12)], to_vehicle=False)
            if transfers.deadline <= self.now:
                transfers.tick(self.now)
                self._launch(self.vehicle.take(), to_vehicle=False)
            if stop <= self.now:
                exchange.interrupt(interrupts.pop(stop), self.now)
            exchange.tick(self.now)
        self._launch(exchange.outgoing(), to_vehicle=True)
        return exchange.result

    def _launch(self, messages: list[Message], to_vehicle: bool) -> None:
        for message in messages:
            fate = next(self._fate)
            for _ in range(fate.copies):
                self._count += 1
                heapq.heappush(self._flying, (self.now + fate.delay_s, self._count, to_vehicle, message))


def connection_of(vehicle: Any) -> Connection:
    assert isinstance(vehicle.connection, Connection)
    return vehicle.connection


def far_end(connection: Connection) -> Any:
    return connection.channel.far  # type: ignore[attr-defined]


def port_of(channel: Any) -> int:
    """Return the port of a UDP or a listening TCP channel."""
    bound = channel._socket if hasattr(channel, "_socket") else channel._listener
    return int(bound.getsockname()[1])


def plain(message: Message) -> Message:
    """Drop PX4's id of a list."""
    return replace(message, opaque_id=0) if isinstance(message, Ack) else message
