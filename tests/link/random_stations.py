"""Run random schedules of uploads while other stations, some with our ids, transfer their lists.

All is in virtual time and behind one address: only ids identify a sender. A schedule ends with the sent list on the
vehicle, a clear error, a replacement too late to be known, a false success, or no end.
"""

import heapq
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import count as counting
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.conversations import clear, download, offer
from ipoa_mission.link.dialogue import SPECIFIED, Dialogue, Exchange
from ipoa_mission.link.messages import Ack, Current, Message, MissionType
from ipoa_mission.link.upload import Upload, upload, upload_by_file
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.stored_mission import compare, to_wire
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.situation import Conditions

HOME = Geodetic(47.4, 8.5, 400.0)
US = Target(245, 190)
OTHERS = (US, US, Target(254, 190), Target(255, 190), Target(245, 191))
LONGEST_S = 1800.0  # virtual time
TOLD_AGAIN_S = 1.2  # interval at which a vehicle reports its mission


class Outcome(StrEnum):
    """Name the outcomes of an upload."""

    EXACT = "exact"
    ERROR = "clear error"
    UNKNOWABLE = "replaced too late to be heard of"
    FALSE = "false success"
    HANG = "hang"


def wire_list(autopilot: Autopilot, count: int, shift: int) -> tuple[Item, ...]:
    """Return a list for the wire; another `shift` makes another list."""
    places = [Geodetic(47.4 + 1e-4 * n, 8.5 + 1e-5 * shift) for n in range(1, count - 1)]
    items = (takeoff(HOME, 20.0), *(waypoint(place, 30.0) for place in places), return_to_launch())
    return to_wire(Mission(HOME, items, autopilot))


@dataclass(frozen=True)
class Radio:
    """Define probabilities of faults, and one-way delays [s]."""

    loss: float
    double: float
    delay_s: float
    late_s: float

    @property
    def news_s(self) -> float:
        """Return the longest delay of a report of the vehicle [s]."""
        return self.delay_s + self.late_s + TOLD_AGAIN_S


ABOARD = Radio(0.0, 0.0, 0.001, 0.0)


@dataclass
class Speaker:
    """Hold one end of a link, its dialogue, its start and its cut-off [s]."""

    name: Target
    radio: Radio
    dialogue: Callable[[], Dialogue[Any]]
    begins_s: float
    ends_s: float = math.inf
    exchange: Exchange[Any] | None = None


@dataclass
class World:
    """Hold a vehicle and its stations; `changed_s`: time since which it does not hold `sent`.

    `was_told`: since then the vehicle has reported another list's id.
    """

    chance: random.Random
    mock: Mock
    sent: tuple[Item, ...]
    now: float = 0.0
    changed_s: float | None = None
    was_told: bool = False
    ours_is: int = 0  # id of the list on the vehicle
    _air: list[tuple[float, int, Target | None, Speaker, Message]] = field(default_factory=list)
    _count: int = 0

    def run(self, ours: Speaker, others: list[Speaker]) -> None:
        """Run until our dialogue ends; raise its error."""
        speakers = [ours, *others]
        while ours.exchange is None or not ours.exchange.finished:
            self._advance(speakers)
            self._land(speakers)
            self.mock.tick(self.now)
            for speaker in speakers:
                self._live(speaker, must_end_well=speaker is ours)
            self._launch_answers(speakers)
            self._look()
            if self.now > LONGEST_S:
                return

    def _advance(self, speakers: list[Speaker]) -> None:
        moments = [self._air[0][0] if self._air else math.inf, self.mock.deadline]
        for each in speakers:
            moments.append(each.begins_s if each.exchange is None else min(each.exchange.deadline, each.ends_s))
        self.now = max(self.now, min(moments))

    def _land(self, speakers: list[Speaker]) -> None:
        while self._air and self._air[0][0] <= self.now:
            _, _, source, listener, message = heapq.heappop(self._air)
            if source is not None:
                self.mock.receive(message, source, self.now)
                self._look()
                continue
            is_ours = listener is speakers[0]
            if is_ours and self.changed_s is not None:
                self.was_told |= self._names_another(message)
            if listener.exchange is not None:
                self._hear(listener, message, must_end_well=is_ours)

    def _hear(self, speaker: Speaker, message: Message, must_end_well: bool) -> None:
        try:
            if speaker.exchange is not None:
                speaker.exchange.receive(message, self.now)
        except MissionError:
            if must_end_well:
                raise
            self._end(speaker)

    def _live(self, speaker: Speaker, must_end_well: bool) -> None:
        try:
            if speaker.exchange is None and self.now >= speaker.begins_s:
                speaker.begins_s = math.inf
                speaker.exchange = Exchange(speaker.dialogue(), self.now, SPECIFIED)
            if speaker.exchange is not None:
                speaker.exchange.tick(self.now)
                for message in speaker.exchange.outgoing():
                    self._launch(speaker.name, speaker, message)
                if speaker.exchange.finished or self.now >= speaker.ends_s:
                    self._end(speaker, keep=must_end_well)
        except MissionError:
            if must_end_well:
                raise
            self._end(speaker)

    def _end(self, speaker: Speaker, keep: bool = False) -> None:
        if not keep:
            speaker.exchange, speaker.begins_s, speaker.ends_s = None, math.inf, math.inf

    def _launch_answers(self, speakers: list[Speaker]) -> None:
        for message, target in self.mock.outgoing():
            for speaker in speakers:
                if target in (EVERYONE, speaker.name):
                    self._launch(None, speaker, message)

    def _launch(self, source: Target | None, speaker: Speaker, message: Message) -> None:
        radio, chance = speaker.radio, self.chance.random
        for _ in range(2 if chance() < radio.double else 1):
            if chance() < radio.loss:
                continue
            self._count += 1
            lands_s = self.now + radio.delay_s + radio.late_s * chance()
            heapq.heappush(self._air, (lands_s, self._count, source, speaker, message))

    def _names_another(self, message: Message) -> bool:
        named = message.mission_id if isinstance(message, Current) else 0
        named = message.opaque_id if isinstance(message, Ack) and message.kind == MissionType.MISSION else named
        return named not in (0, self.ours_is)

    def _look(self) -> None:
        stored = self.mock.transfers.listed(MissionType.MISSION)
        if compare(self.sent, stored, self.mock.profile.autopilot) is None:
            self.changed_s, self.was_told = None, False
            self.ours_is = self.mock.transfers.list_id(MissionType.MISSION)
        elif self.changed_s is None:
            self.changed_s = self.now


def radio_of(chance: random.Random) -> Radio:
    """Return a radio; every second one is poor."""
    poor = chance.random() < 0.5
    return Radio(
        loss=chance.uniform(0.0, 0.3) if poor else 0.0,
        double=chance.uniform(0.0, 0.2) if poor else 0.0,
        delay_s=chance.choice([0.0, 0.01, 0.05, 0.1, 0.3]),
        late_s=chance.choice([0.0, 0.02, 0.2]) if poor else 0.0,
    )


def stranger(chance: random.Random, autopilot: Autopilot, ours: int, radio: Radio) -> Speaker:
    """Return a station that sends, clears or reads a list, and may not finish.

    Its radio is ours or a better one, as on a companion computer.
    """
    theirs = wire_list(autopilot, chance.choice([ours, ours, chance.randrange(3, 9)]), chance.randrange(1, 50))
    kind = MissionType.MISSION
    job = Upload(theirs, autopilot, numbers=_numbers(autopilot, 0x4000))
    dialogues: list[Callable[[], Dialogue[Any]]] = [
        lambda: (upload_by_file if job.numbers is not None else upload)(job),
        lambda: upload(job),
        lambda: offer(theirs, kind),
        lambda: offer(theirs, kind),
        lambda: clear(kind),
        lambda: download(kind),
    ]
    begins_s = chance.choice([chance.uniform(0.0, 0.5), chance.uniform(0.0, 3.0), chance.uniform(0.0, 10.0)])
    ends_s = begins_s + chance.uniform(0.01, 1.0) if chance.random() < 0.2 else math.inf
    name, dialogue = chance.choice(OTHERS), chance.choice(dialogues)
    return Speaker(name, chance.choice([radio, ABOARD]), dialogue, begins_s, ends_s)


def _numbers(autopilot: Autopilot, first: int) -> Iterator[int] | None:
    """Yield numbers of requests for a checksum, if the autopilot computes one."""
    return counting(first, 2) if autopilot.protocol_profile.takes_mission_file else None


def schedule(seed: int) -> tuple[Outcome, str]:
    """Return the outcome of the upload of this schedule, and its message."""
    chance = random.Random(seed)
    autopilot, count = chance.choice(list(registered())), chance.randrange(3, 9)
    radio = radio_of(chance)
    sent = wire_list(autopilot, count, 0)
    world = World(chance, Mock(autopilot, HOME, conditions=Conditions(seed=seed)), sent)
    job = Upload(sent, autopilot, numbers=_numbers(autopilot, 0))
    by_file = job.numbers is not None and chance.random() < 0.3
    ours = Speaker(US, radio, lambda: (upload_by_file if by_file else upload)(job), chance.uniform(0.0, 1.0))
    others = [stranger(chance, autopilot, count, radio) for _ in range(chance.randrange(1, 4))]
    try:
        world.run(ours, others)
    except MissionError as error:
        return Outcome.ERROR, str(error)
    if ours.exchange is None or not ours.exchange.finished:
        return Outcome.HANG, f"{autopilot}: no end after {world.now:.0f} s"
    if world.changed_s is None:
        return Outcome.EXACT, ""
    age = world.now - world.changed_s
    words = f"{autopilot}: replaced {age:.3f} s before the end, {radio}"
    is_unknowable = age <= radio.news_s and not world.was_told
    return (Outcome.UNKNOWABLE if is_unknowable else Outcome.FALSE), words
