"""An upload ends when the vehicle is known to hold what was sent: offer, read back, compare, hear the verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import (
    DOUBTFUL,
    MissionRefused,
    Overheard,
    Progress,
    download,
    list_name,
    offer,
    silent,
)
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, Pause, Remark, Step
from ipoa_mission.link.events import words_of
from ipoa_mission.link.messages import Ack, Current, Event, MissionType, Request, Result
from ipoa_mission.mission.firmware import Difference, compare
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicle import Autopilot

#: A transfer that broke off is begun anew, from COUNT, this often; one that got nowhere, only once more.
ATTEMPTS = 12
#: How long a vehicle may take to judge a mission that it has stored and given back; and how long to listen for second
#: thoughts when it has called the mission flyable.
VERDICT_S = 1.5
SECOND_THOUGHTS_S = 0.4
#: Refusals that concern the moment and not the items.
PASSING = frozenset({*DOUBTFUL, Result.DENIED, Result.OPERATION_CANCELLED})
NO_MISSION = 1  # MISSION_STATE: there is none that could be flown


class ReadBackDiffers(MissionError):
    """The vehicle holds something else than it was sent."""

    def __init__(self, kind: int, difference: Difference) -> None:
        self.kind, self.difference = kind, difference
        super().__init__(f"the {list_name(kind)} on the vehicle is not what was sent: {difference}")


class Unflyable(MissionError):
    """The vehicle took the mission and then found that it cannot fly it."""


@dataclass(frozen=True)
class Upload:
    """One list for one vehicle, as it goes over the wire."""

    items: Sequence[Item]
    autopilot: Autopilot
    kind: int = MissionType.MISSION

    @property
    def truncates(self) -> bool:
        """Whether the vehicle forgets its old list as soon as a transfer begins (ArduPilot; its fence is atomic)."""
        return self.autopilot is Autopilot.ARDUPILOT and self.kind != MissionType.FENCE

    @property
    def is_judged(self) -> bool:
        """Whether the vehicle tells after the Ack that it cannot fly this."""
        return self.autopilot is Autopilot.PX4 and self.kind == MissionType.MISSION and len(self.items) > 0


def upload(job: Upload, progress: Progress = silent) -> Dialogue[None]:
    """Put a list on the vehicle and see that it is there, item by item.

    Cancelled in mid-transfer, the vehicle keeps its old list where it can (PX4), else the new one is completed.

    Raises:
        MissionRefused, NoAnswer: with what the vehicle holds now as the hint.
        ReadBackDiffers, Unflyable, Cancelled.
    """
    try:
        yield from _store(job, progress)
    except Cancelled:
        if not job.truncates:
            yield from _withdraw(job.kind)
            raise Cancelled(f"cancelled: the vehicle keeps the {list_name(job.kind)} it had") from None
        yield from _store(job, progress)
        raise Cancelled(
            f"cancelled: the vehicle had already dropped its old {list_name(job.kind)}, so the new one was completed",
            hint="it is whole and verified; clear it if it must not be flown",
        ) from None
    if job.is_judged:
        yield from _verdict()


def _store(job: Upload, progress: Progress) -> Dialogue[None]:
    furthest = -1
    refused_before: MissionRefused | None = None

    def note(done: int, total: int) -> None:
        nonlocal furthest
        furthest = max(furthest, done)
        progress(done, total)

    attempt = 0
    while True:
        attempt += 1
        before, furthest = furthest, -1
        try:
            ending = yield from offer(job.items, job.kind, progress=note)
            stored = yield from download(job.kind)
        except NoAnswer as silence:
            if attempt == ATTEMPTS or max(before, furthest) < 0:
                silence.hint = _leftover(job)
                raise
        except MissionRefused as refusal:
            settled = refusal.result not in PASSING and (not job.truncates or _same(refusal, refused_before))
            if attempt == ATTEMPTS or settled or (_same(refusal, refused_before) and refusal.result == Result.ERROR):
                refusal.hint = _leftover(job)
                raise
            refused_before = refusal
            yield from _wait(1.0)
        else:
            difference = compare(job.items, stored, job.autopilot) if not _both_empty(job, stored) else None
            if difference is None:
                return
            if attempt >= 2 and ending in DOUBTFUL:
                raise MissionRefused(ending, job.kind, len(job.items) - 1)
            if attempt >= 2:
                raise ReadBackDiffers(job.kind, difference)


def _same(one: MissionRefused, other: MissionRefused | None) -> bool:
    return other is not None and (one.result, one.seq) == (other.result, other.seq)


def _both_empty(job: Upload, stored: Sequence[Item]) -> bool:
    """An empty list is empty, although ArduPilot may answer with its home alone."""
    home = 1 if job.autopilot is Autopilot.ARDUPILOT and job.kind == MissionType.MISSION else 0
    return not job.items and len(stored) <= home


def _leftover(job: Upload) -> str:
    name = list_name(job.kind)
    if job.truncates:
        return f"the {name} on the vehicle may now be a mixture of new and old: upload again, or clear it"
    return f"the vehicle keeps the {name} it had, unless it says otherwise"


def _withdraw(kind: int) -> Dialogue[None]:
    """Say "cancelled" in place of every item that is still asked for, until the vehicle is quiet."""
    yield Remark(Ack(Result.OPERATION_CANCELLED, kind))
    step: Step = Pause(1.0)
    while True:
        match (yield step):
            case None:
                return
            case Request(_, k) if k == kind:
                yield Remark(Ack(Result.OPERATION_CANCELLED, kind))
                step = Pause(1.0)
            case _:
                step = None


def _wait(seconds: float) -> Dialogue[None]:
    heard = yield Pause(seconds)
    while heard is not None:
        heard = yield None


def _verdict() -> Dialogue[None]:
    """Listen whether the vehicle finds the mission flyable: the last state that it tells counts."""
    state = 0
    overheard = Overheard()
    heard = yield Pause(VERDICT_S)
    while heard is not None:
        step: Step = None
        match heard:
            case Current(mission_state=told) if told:
                if state != told:
                    step = Pause(VERDICT_S if told == NO_MISSION else SECOND_THOUGHTS_S)
                state = told
            case Event(number):
                overheard.words += [words for words in (words_of(number),) if words]
            case _:
                overheard.note(heard)
        heard = yield step
    if state == NO_MISSION:
        why = str(overheard) or "no reason given"
        raise Unflyable(f"the vehicle stored the mission but finds it unflyable: {why}")
