from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.link import conversations, mavftp
from ipoa_mission.link.conversations import list_name, share_words
from ipoa_mission.link.dialogue import (
    Cancelled,
    Dialogue,
    ListAboard,
    NoAnswer,
    Pause,
    SendOnce,
    Step,
    TimeUp,
    hear,
    wait,
)
from ipoa_mission.link.messages import WARNING, Ack, Current, Message, MissionState, MissionType, Request, Result
from ipoa_mission.link.vehicle_words import VehicleTexts
from ipoa_mission.link.wire import item_of, item_payload
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import Difference, compare, first_number
from ipoa_mission.progress import Progress, count, silent

ATTEMPTS = 12  # without any item: two
VERDICT_S = 1.5  # for PX4's check of a stored mission
REVISION_S = 0.4


class ReadBackDiffers(MissionError, code="read-back-differs"):
    def __init__(self, kind: int, difference: Difference) -> None:
        super().__init__(f"the {list_name(kind)} on the vehicle is not what was sent: {difference}")


class Replaced(MissionError, code="replaced"):
    def __init__(self, kind: int, difference: Difference) -> None:
        self.difference = difference
        super().__init__(
            f"the {list_name(kind)} on the vehicle is no longer what was sent: {difference}",
            hint="somebody else has replaced or cleared it",
        )


class Unflyable(MissionError, code="unflyable"):
    """`why`: in the vehicle's words."""

    def __init__(self, why: str) -> None:
        words = f"the vehicle stored the mission but refuses to fly it: {why or 'no reason was heard'}"
        hint = None if why else "wait until it has a position (GPS), and upload again"
        super().__init__(words, hint=hint, known={"list_on_vehicle": ListAboard.NEW})


@dataclass(frozen=True)
class Upload:
    """Hold a list in wire form; raise BadInput if MAVLink cannot carry it.

    `numbers`: for the checksum's questions. `version`: of the firmware, whose changes to items are allowed; None: any.
    """

    items: Sequence[Item]
    autopilot: Autopilot
    kind: int = MissionType.MISSION
    numbers: Iterator[int] | None = field(default=None, repr=False, compare=False)
    version: Version | None = None
    carried: list[Item] = field(init=False, repr=False, compare=False, default_factory=list)  # as MAVLink rounds them

    def __post_init__(self) -> None:
        if len(self.items) > 0xFFFF:
            raise BadInput(f"expected {0xFFFF} items at most, as many as MAVLink can count, not {len(self.items)}")
        for seq, item in enumerate(self.items):
            try:
                self.carried.append(item_of(item_payload(seq, item, self.kind)))
            except BadInput as error:
                raise error.at(f"item {seq + self.first}") from None

    @property
    def first(self) -> int:
        return first_number(self.items, self.autopilot)

    @property
    def truncates(self) -> bool:
        """Return whether a transfer's begin drops the old list."""
        return self.autopilot.protocol_profile.forgets_at_count and self.kind != MissionType.FENCE

    def difference(self, stored: Sequence[Item]) -> Difference | None:
        """Return the first difference of items; None if equal. ArduPilot may store its home for an empty list."""
        seq_offset = self.autopilot.seq_offset if self.kind == MissionType.MISSION else 0
        if not self.items and len(stored) <= seq_offset:
            return None
        return compare(self.carried, stored, self.autopilot, self.version)


@dataclass
class MissionReports(VehicleTexts):
    """PX4's reports of its stored mission: ids and number of items prove that no other station replaced it."""

    least_severity: int = WARNING
    stored_as: int = 0  # first id after our COUNT; 0: not reported
    is_disputed: bool = False  # a second id: one is another station's
    is_read: bool = False  # a mission stored from here on is not ours
    ids: frozenset[int] = frozenset()
    latest: int = 0
    total: int | None = None
    is_named: bool = False  # since the list was read whole

    def reset_at_offer(self) -> None:
        self.stored_as = 0
        self.is_disputed = False
        self.is_read = False

    def reset_at_reading(self) -> None:
        self.ids = frozenset()
        self.latest = 0
        self.total = None
        self.is_read = True

    def reset_ids(self) -> None:
        self.ids = frozenset({self.latest} - {0})
        self.total = None
        self.is_disputed = False
        self.is_named = False

    def note(self, message: Message | None) -> None:
        match message:
            case Ack(Result.ACCEPTED, MissionType.MISSION, number) if number:
                if not self.is_read:
                    self.stored_as = self.stored_as or number
                self.is_disputed |= number != self.stored_as
            case Current(total=total, mission_state=state, mission_id=number):
                if total or state == MissionState.NO_MISSION:
                    self.total = total
                self.ids |= {number} - {0}
                self.is_named |= number == self.stored_as != 0
                self.latest = number
        super().note(message)

    def reasons(self, job: Upload) -> str:
        """Leave out reasons against arming."""
        arming = job.autopilot.protocol_profile.arming_words
        return "; ".join(words for words in self.words if not arming.reasons(words))

    def proves(self, job: Upload) -> bool:
        """Return whether it named our list, and no other, since the read-back."""
        return self.is_named and self.ids == {self.stored_as} and not self._is_another(job)

    def agrees(self, job: Upload) -> bool:
        """Return whether reports since the read-back agree on one list of our length."""
        return len(self.ids) <= 1 and not self._is_another(job)

    def _is_another(self, job: Upload) -> bool:
        return self.is_disputed or self.total not in (None, len(job.items))


@dataclass
class UploadState:
    attempt: int = 0
    furthest: int = -1  # requested in this attempt
    may_be_whole: bool = False  # the vehicle may hold the whole list
    is_verified: bool = False  # the list was read back without a difference
    is_doubted: bool = False  # since then the vehicle may have received another list
    checksum: int = 0  # as read back; 0: none
    reports: MissionReports = field(default_factory=MissionReports)

    def aboard(self, job: Upload) -> ListAboard:
        if self.is_verified:
            return ListAboard.UNKNOWN if self.is_doubted else ListAboard.NEW
        if job.truncates and self.attempt > 0:
            return ListAboard.MIXTURE
        return ListAboard.EITHER if self.may_be_whole else ListAboard.OLD

    def explained(self, failed: MissionError, job: Upload) -> MissionError:
        """Return the error with what the vehicle holds of the list."""
        aboard = self.aboard(job)
        words = failed.args[0]
        if isinstance(failed, TimeUp):
            words += f": {share_words(max(self.furthest, 0), len(job.items), job.kind)} had been sent"
            words += f" in attempt {self.attempt}" if self.attempt > 0 else ""
        elif words == "cancelled" and aboard is ListAboard.NEW:
            words = "cancelled too late"
        is_as_before = isinstance(failed, Cancelled) and aboard is ListAboard.OLD
        explained = failed.at(hint=failed.hint or (None if is_as_before else aboard.remedy))
        explained.args = (f"{words}: {aboard.words(list_name(job.kind))}",)
        explained.known = failed.known | {"list_on_vehicle": aboard}
        return explained


def upload(
    job: Upload, progress: Progress = silent, state: UploadState | None = None, by_file: bool = False
) -> Dialogue[int]:
    """Store a list on the vehicle, verified; `by_file`: a mission as a file, if the vehicle takes one.

    Return the list's id (PX4) or checksum (ArduPilot), 0 if unknown. An error reports what the vehicle holds now, as
    does `state` at any time.
    """
    state = state or UploadState()
    try:
        if by_file and job.numbers is not None and job.kind == MissionType.MISSION:
            with suppress(mavftp.FileRefused, NoAnswer, ReadBackDiffers):  # the ordinary transfer finds the cause
                return (yield from upload_by_file(job, progress, state))
            state.furthest = -1
        return (yield from _upload_items(job, progress, state))
    except (Cancelled, TimeUp, NoAnswer, conversations.MissionRefused) as failed:
        raise state.explained(failed, job) from None


def _upload_items(job: Upload, progress: Progress, state: UploadState) -> Dialogue[int]:
    """Offer a list, read it back and compare, until they are equal; await PX4's verdict.

    When cancelled, PX4 keeps its old list; otherwise the new list is completed first.
    """
    try:
        try:
            yield from conversations.observed(_store(job, state, progress), state.reports.note)
        except Cancelled:
            yield from _cancel(job, state, progress)
            raise
    except TimeUp:
        yield SendOnce(Ack(Result.OPERATION_CANCELLED, job.kind))
        raise
    if job.autopilot.protocol_profile.judges_later and job.kind == MissionType.MISSION and job.items:
        try:
            verdict = yield from _verdict(job, state.reports, progress)
        except (Cancelled, TimeUp) as aborted:
            aborted.hint = "its check of the mission was not awaited"
            raise
        if not (verdict == MissionState.NO_MISSION and state.reports.agrees(job)):
            yield from _confirm_stored(job, state)
        if verdict == MissionState.NO_MISSION:
            raise Unflyable(state.reports.reasons(job))
        return state.reports.stored_as if state.reports.proves(job) else 0
    return state.checksum


def _confirm_stored(job: Upload, state: UploadState) -> Dialogue[None]:
    reports = state.reports
    if reports.proves(job):
        return
    state.is_doubted = True
    for _ in range(conversations.READ_ATTEMPTS):
        reports.reset_ids()
        stored = yield from conversations.observed(conversations.read_list(job.kind), reports.note)
        if (difference := job.difference(stored)) is not None:
            raise Replaced(job.kind, difference)
        if reports.agrees(job):
            state.is_doubted = False
            return
    raise conversations.KeepsChanging(job.kind)


def _cancel(job: Upload, state: UploadState, progress: Progress) -> Dialogue[None]:
    """Leave a whole list on the vehicle: the new one if the old one is dropped already."""
    if job.truncates:
        state.attempt = 0
        yield from _store(job, state, progress)
        return
    yield from _refuse_requests(job.kind)
    if state.may_be_whole:
        with suppress(conversations.MissionRefused, NoAnswer):
            stored = yield from conversations.read_list(job.kind)
            state.is_verified = job.difference(stored) is None
            state.may_be_whole = state.is_verified


def _store(job: Upload, state: UploadState, progress: Progress) -> Dialogue[None]:
    refused_before: tuple[int, int | None] | None = None
    # not of the items
    temporary = {*conversations.DOUBTFUL_REFUSALS, Result.DENIED, Result.OPERATION_CANCELLED}
    state.may_be_whole |= not job.items  # stored at COUNT

    def note(seq: int) -> None:
        state.furthest = max(state.furthest, seq)
        state.may_be_whole |= seq >= len(job.items) - 1
        count(progress, seq, len(job.items))

    while True:
        state.attempt += 1
        furthest_before = state.furthest
        state.furthest = -1
        was_whole = state.may_be_whole
        try:
            state.reports.reset_at_offer()
            result = yield from conversations.offer(job.items, job.kind, asked=note)
            state.reports.reset_at_reading()
            stored, state.checksum = yield from conversations.read_consistent(job.kind, job.numbers)
        except NoAnswer:
            if state.attempt == ATTEMPTS or max(furthest_before, state.furthest) < 0:
                raise
        except conversations.MissionRefused as refusal:
            is_repeated = (refusal.result, refusal.seq) == refused_before
            is_of_items = refusal.result not in temporary
            if is_of_items:
                state.may_be_whole = was_whole
            is_final = is_of_items and (not job.truncates or is_repeated)
            if state.attempt == ATTEMPTS or is_final or (is_repeated and refusal.result == Result.ERROR):
                words = refusal.words
                raise conversations.MissionRefused(refusal.result, job.kind, refusal.seq, words, job.first) from None
            refused_before = (refusal.result, refusal.seq)
            yield from wait(1.0)
        else:
            state.reports.is_named = False  # earlier reports prove nothing from here on
            difference = job.difference(stored)
            if difference is None:
                state.is_verified = True
                return
            if state.attempt >= 2 and result in conversations.DOUBTFUL_REFUSALS:
                raise conversations.MissionRefused(result, job.kind, len(job.items) - 1, first=job.first)
            if state.attempt >= 2:
                raise ReadBackDiffers(job.kind, difference)


def _refuse_requests(kind: int) -> Dialogue[None]:
    asks_on: bool | None = True
    while asks_on:
        yield SendOnce(Ack(Result.OPERATION_CANCELLED, kind))
        asks_on = yield from hear(Pause(1.0), lambda heard: isinstance(heard, Request) and heard.kind == kind)


def _verdict(job: Upload, reports: MissionReports, progress: Progress) -> Dialogue[int]:
    """Return PX4's last state (0: none). Wait until PX4 names our list, if it has an id, and judges it."""
    state = 0
    silences = 0
    heard = yield Pause(VERDICT_S)
    while True:
        step: Step = None
        if heard is None:
            is_judged = state != MissionState.NO_MISSION or bool(reports.reasons(job))
            is_named = reports.stored_as == 0 or reports.is_named
            if silences == 10 or (is_judged and (is_named or silences > 0)):
                return state
            if not is_judged:
                progress(1.0, "not judged yet: the vehicle needs its home and its fence")
            silences += 1
            step = Pause(VERDICT_S)
        else:
            reports.note(heard)
        match heard:
            case Current(mission_state=latest) if latest:
                if state != latest:
                    step = Pause(VERDICT_S if latest == MissionState.NO_MISSION else REVISION_S)
                state = latest
        heard = yield step


def upload_by_file(job: Upload, progress: Progress = silent, state: UploadState | None = None) -> Dialogue[int]:
    """Return the checksum of the file as read back. Raise FileRefused if the vehicle keeps its old mission."""
    state = state or UploadState()
    total = len(job.items)

    def note(share: float, words: str) -> None:
        state.furthest = int(total * share)
        count(progress, state.furthest, total)

    closing = yield from mavftp.write_file(mavftp.MISSION_FILE, mavftp.pack_mission(job.items, job.kind), note)
    state.may_be_whole = True  # before, an unclosed file is not taken
    try:
        return (yield from _close_file(job, closing))
    except Cancelled:
        with suppress(NoAnswer, TimeUp, ReadBackDiffers, conversations.KeepsChanging):
            try:
                yield from _close_file(job, closing)
                state.is_verified = True
            except mavftp.FileRefused:
                state.may_be_whole = False
        raise


def _close_file(job: Upload, closing: mavftp.FileMessage) -> Dialogue[int]:
    yield from mavftp.ask_of_file(closing, f"take {mavftp.MISSION_FILE}")
    for _ in range(conversations.READ_ATTEMPTS):
        data = yield from mavftp.read_file(mavftp.MISSION_FILE)
        difference = job.difference(mavftp.unpack_mission(data))
        if difference is not None:
            raise ReadBackDiffers(job.kind, difference)
        checksum = None if job.numbers is None else (yield from mavftp.list_checksum(job.kind, job.numbers))
        if checksum in (None, mavftp.file_checksum(data)):
            return checksum or 0
    raise conversations.KeepsChanging(job.kind)
