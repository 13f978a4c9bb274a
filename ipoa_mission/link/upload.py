"""An upload ends when the vehicle is known to hold what was sent: offer, read back, compare, hear the verdict.

If it ends otherwise, the error says what the vehicle holds.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from ipoa_mission.errors import MissionError
from ipoa_mission.link.consistent_download import READINGS, KeepsChanging, read_consistent
from ipoa_mission.link.conversations import (
    DOUBTFUL,
    MissionRefused,
    VehicleTexts,
    list_name,
    noting,
    offer,
    read_list,
)
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, Pause, Remark, Step, TimeUp, wait
from ipoa_mission.link.item_payloads import Payloads, first_difference, pack_items
from ipoa_mission.link.messages import NO_MISSION, WARNING, Ack, Current, Message, MissionType, Request, Result
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import Difference
from ipoa_mission.progress import Progress, count, silent
from ipoa_mission.vehicles.autopilot import Autopilot

#: A transfer that broke off is begun anew, from COUNT, this often; one that got nowhere, only once more.
ATTEMPTS = 12
#: How long a vehicle may take to judge a mission that it has stored and given back; and how long to listen for second
#: thoughts when it has called the mission flyable.
VERDICT_S = 1.5
SECOND_THOUGHTS_S = 0.4
#: Refusals that concern the moment and not the items.
PASSING = frozenset({*DOUBTFUL, Result.DENIED, Result.OPERATION_CANCELLED})


class ReadBackDiffers(MissionError):
    """The vehicle holds something else than it was sent."""

    def __init__(self, kind: int, difference: Difference) -> None:
        self.kind, self.difference = kind, difference
        super().__init__(f"the {list_name(kind)} on the vehicle is not what was sent: {difference}")


class Replaced(MissionError):
    """The vehicle held what it was sent, and now holds something else."""

    def __init__(self, kind: int, difference: Difference) -> None:
        self.kind, self.difference = kind, difference
        super().__init__(
            f"the {list_name(kind)} on the vehicle is no longer what was sent: {difference}",
            hint="somebody else has replaced or cleared it",
        )


class Unflyable(MissionError):
    """The vehicle took the mission and then found that it cannot fly it; `why` in its words, if it has said so."""

    def __init__(self, why: str) -> None:
        self.why = why
        super().__init__(f"the vehicle stored the mission but finds it unflyable: {why or 'no reason was heard'}")


class Unplaced(Unflyable):
    """The vehicle has no position, and without one it finds every mission unflyable (PX4)."""

    def __init__(self) -> None:
        super().__init__("it has no position yet, and so judges none")
        self.hint = "wait until it knows where it is (GPS), and upload again"


@dataclass(frozen=True)
class Upload:
    """One list for one vehicle, as it goes over the wire; `numbers` of questions for the
    checksum of what the vehicle holds, where it may make one.

    Raises:
        BadInput: MAVLink cannot carry it.
    """

    items: Sequence[Item]
    autopilot: Autopilot
    kind: int = MissionType.MISSION
    numbers: Iterator[int] | None = field(default=None, repr=False, compare=False)

    packed: Payloads = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "packed", pack_items(self.items, self.kind))

    @property
    def has_checksum(self) -> bool:
        """Whether the vehicle may make one of what it holds."""
        return self.numbers is not None

    @property
    def truncates(self) -> bool:
        """Whether the vehicle forgets its old list as soon as a transfer begins (ArduPilot; its fence is atomic)."""
        return self.autopilot.protocol_profile.forgets_at_count and self.kind != MissionType.FENCE

    @property
    def is_judged(self) -> bool:
        """Whether the vehicle tells after the Ack that it cannot fly this."""
        return self.autopilot.protocol_profile.judges_later and self.kind == MissionType.MISSION and len(self.items) > 0

    def difference(self, stored: Sequence[Item | bytes]) -> Difference | None:
        """What is not as it was sent. An empty list is empty, although ArduPilot may answer with its home alone."""
        home = self.autopilot.counts_home if self.kind == MissionType.MISSION else 0
        if not self.items and len(stored) <= home:
            return None
        return first_difference(self.items, self.packed, stored, self.autopilot)


@dataclass
class MissionReports(VehicleTexts):
    """The vehicle's words, and what it says of the mission that it holds."""

    faintest: int = WARNING
    stored_as: int = 0  # the id that it gave to what we sent: the first after our COUNT; 0: not told
    is_disputed: bool = False  # it has stored a mission under another id too: one of the two is somebody else's
    is_read: bool = False  # reading back has begun: what is stored from here on is not ours
    ids: frozenset[int] = frozenset()  # of the missions that it has spoken of since,
    latest: int = 0  # and of that which it spoke of last
    total: int | None = None
    is_named: bool = False  # it has named ours since the list was read whole

    def offered(self) -> None:
        """We begin to send our list: what was told before is of others."""
        self.stored_as, self.is_disputed, self.is_read = 0, False, False

    def read(self) -> None:
        """The list is read from here on."""
        self.ids, self.latest, self.total, self.is_read = frozenset(), 0, None, True

    def was_read(self) -> None:
        """The list has been read: what was said before proves nothing of what is there now."""
        self.is_named = False

    def read_again(self) -> None:
        """The list is read once more; what it last said of it still counts."""
        self.ids, self.total, self.is_disputed = frozenset({self.latest} - {0}), None, False
        self.is_named = False

    def note(self, message: Message | None) -> None:
        """Keep what it says of its mission."""
        match message:
            case Ack(Result.ACCEPTED, MissionType.MISSION, number) if number:
                if not self.is_read:
                    self.stored_as = self.stored_as or number
                self.is_disputed |= number != self.stored_as
            case Current(total=total, mission_state=state, mission_id=number):
                if total or state == NO_MISSION:
                    self.total = total
                self.ids |= {number} - {0}
                self.is_named |= number == self.stored_as != 0
                self.latest = number
        super().note(message)

    def proves(self, job: Upload) -> bool:
        """Whether all that it said since the list was begun to be read is of that list, and it has named it since."""
        return self.is_named and self.ids == {self.stored_as} and not self._is_another(job)

    def agrees(self, job: Upload) -> bool:
        """Whether nothing that it said since the list was read is of another one."""
        return len(self.ids) <= 1 and not self._is_another(job)

    def _is_another(self, job: Upload) -> bool:
        return self.is_disputed or self.total not in (None, len(job.items))


@dataclass
class UploadState:
    """How an upload is going."""

    attempt: int = 0
    furthest: int = -1  # the last item that was asked for in this attempt
    before: int = -1  # and in the one before
    may_be_whole: bool = False  # whether the vehicle may have the whole list already
    checksum: int = 0  # of the list as it was read back; 0: the vehicle makes none
    reports: MissionReports = field(default_factory=MissionReports)


def upload(job: Upload, progress: Progress = silent) -> Dialogue[int]:
    """Put a list on the vehicle and see that it is there, item by item.

    Returns the id that it has there (PX4) or its checksum (ArduPilot); 0 where neither is known.

    Cancelled in mid-transfer, the vehicle keeps its old list where it can (PX4), else the new one is completed.

    Raises:
        MissionRefused, NoAnswer, TimeUp: with what the vehicle holds now as the hint.
        ReadBackDiffers, Replaced, Unsettled, Unflyable, Cancelled.
    """
    course = UploadState()
    try:
        try:
            yield from noting(_store(job, course, progress), course.reports.note)
        except Cancelled:
            yield from _give_in(job, course, progress)
    except TimeUp as late:
        yield Remark(Ack(Result.OPERATION_CANCELLED, job.kind))
        where = f"item {max(course.furthest, 0)} of {len(job.items)} of the {list_name(job.kind)}"
        raise TimeUp(f"{late}: attempt {course.attempt} had come to {where}", hint=_leftover(job)) from None
    if job.is_judged:
        try:
            state = yield from _verdict(course.reports)
        except (Cancelled, TimeUp) as broken_off:
            raise type(broken_off)(
                f"{broken_off}: the vehicle holds the whole new {list_name(job.kind)}, verified",
                hint="whether it finds it flyable was not waited for",
                holds="new",
            ) from None
        if not (state == NO_MISSION and course.reports.agrees(job)):
            yield from _settle(job, course.reports)
        if state == NO_MISSION:
            raise Unflyable(str(course.reports))
        return course.reports.stored_as if course.reports.proves(job) else 0
    return course.checksum


def _settle(job: Upload, reports: MissionReports) -> Dialogue[None]:
    """Read the list again until nothing that the vehicle says of it leaves a doubt."""
    if reports.proves(job):
        return
    for _ in range(READINGS):
        reports.read_again()
        yield from _expect_unchanged(job, reports)
        if reports.agrees(job):
            return
    raise KeepsChanging(job.kind)


def _expect_unchanged(job: Upload, reports: MissionReports) -> Dialogue[None]:
    try:
        stored = yield from noting(read_list(job.kind), reports.note)
    except (Cancelled, TimeUp, NoAnswer) as broken_off:
        words = f"{broken_off}: the vehicle may no longer hold the {list_name(job.kind)} that was sent"
        raise type(broken_off)(
            words, hint="it was verified, and not heard to speak of it since, or of another one", holds="unknown"
        ) from None
    if (difference := job.difference(stored)) is not None:
        raise Replaced(job.kind, difference)


def _give_in(job: Upload, course: UploadState, progress: Progress) -> Dialogue[None]:
    """Leave a whole list behind, the old or the new one, and say which."""
    name = list_name(job.kind)
    if job.truncates:
        course.attempt = 0
        yield from _store(job, course, progress)
        words = f"cancelled: the vehicle had already dropped its old {name}, so the new one was completed"
        raise Cancelled(words, hint="it is whole and verified; clear it if it must not be flown", holds="new")
    yield from _withdraw(job.kind)
    if course.may_be_whole and (yield from _holds(job)):
        words = f"cancelled too late: the vehicle holds the whole new {name}"
        raise Cancelled(words, hint="clear it if it must not be flown", holds="new")
    raise Cancelled(f"cancelled: the vehicle keeps the {name} it had", holds="old")


def _holds(job: Upload) -> Dialogue[bool]:
    try:
        stored = yield from read_list(job.kind)
    except (MissionRefused, NoAnswer):
        raise Cancelled(
            f"cancelled: the vehicle holds a whole {list_name(job.kind)}, the old or the new one, "
            "but does not answer when asked which",
            holds="either",
        ) from None
    return job.difference(stored) is None


def _store(job: Upload, course: UploadState, progress: Progress) -> Dialogue[None]:
    refused_before: MissionRefused | None = None

    def note(seq: int) -> None:
        course.furthest = max(course.furthest, seq)
        course.may_be_whole |= seq >= len(job.items) - 1
        count(progress, seq, len(job.items))

    while True:
        course.attempt += 1
        course.before, course.furthest = course.furthest, -1
        try:
            course.reports.offered()
            ending = yield from offer(job.items, job.kind, asked=note, packed=job.packed)
            course.reports.read()
            stored, course.checksum = yield from read_consistent(job.kind, job.numbers)
        except NoAnswer as silence:
            if course.attempt == ATTEMPTS or max(course.before, course.furthest) < 0:
                silence.hint = _leftover(job)
                raise
        except MissionRefused as refusal:
            again = _same(refusal, refused_before)
            settled = refusal.result not in PASSING and (not job.truncates or again)
            if course.attempt == ATTEMPTS or settled or (again and refusal.result == Result.ERROR):
                refusal.hint = _leftover(job)
                raise
            refused_before = refusal
            yield from wait(1.0)
        else:
            course.reports.was_read()
            difference = job.difference(stored)
            if difference is None:
                return
            if course.attempt >= 2 and ending in DOUBTFUL:
                raise MissionRefused(ending, job.kind, len(job.items) - 1)
            if course.attempt >= 2:
                raise ReadBackDiffers(job.kind, difference)


def _same(one: MissionRefused, other: MissionRefused | None) -> bool:
    return other is not None and (one.result, one.seq) == (other.result, other.seq)


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


def _verdict(reports: MissionReports) -> Dialogue[int]:
    """Listen whether the vehicle finds the mission flyable: the last state that it tells counts (0: none was told).

    Its reasons may have come at any time since the Ack. One that has given ours an id is given time to name it.
    """
    state, is_over = 0, reports.stored_as == 0
    heard = yield Pause(VERDICT_S)
    while True:
        if heard is None:
            if is_over or reports.is_named:
                return state
            is_over = True
            heard = yield Pause(VERDICT_S)
            continue
        step: Step = None
        reports.note(heard)
        match heard:
            case Current(mission_state=latest) if latest:
                if state != latest:
                    step = Pause(VERDICT_S if latest == NO_MISSION else SECOND_THOUGHTS_S)
                state = latest
        heard = yield step
