"""The mission service: `offer` and `fetch` are one transfer seen from its two ends, for the client and the mock alike.

An upload is the client offering and the vehicle fetching; a download is the reverse. What follows them are the
client's own conversations, made of the two.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TypeVar

from ipoa_mission.errors import MissionError
from ipoa_mission.link.dialogue import Ask, Dialogue, NoAnswer, Pause, Remark, Step, Tell, TimeUp
from ipoa_mission.link.events import words_of
from ipoa_mission.link.item_payloads import Payloads
from ipoa_mission.link.item_run import ItemsRead, ItemsSent
from ipoa_mission.link.messages import (
    INFO,
    Ack,
    ClearAll,
    Count,
    Event,
    ItemAt,
    Message,
    MissionType,
    Request,
    RequestList,
    Result,
    Text,
)
from ipoa_mission.mission.items import Item
from ipoa_mission.progress import Progress, count, silent

T = TypeVar("T")
Answer = TypeVar("Answer", Ack, Count)
Take = Callable[[int, ItemAt], int]

#: Refusals after which a vehicle may still go on asking: a second COUNT or a stray item gets ERROR from PX4,
#: a duplicate gets INVALID_SEQUENCE from ArduPilot, and neither ends the transfer.
DOUBTFUL = frozenset({Result.ERROR, Result.INVALID_SEQUENCE})
#: How long to wait for the next request after a doubtful refusal; both firmwares ask again every second or sooner.
GRACE_S = 3.0
#: How long the final Ack is waited for before the read-back settles it.
ENDING_S = 3.0
#: The words that explain a refusal come before it or just behind it.
WORDS_S = 0.3


class MissionRefused(MissionError):
    """The vehicle said no: `result` (a `Result`), the item that it refused, where known, and its words."""

    def __init__(self, result: int, kind: int, seq: int | None = None, words: str = "") -> None:
        self.result, self.kind, self.seq, self.words = result, kind, seq, words
        name = Result(result).name if result in set(Result) else str(result)
        where = "" if seq is None else f" at item {seq}"
        reason = f": {words}" if words else ""
        super().__init__(f"the vehicle refused the {list_name(kind)}{where} with {name}{reason}")


def list_name(kind: int) -> str:
    """How a human calls this list."""
    return {MissionType.MISSION: "mission", MissionType.FENCE: "fence", MissionType.RALLY: "rally points"}.get(
        MissionType(kind) if kind in set(MissionType) else MissionType.ALL, "lists"
    )


@dataclass
class VehicleTexts:
    """The vehicle's words during a conversation; texts less severe than `faintest` are let pass."""

    faintest: int = INFO
    words: list[str] = field(default_factory=list)

    def note(self, message: Message | None) -> None:
        """Keep what it says in words, or by the number of an event."""
        match message:
            case Text(severity, text) if severity <= self.faintest:
                words = text.rstrip("\t ")  # PX4 marks a text that an event repeats by a tab
            case Event(number, _, arguments):
                words = words_of(number, arguments) or ""
            case _:
                return
        if words and words not in self.words:
            self.words = [*self.words[-7:], words]

    def __str__(self) -> str:
        return "; ".join(self.words)


def noting(dialogue: Dialogue[T], note: Callable[[Message | None], object]) -> Dialogue[T]:
    """The same dialogue; `note` is told first what it hears, and what that raises breaks the dialogue off unheard."""
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
    packed: Payloads | None = None,
) -> Dialogue[int | None]:
    """Offer a list. Returns ACCEPTED, or what else followed the last item: None for silence, a doubtful refusal.

    With `opening` Ask we are the client: the vehicle pulls one item at a time, in order, so a request for an earlier
    item is a late duplicate and stays unanswered. With Tell we are the vehicle, and the client may ask for any item.
    `asked` is told of each item that is asked for, and at the end how many there are. `packed` are the items'
    payloads, where they have been made already.

    Raises:
        MissionRefused: a refusal that ended the transfer.
        NoAnswer: silence before the last item was asked for.
    """
    in_order = opening is Ask
    run = ItemsSent(kind, len(items), items=items, packed=packed, asked=asked)
    last = len(items) - 1
    texts = VehicleTexts()
    step: Step = opening(Count(len(items), kind))
    while True:
        try:
            heard = yield step
        except NoAnswer as silence:
            if run.at == last and items:  # a client that sends no final Ack (MAVProxy)
                return run.doubt
            if run.doubt is not None:
                raise MissionRefused(run.doubt, kind, max(run.at, 0), str(texts)) from None
            raise NoAnswer(f"{silence} after {max(run.at, 0)} of {len(items)} items of the {list_name(kind)}") from None
        step = None
        match heard:
            case Request(seq, k) if k == kind and seq <= last and (not in_order or run.at <= seq <= run.at + 1):
                run.asked_for(seq)
                step = Tell(ItemAt(seq, items[seq], kind), run if in_order else None)
                if in_order and seq == last:
                    yield Remark(step.message)
                    step = Pause(ENDING_S)
            case Ack(Result.ACCEPTED, k) if k == kind:
                if run.at == last or not in_order:
                    asked(len(items))
                    return Result.ACCEPTED
            case Ack(Result.INVALID_SEQUENCE, k) if k == kind:
                run.doubt = Result.INVALID_SEQUENCE
            case Ack(Result.ERROR, k) if k == kind:
                run.doubt = Result.ERROR
                step = Pause(GRACE_S)
            case Ack(result, k) if k == kind:
                yield from listen_for_words(texts)
                raise MissionRefused(result, kind, max(run.at, 0), str(texts))
            case None if run.at == last and items:
                return run.doubt
            case None:  # the grace is over, and no request came
                raise MissionRefused(run.doubt or Result.ERROR, kind, max(run.at, 0), str(texts))
            case _:
                texts.note(heard)


@dataclass(frozen=True)
class RequestStyle:
    """How one fetches: by the old MISSION_REQUEST, and whether a stray item is rebuked with INVALID_SEQUENCE."""

    legacy: bool = False
    rebukes: bool = False


BY_REQUEST_INT = RequestStyle()


def fetch(
    count: int, kind: int, take: Take, style: RequestStyle = BY_REQUEST_INT, run: ItemsRead | None = None
) -> Dialogue[int]:
    """Fetch the items from `run.at` (else 0) to `count` - 1 in order and hand each to `take`.

    Returns ACCEPTED, or the first other result of `take`, which ends it. With a `run` items may be read without a look
    at the dialogue: they are handed to `run.keep`.

    Saying the closing Ack is left to the caller, who may want to judge the whole list first.

    Raises:
        MissionRefused: the other side broke it off.
        NoAnswer: silence.
    """
    doubt: int | None = None
    here = run or ItemsRead(kind, count, at=0)
    while here.at < count:
        step: Step = Ask(Request(here.at, kind, style.legacy), item=True, run=run)
        while True:
            try:
                heard = yield step
            except NoAnswer as silence:
                if doubt is not None:
                    raise MissionRefused(doubt, kind, here.at) from None
                raise NoAnswer(f"{silence} after {here.at} of {count} items of the {list_name(kind)}") from None
            step = None
            match heard:
                case ItemAt(s, _, k) as item if k == kind and s == here.at:
                    result = take(s, item)
                    if result != Result.ACCEPTED:
                        return result
                    break
                case ItemAt(_, _, k) if k == kind and style.rebukes:
                    yield Remark(Ack(Result.INVALID_SEQUENCE, kind))
                case Ack(result, k) if k == kind and result in DOUBTFUL:
                    doubt = result
                case Ack(result, k) if k == kind and result != Result.ACCEPTED:
                    raise MissionRefused(result, kind, here.at)
        here.at += 1
    return Result.ACCEPTED


def read_list(kind: int, progress: Progress = silent) -> Dialogue[list[Item | bytes]]:
    """Read the list that the vehicle holds: each item, or the payload it came in.

    A vehicle closes a list that nothing is heard about for some seconds (PX4: five): it is then opened again, and the
    reading goes on where it stopped.

    Raises:
        MissionRefused, NoAnswer.
    """
    stored: list[Item | bytes] = []
    total = yield from open_list(kind)
    idle = 0

    def keep(one: Item | bytes) -> None:
        stored.append(one)
        count(progress, len(stored), total)

    def take(seq: int, heard: ItemAt) -> int:
        keep(heard.item)
        return Result.ACCEPTED

    while True:
        before = len(stored)
        try:
            yield from fetch(total, kind, take, run=ItemsRead(kind, total, at=before, keep=keep))
        except TimeUp as late:
            raise TimeUp(f"{late}: {len(stored)} of {total} items of the {list_name(kind)} had come") from None
        except NoAnswer as silence:
            idle = idle + 1 if len(stored) == before else 0
            if idle > 2:
                raise
            again = yield from open_list(kind, silence)
            if again != total:  # another list has come in between
                stored.clear()
            total = again
        else:
            yield Remark(Ack(Result.ACCEPTED, kind))
            return stored


def open_list(kind: int, silence: NoAnswer | None = None) -> Dialogue[int]:
    """Ask how long the list is; `silence` is what there was to say if nobody answers.

    Raises:
        MissionRefused: among others, while somebody sends the vehicle another (ArduPilot).
        NoAnswer.
    """
    try:
        answer = yield from _answered(RequestList(kind), Count)
    except NoAnswer as still:
        raise silence or still from None
    return answer.count


def clear(kind: int) -> Dialogue[None]:
    """Have the vehicle forget a list.

    Raises:
        MissionRefused, NoAnswer.
    """
    yield from _answered(ClearAll(kind), Ack)


def _answered(question: RequestList | ClearAll, answer: type[Answer]) -> Dialogue[Answer]:
    """Ask about a list until such an answer to it comes, or a refusal."""
    step: Step = Ask(question)
    texts = VehicleTexts()
    while True:
        heard = yield step
        step = None
        match heard:
            case Ack(result, question.kind) if result not in (Result.ACCEPTED, *DOUBTFUL):
                yield from listen_for_words(texts)
                raise MissionRefused(result, question.kind, words=str(texts))
            case Ack(Result.ACCEPTED, question.kind) | Count(_, question.kind) if isinstance(heard, answer):
                return heard
            case _:
                texts.note(heard)


def listen_for_words(texts: VehicleTexts) -> Dialogue[None]:
    """Note what the vehicle says in a moment: why it refused."""
    heard: Message | None = yield Pause(WORDS_S)
    while heard is not None:
        texts.note(heard)
        heard = yield None
