"""The mission service: `offer` and `fetch` are the two ends of a transfer."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial

from ipoa_mission.errors import MissionError
from ipoa_mission.link import messages as m
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, SendOnce, Step, T, Tell, TimeUp, hear
from ipoa_mission.link.mavftp import list_checksum
from ipoa_mission.link.vehicle_words import VehicleTexts
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, count, silent

#: After them a vehicle may still ask (docs/link.md).
DOUBTFUL_REFUSALS = frozenset({m.Result.ERROR, m.Result.INVALID_SEQUENCE})
#: Both firmwares repeat their request within a second [s].
REFUSAL_TIMEOUT_S = 3.0
#: For words that explain a refusal [s].
REASON_TIMEOUT_S = 0.3
READ_ATTEMPTS = 5


class MissionRefused(MissionError, code="mission-refused"):
    def __init__(self, result: int, kind: int, seq: int | None = None, words: str = "", first: int = 1) -> None:
        self.result = result
        self.seq = seq
        self.words = words
        name = m.Result(result).name if result in set(m.Result) else str(result)
        where = "" if seq is None else f" at item {seq + first}"
        where += f" with {name}" + (f": {words}" if words else "")
        super().__init__(f"the vehicle refused the {list_name(kind)}{where}")


def list_name(kind: int) -> str:
    return {0: "mission", 1: "fence", 2: "rally list"}.get(kind, "lists")


def share_words(done: int, total: int, kind: int) -> str:
    return f"{done} of {count_words(total)} of the {list_name(kind)}"


def observed(dialogue: Dialogue[T], note: Callable[[m.Message | None], object]) -> Dialogue[T]:
    move = partial(dialogue.send, None)
    while True:
        try:
            step = move()
        except StopIteration as stop:
            result: T = stop.value
            return result
        try:
            heard = yield step
        except MissionError as error:
            move = partial(dialogue.throw, error)
        else:
            note(heard)
            move = partial(dialogue.send, heard)


def offer(
    items: Sequence[Item],
    kind: int,
    opening: type[Ask] | type[Tell] = Ask,
    asked: Callable[[int], None] = lambda seq: None,
) -> Dialogue[int | None]:
    """Return ACCEPTED, or what followed the last item: None for silence, or a doubtful refusal.

    A client (`opening` Ask) ignores requests for earlier items: they are late duplicates. A vehicle (Tell) answers any.
    Raise MissionRefused, or NoAnswer before the last request. `asked` gets each requested number, and at the end the
    count.
    """
    in_order = opening is Ask
    at = -1  # the item requested last
    last = len(items) - 1
    doubt: int | None = None  # a refusal without a later request
    texts = VehicleTexts()
    step: Step = opening(m.Count(len(items), kind))
    while True:
        try:
            heard = yield step
        except NoAnswer as silence:
            if at == last and items:  # a client that sends no final Ack (MAVProxy)
                return doubt
            if doubt is not None:
                raise MissionRefused(doubt, kind, max(at, 0), str(texts)) from None
            raise NoAnswer(f"{silence} after {share_words(max(at, 0), len(items), kind)}") from None
        step = None
        match heard:
            case m.Request(seq, k) if k == kind and seq <= last and (not in_order or at <= seq <= at + 1):
                at = seq
                doubt = None
                asked(seq)
                step = Tell(m.ItemAt(seq, items[seq], kind))
                if in_order and seq == last:
                    yield SendOnce(step.message)
                    step = Pause(3.0)  # after it the read-back decides
            case m.Ack(m.Result.ACCEPTED, k) if k == kind:
                if at == last or not in_order:
                    asked(len(items))
                    return m.Result.ACCEPTED
            case m.Ack(m.Result.INVALID_SEQUENCE, k) if k == kind:
                doubt = m.Result.INVALID_SEQUENCE
            case m.Ack(m.Result.ERROR, k) if k == kind:
                doubt = m.Result.ERROR
                step = Pause(REFUSAL_TIMEOUT_S)
            case m.Ack(result, k) if k == kind:
                yield from listen_for_words(texts)
                raise MissionRefused(result, kind, max(at, 0), str(texts))
            case None if at == last and items:
                return doubt
            case None:
                raise MissionRefused(doubt or m.Result.ERROR, kind, max(at, 0), str(texts))
            case _:
                texts.note(heard)


def fetch(
    kind: int, total: int, take: Callable[[int, Item], int], first: int = 0, legacy: bool = False
) -> Dialogue[int]:
    """Take items from `first` on; return the first refusal. The caller sends the closing Ack.

    `legacy`: request by MISSION_REQUEST, and refuse other items, as ArduPilot does.
    """
    doubt: int | None = None
    for at in range(first, total):
        step: Step = Ask(m.Request(at, kind, legacy), item=True)
        while True:
            try:
                heard = yield step
            except NoAnswer as silence:
                if doubt is not None:
                    raise MissionRefused(doubt, kind, at) from None
                raise NoAnswer(f"{silence} after {share_words(at, total, kind)}") from None
            step = None
            match heard:
                case m.ItemAt(s, item, k) if k == kind and s == at:
                    result = take(s, item)
                    if result != m.Result.ACCEPTED:
                        return result
                    break
                case m.ItemAt(_, _, k) if k == kind and legacy:
                    yield SendOnce(m.Ack(m.Result.INVALID_SEQUENCE, kind))
                case m.Ack(result, k) if k == kind and result in DOUBTFUL_REFUSALS:
                    doubt = result
                case m.Ack(result, k) if k == kind and result != m.Result.ACCEPTED:
                    raise MissionRefused(result, kind, at)
    return m.Result.ACCEPTED


def read_list(kind: int, progress: Progress = silent) -> Dialogue[list[Item]]:
    """Return items; a transfer closed for silence (PX4: after 5 s) is opened again at the next item."""
    stored: list[Item] = []
    total = yield from open_list(kind)
    idle = 0

    def take(seq: int, item: Item) -> int:
        stored.append(item)
        count(progress, len(stored), total)
        return m.Result.ACCEPTED

    while True:
        before = len(stored)
        try:
            yield from fetch(kind, total, take, before)
        except TimeUp as late:
            raise TimeUp(f"{late}: {share_words(len(stored), total, kind)} had come") from None
        except NoAnswer as silence:
            idle = idle + 1 if len(stored) == before else 0
            if idle > 2:
                raise
            again = yield from open_list(kind, silence)
            if again != total:  # the list was replaced
                stored.clear()
            total = again
        else:
            yield SendOnce(m.Ack(m.Result.ACCEPTED, kind))
            return stored


def open_list(kind: int, silence: NoAnswer | None = None) -> Dialogue[int]:
    """Raise `silence` if nobody answers, and MissionRefused, as ArduPilot does while another station uploads."""
    try:
        return (yield from _answered(m.RequestList(kind)))
    except NoAnswer as still:
        raise silence or still from None


def clear(kind: int) -> Dialogue[None]:
    yield from _answered(m.ClearAll(kind))


def _answered(question: m.RequestList | m.ClearAll) -> Dialogue[int]:
    step: Step = Ask(question)
    texts = VehicleTexts()
    while True:
        heard = yield step
        step = None
        match heard:
            case m.Ack(result, question.kind) if result not in (m.Result.ACCEPTED, *DOUBTFUL_REFUSALS):
                yield from listen_for_words(texts)
                raise MissionRefused(result, question.kind, words=str(texts))
            case m.Ack(m.Result.ACCEPTED, question.kind) if isinstance(question, m.ClearAll):
                return 0
            case m.Count(total, question.kind) if isinstance(question, m.RequestList):
                return total
            case _:
                texts.note(heard)


def listen_for_words(texts: VehicleTexts) -> Dialogue[None]:
    yield from hear(Pause(REASON_TIMEOUT_S), texts.note)


class KeepsChanging(MissionError, code="keeps-changing"):
    def __init__(self, kind: int) -> None:
        super().__init__(
            f"the vehicle reports another {list_name(kind)} each time that its list is read",
            hint="check whether another station is uploading; upload again when it is done",
        )


def read_consistent(
    kind: int, numbers: Iterator[int] | None, progress: Progress = silent
) -> Dialogue[tuple[list[Item], int]]:
    """Return the list and its checksum (0: none), equal before and after the reading; raise KeepsChanging.

    Without `numbers` for the checksum, a change goes unnoticed.
    """
    before = None
    if numbers is not None:
        with suppress(NoAnswer):
            before = yield from list_checksum(kind, numbers)
    for _ in range(READ_ATTEMPTS):
        stored = yield from read_list(kind, progress)
        if before is None or numbers is None:
            return stored, 0
        after = yield from list_checksum(kind, numbers)
        if after == before:
            return stored, after
        before = after
    raise KeepsChanging(kind)


def download(
    kind: int, progress: Progress = silent, numbers: Iterator[int] | None = None
) -> Dialogue[tuple[Item, ...]]:
    stored, _ = yield from read_consistent(kind, numbers, progress)
    return tuple(stored)
