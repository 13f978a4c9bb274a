"""A conversation is a generator; `Exchange` gives it a clock.

A dialogue yields what it wants to say and is sent what it hears, so its code reads like the sequence diagram:

    heard = yield Ask(Count(3))      # said again until something is heard that the dialogue acts upon
    heard = yield Tell(item)         # said once: it is the other side's turn to ask again
    heard = yield Pause(2.0)         # nothing is said; `None` is heard when the time is up
    yield Remark(Ack(...))           # said by the way; goes on at once, and what was awaited stays awaited
    heard = yield None               # that was not for us: keep listening as before

What ends an `Exchange` is the dialogue: it returns, or raises. When the other side stays silent, `NoAnswer` is thrown
into it at the place where it waits, so a dialogue can try another way.
"""

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Generic, Literal, TypeAlias, TypeVar

from ipoa_mission.errors import MissionError
from ipoa_mission.link.item_run import ItemRun, ItemsRead, ItemsSent
from ipoa_mission.link.messages import Ack, CommandAck, Count, FileTransfer, ItemAt, Message, Request

T = TypeVar("T")
#: What is said only in answer to something; the rest is also sent unasked.
ANSWERS = (Ack, CommandAck, Count, FileTransfer, ItemAt, Request)


class Unfinished(MissionError):
    """A dialogue came to no end; `holds` is the list that the vehicle holds now, where something is known of it."""

    def __init__(
        self,
        message: str,
        hint: str | None = None,
        *,
        code: str | None = None,
        place: object = None,
        holds: Literal["old", "new", "either", "unknown"] | None = None,
    ) -> None:
        super().__init__(message, hint, code=code, place=place)
        self.holds = holds
        if holds is not None:
            self.known["holds"] = holds


class NoAnswer(Unfinished):
    """The other side said nothing for as long as our patience lasts."""


class Silence(MissionError):
    """The other side, which speaks unasked, has said nothing for a while: who speaks next may be somebody else."""


class Cancelled(Unfinished):
    """The user took it back; the message says what the vehicle holds now."""


class TimeUp(Unfinished):
    """What was to be done took longer than the user allows."""


@dataclass(frozen=True)
class Ask:
    """Say this, again and again, until an answer comes; `item`: one of many, for which the shorter timer holds.

    `run`: the items that may be read before the dialogue looks again.
    """

    message: Message
    item: bool = False
    run: ItemsRead | None = None


@dataclass(frozen=True)
class Tell:
    """Say this once and wait for what the other side makes of it; `run`: what may be said before the dialogue looks."""

    message: Message
    run: ItemsSent | None = None


@dataclass(frozen=True)
class Remark:
    """Say this by the way."""

    message: Message


@dataclass(frozen=True)
class Pause:
    """Listen for so many seconds."""

    seconds: float


Step: TypeAlias = Ask | Tell | Remark | Pause | None
Dialogue: TypeAlias = Generator[Step, Message | None, T]


def until(condition: Callable[[], bool], seconds: float) -> Dialogue[bool]:
    """Listen until it holds, for so many seconds at most; whether it does."""
    if condition():
        return True
    heard = yield Pause(seconds)
    while heard is not None:
        if condition():
            return True
        heard = yield None
    return condition()


def wait(seconds: float) -> Dialogue[None]:
    """Listen for so many seconds, whatever is heard."""
    heard = yield Pause(seconds)
    while heard is not None:
        heard = yield None


@dataclass(frozen=True)
class Patience:
    """When to repeat, and when to give up: MAVLink's own timers by default.

    A question is repeated after `answer_s` (an item of a list: `item_s`), or, with `adapt`, after the measured round
    trip and four times its spread. A silent link is given up after `retries` of `answer_s`; one on which the other side
    is heard at all, after `alive_retries` repeats, but no sooner than a silent one: losing a third of the packets is no
    reason to give up, nor is an autopilot that is busy for some seconds. For an item of a list `item_retries` will do:
    the other side may have closed the list, which is then opened again. `total_s` is the most that one verb of the
    client (an upload with its fence and rally points, a download) may take in all.
    """

    answer_s: float = 1.5
    item_s: float = 0.25
    retries: int = 5
    alive_retries: int = 20
    item_retries: int = 8
    adapt: bool = True
    echo_s: float = 0.1  # the same question heard twice within this time, at least, is a duplicate of the network
    total_s: float = 3600.0

    @property
    def silence_s(self) -> float:
        """How long nothing at all may be heard."""
        return self.answer_s * (self.retries + 1)


SPECIFIED = Patience()


class Tempo:
    """The round trip of a link as measured so far: RFC 6298's mean and deviation with Karn's rule.

    Less patient than TCP on purpose: a question that was asked once too often costs a frame, one too late a second.
    """

    FASTEST_S = 0.05
    SLOWEST_S = 6.0
    LONGEST_BACKOFF = 1.5
    #: A lost packet is no sign of a slow link, but so many questions in a row that had to be repeated are.
    DOUBTS = 5

    def __init__(self, patience: Patience) -> None:
        self._patience = patience
        self._shortest = 0.0
        self._loses = False
        self._mean: float | None = None
        self._spread = 0.0
        self._backoff = 1.0
        self._doubts = 0

    def wait_s(self, item: bool) -> float:
        """How long to wait for an answer before asking again."""
        usual = self._patience.item_s if item else self._patience.answer_s
        if not self._patience.adapt:
            return usual
        if self._mean is not None:
            usual = max(self._mean + 4 * self._spread, self.FASTEST_S)
        return min(usual * self._backoff, self.SLOWEST_S)

    def sample(self, seconds: float) -> None:
        """An answer came this long after a question that was asked once."""
        self._backoff = 1.0
        self._doubts = 0
        if self._mean is None:
            self._mean, self._spread, self._shortest = seconds, seconds / 4, seconds
        else:
            self._shortest = min(seconds, self._shortest)
            self._spread += (abs(seconds - self._mean) - self._spread) / 4
            self._mean += (seconds - self._mean) / 8

    @property
    def echo_s(self) -> float:
        """A question that is heard again within this time of its answer was asked before the answer was there.

        PX4 asks every 0.25 s, so over a slower link it asks for each item twice or more. On a link that has lost
        something already, answering each of them is worth its bytes.
        """
        if self._loses or not self._patience.adapt:
            return self._patience.echo_s
        return max(self._patience.echo_s, self._shortest)

    def lost(self) -> None:
        """An answer of ours has not arrived: the question came again when it should have been there."""
        self._loses = True

    def doubt(self) -> None:
        """An answer came to a question that was asked more than once: to which saying, nobody knows."""
        self._doubts += 1

    def repeated(self) -> None:
        """A question went unanswered: the link is lossy (wait a little longer), or slow (wait much longer)."""
        self._backoff = min(self._backoff * 1.5, self.LONGEST_BACKOFF if self._doubts < self.DOUBTS else 16.0)


class Exchange(Generic[T]):
    """One dialogue under way: hand it what is heard and the time, send what it says."""

    def __init__(self, dialogue: Dialogue[T], now: float, patience: Patience, tempo: Tempo | None = None) -> None:
        self.finished = False
        self.was_answered = False
        self._dialogue = dialogue
        self._patience = patience
        self._tempo = tempo or Tempo(patience)
        self._outbox: list[Message] = []
        self._awaited: Ask | Tell | Pause = Pause(math.inf)
        self._since = self._said = self._heard = now
        self._repeats = 0
        self._ran_from = -1
        self._acted_on: tuple[Message | None, float] = (None, -math.inf)
        self._result: T | None = None
        self._follow(self._resume(None), now)

    @property
    def result(self) -> T:
        """What the dialogue returned."""
        if not self.finished:
            raise RuntimeError("the dialogue is still under way")
        return self._result  # type: ignore[return-value]

    @property
    def deadline(self) -> float:
        """When `tick` is next needed."""
        if self.finished:
            return math.inf
        if isinstance(self._awaited, Ask):
            return self._said + self._wait_s
        if isinstance(self._awaited, Tell):
            return self._since + self._patience.silence_s
        return self._since + self._awaited.seconds

    def asked_for_s(self, now: float) -> float:
        """How long what was said has been waiting for its answer."""
        return 0.0 if self.finished or isinstance(self._awaited, Pause) else now - self._since

    def run(self) -> ItemRun | None:
        """The items that may go on by themselves from here; whoever lets them tells so (`ran`)."""
        if self.finished or self._repeats or isinstance(self._awaited, Pause) or self._awaited.run is None:
            return None
        run = self._awaited.run
        if run.is_ending:
            return None
        run.said_s = self._said
        run.wait_s = self._wait_s if isinstance(self._awaited, Ask) else self._patience.silence_s
        self._ran_from = run.at
        return run

    def ran(self, run: ItemRun, now: float) -> None:
        """Items have gone on to `run.at`: what was said and heard last was said and heard here."""
        if run.at == self._ran_from:
            return
        self._heard = now
        self._since = self._said = run.said_s
        if isinstance(run, ItemsRead):
            self._awaited = Ask(run.question, item=True, run=run)
            self._acted_on = (None, now)
            self._tempo.sample(run.round_trip_s)
        else:
            self._acted_on = (run.acted_on, run.said_s)

    def outgoing(self) -> list[Message]:
        """What is to be said now; each message once."""
        messages, self._outbox = self._outbox, []
        return messages

    def receive(self, message: Message, now: float) -> None:
        """The other side has said something (whatever it is)."""
        if self.finished:
            return
        self._heard = now
        last, when = self._acted_on
        if message == last and now - when < self._tempo.echo_s:
            return
        step = self._resume(message)
        if step is None and not self.finished:
            return
        self.was_answered |= isinstance(message, ANSWERS) and not isinstance(self._awaited, Pause)
        if isinstance(self._awaited, Ask):
            if self._repeats == 0:
                self._tempo.sample(now - self._said)
            else:
                self._tempo.doubt()
        elif message == last:
            self._tempo.lost()
        self._acted_on = (message, now)
        self._follow(step, now)

    def tick(self, now: float) -> None:
        """Time has passed."""
        if now < self.deadline:
            return
        match self._awaited:
            case Pause():
                self._follow(self._resume(None), now)
            case Ask(message, item) if not self._is_hopeless(item, now):
                self._repeats += 1
                self._tempo.repeated()
                self._say(message, now)
            case _:
                self.interrupt(NoAnswer("the vehicle does not answer"), now)

    def interrupt(self, error: MissionError, now: float) -> None:
        """Raise an error in the dialogue, where it waits."""
        if self.finished:
            return
        try:
            step = self._dialogue.throw(error)
        except StopIteration as stop:
            self._finish(stop.value)
        else:
            self._follow(step, now)

    def _is_hopeless(self, item: bool, now: float) -> bool:
        patience = self._patience
        if self._repeats < patience.retries:
            return False
        if now - self._heard >= patience.silence_s:
            return True
        if item:
            return self._repeats >= patience.item_retries
        return self._repeats >= patience.alive_retries and now - self._since >= patience.silence_s

    def _resume(self, message: Message | None) -> Step:
        try:
            return self._dialogue.send(message)
        except StopIteration as stop:
            self._finish(stop.value)
            return None

    def _follow(self, step: Step, now: float) -> None:
        while isinstance(step, Remark):
            self._outbox.append(step.message)
            step = self._resume(None)
        if step is None or self.finished:
            return
        self._awaited = step
        self._since = now
        self._repeats = 0
        if isinstance(step, Ask):
            self._acted_on = (None, now)  # what answers a new question is no echo, even in the same words
        if not isinstance(step, Pause):
            self._say(step.message, now)

    def _say(self, message: Message, now: float) -> None:
        self._said = now
        self._wait_s = self._tempo.wait_s(isinstance(self._awaited, Ask) and self._awaited.item)
        if self._repeats >= self._patience.alive_retries:  # so many at the link's pace are no use
            self._wait_s = max(self._wait_s, self._patience.answer_s)
        self._outbox.append(message)

    def _finish(self, result: T) -> None:
        self.finished = True
        self._result = result
