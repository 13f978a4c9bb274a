"""Dialogues are generators; `Exchange` runs one against a clock.

A dialogue yields a step and is sent a heard message:

    heard = yield Ask(Count(3))      # sent repeatedly until the dialogue acts on an answer
    heard = yield Tell(item)         # sent once: repeating is up to the other side
    heard = yield Pause(2.0)         # nothing is sent; returns `None` at the timeout
    yield SendOnce(Ack(...))         # sent once; returns at once, and the earlier wait continues
    heard = yield None               # the message was irrelevant: continue the earlier wait

If the other side stays silent, `NoAnswer` is raised in the dialogue.
"""

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeAlias, TypeVar

from ipoa_mission.errors import MissionError
from ipoa_mission.link.messages import Ack, CommandAck, Count, FileTransfer, ItemAt, Message, Request

Answer = TypeVar("Answer")
T = TypeVar("T")


class ListAboard(StrEnum):
    """State of a list on the vehicle after an upload that failed."""

    OLD = "old"
    NEW = "new"
    EITHER = "either"  # whole
    MIXTURE = "mixture"  # perhaps
    UNKNOWN = "unknown"

    def words(self, name: str) -> str:
        return {
            ListAboard.OLD: f"the vehicle keeps the {name} it had",
            ListAboard.NEW: f"the vehicle holds the whole new {name}",
            ListAboard.EITHER: f"the vehicle holds a whole {name}, the old or the new one",
            ListAboard.MIXTURE: f"the {name} on the vehicle may be a mixture of new and old",
            ListAboard.UNKNOWN: f"the vehicle may no longer hold the {name} that was sent",
        }[self]

    @property
    def remedy(self) -> str:
        if self is ListAboard.NEW:
            return "clear it if it must not be flown"
        return "upload again, or clear it" if self is ListAboard.MIXTURE else "upload again"


class NoAnswer(MissionError, code="no-answer"):
    """The other side stayed silent."""


class Silence(MissionError, code="silence"):
    """A vehicle that sends unasked is silent."""


class Cancelled(MissionError, code="cancelled"):
    """Ctrl-C."""


class TimeUp(MissionError, code="time-up"):
    """The user's time limit is over."""


@dataclass(frozen=True)
class Ask:
    """`item`: by the shorter timer."""

    message: Message
    item: bool = False


@dataclass(frozen=True)
class Tell:
    message: Message


@dataclass(frozen=True)
class SendOnce:
    message: Message


@dataclass(frozen=True)
class Pause:
    seconds: float


Step: TypeAlias = Ask | Tell | SendOnce | Pause | None
Dialogue: TypeAlias = Generator[Step, Message | None, T]


def hear(step: Ask | Pause, accept: Callable[[Message], Answer | None]) -> Dialogue[Answer | None]:
    """Return the first true value of `accept`, None at the end of a pause; raise NoAnswer."""
    heard = yield step
    while heard is not None:
        accepted = accept(heard)
        if accepted:
            return accepted
        heard = yield None
    return None


def until(condition: Callable[[], bool], seconds: float) -> Dialogue[bool]:
    """Return whether the condition came true in time."""
    if not condition():
        yield from hear(Pause(seconds), lambda heard: condition())
    return condition()


def wait(seconds: float) -> Dialogue[None]:
    yield from until(lambda: False, seconds)


@dataclass(frozen=True)
class RetryPolicy:
    """Timers of repeats and of giving up; the defaults are MAVLink's.

    With `adapt` a question is repeated after the measured round trip plus four deviations. A silent link is given up
    after `retries`, one with traffic after `alive_retries`. After `item_retries` the list is opened again.
    """

    answer_s: float = 1.5
    item_s: float = 0.25
    retries: int = 5
    alive_retries: int = 20
    item_retries: int = 8
    adapt: bool = True
    echo_s: float = 0.1  # sooner: duplicates of the network
    total_s: float = 3600.0

    @property
    def silence_s(self) -> float:
        return self.answer_s * (self.retries + 1)


SPECIFIED = RetryPolicy()


class RoundTrip:
    """A link's round trip by RFC 6298 with Karn's rule, with shorter waits than TCP's."""

    FASTEST_S = 0.05
    SLOWEST_S = 6.0
    LONGEST_BACKOFF = 1.5
    SLOW_LINK_REPEATS = 5  # in a row: a slow link, not a lossy one

    def __init__(self, policy: RetryPolicy) -> None:
        self.policy = policy
        self.loses = False  # a repeat was too late for an echo
        self.doubts = 0  # answers to repeated questions since the last round trip
        self._mean: float | None = None
        self._shortest = self._variation = 0.0
        self._backoff = 1.0

    def wait_s(self, item: bool) -> float:
        wait = self.policy.item_s if item else self.policy.answer_s
        if not self.policy.adapt:
            return wait
        if self._mean is not None:
            wait = max(self._mean + 4 * self._variation, self.FASTEST_S)
        return min(wait * self._backoff, self.SLOWEST_S)

    def sample(self, seconds: float) -> None:
        self._backoff = 1.0
        self.doubts = 0
        if self._mean is None:
            self._mean = seconds
            self._variation = seconds / 4
            self._shortest = seconds
        else:
            self._shortest = min(seconds, self._shortest)
            self._variation += (abs(seconds - self._mean) - self._variation) / 4
            self._mean += (seconds - self._mean) / 8

    @property
    def echo_s(self) -> float:
        """Return the time within which a repeated question crossed its answer [s].

        PX4 repeats each question over a slow link. After a loss each repeat is answered.
        """
        if self.loses or not self.policy.adapt:
            return self.policy.echo_s
        return max(self.policy.echo_s, self._shortest)

    def repeated(self) -> None:
        """Back off a little on a lossy link, more on a slow one."""
        longest = self.LONGEST_BACKOFF if self.doubts < self.SLOW_LINK_REPEATS else 16.0
        self._backoff = min(self._backoff * 1.5, longest)


class Exchange(Generic[T]):
    """Run a dialogue against a clock: `receive` messages, `tick` at the `deadline`, send the `outgoing` ones."""

    ANSWERS = (Ack, CommandAck, Count, FileTransfer, ItemAt, Request)

    def __init__(self, dialogue: Dialogue[T], now: float, policy: RetryPolicy, rtt: RoundTrip | None = None) -> None:
        self.finished = False
        self.was_answered = False
        self._dialogue = dialogue
        self._policy = policy
        self._rtt = rtt or RoundTrip(policy)
        self._outbox: list[Message] = []
        self._awaited: Ask | Tell | Pause = Pause(math.inf)
        self._since = self._sent = self.heard_s = now
        self._wait_s = math.inf  # for an answer, from `_sent`
        self._repeats = 0
        self._acted_on: tuple[Message | None, float] = (None, -math.inf)
        self._result: T | None = None
        self._follow(self._resume(None), now)

    @property
    def result(self) -> T:
        if not self.finished:
            raise RuntimeError("the dialogue is still under way")
        return self._result  # type: ignore[return-value]

    @property
    def deadline(self) -> float:
        if self.finished:
            return math.inf
        if isinstance(self._awaited, Ask):
            return self._sent + self._wait_s
        if isinstance(self._awaited, Tell):
            return self._since + self._policy.silence_s
        return self._since + self._awaited.seconds

    def asked_for_s(self, now: float) -> float:
        return 0.0 if self.finished or isinstance(self._awaited, Pause) else now - self._since

    def outgoing(self) -> list[Message]:
        messages = self._outbox
        self._outbox = []
        return messages

    def receive(self, message: Message, now: float) -> None:
        if self.finished:
            return
        self.heard_s = now
        last, when = self._acted_on
        if message == last and now - when < self._rtt.echo_s:
            return
        step = self._resume(message)
        if step is None and not self.finished:
            return
        self.was_answered |= isinstance(message, self.ANSWERS) and not isinstance(self._awaited, Pause)
        if isinstance(self._awaited, Ask):
            if self._repeats == 0:
                self._rtt.sample(now - self._sent)
            else:
                self._rtt.doubts += 1
        elif message == last:
            self._rtt.loses = True
        self._acted_on = (message, now)
        self._follow(step, now)

    def tick(self, now: float) -> None:
        if now < self.deadline:
            return
        match self._awaited:
            case Pause():
                self._follow(self._resume(None), now)
            case Ask(message, item) if not self._is_hopeless(item, now):
                self._repeats += 1
                self._rtt.repeated()
                self._send(message, now)
            case _:
                self.interrupt(NoAnswer("the vehicle does not answer"), now)

    def interrupt(self, error: MissionError, now: float) -> None:
        if self.finished:
            return
        self._follow(self._move(lambda: self._dialogue.throw(error)), now)

    def _is_hopeless(self, item: bool, now: float) -> bool:
        policy = self._policy
        if self._repeats < policy.retries:
            return False
        if now - self.heard_s >= policy.silence_s:
            return True
        if item:
            return self._repeats >= policy.item_retries
        return self._repeats >= policy.alive_retries and now - self._since >= policy.silence_s

    def _resume(self, message: Message | None) -> Step:
        return self._move(lambda: self._dialogue.send(message))

    def _move(self, move: Callable[[], Step]) -> Step:
        try:
            return move()
        except StopIteration as stop:
            self.finished = True
            self._result = stop.value
            return None

    def _follow(self, step: Step, now: float) -> None:
        while isinstance(step, SendOnce):
            self._outbox.append(step.message)
            step = self._resume(None)
        if step is None or self.finished:
            return
        self._awaited = step
        self._since = now
        self._repeats = 0
        if isinstance(step, Ask):
            self._acted_on = (None, now)  # no echo, even with equal content
        if not isinstance(step, Pause):
            self._send(step.message, now)

    def _send(self, message: Message, now: float) -> None:
        self._sent = now
        self._wait_s = self._rtt.wait_s(isinstance(self._awaited, Ask) and self._awaited.item)
        if self._repeats >= self._policy.alive_retries:
            self._wait_s = max(self._wait_s, self._policy.answer_s)
        self._outbox.append(message)
