"""Reconnect in flight, and identify the vehicle before anything is sent to it."""

import logging
import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.errors import MissionError
from ipoa_mission.interrupts import Interrupt, noted_interrupts
from ipoa_mission.link import orders
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.codec import Heard, Target
from ipoa_mission.link.connection import NOTICE_S, Listening, MessageLink, run_dialogue
from ipoa_mission.link.conversations import observed
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, RetryPolicy, RoundTrip, Silence, TimeUp, until
from ipoa_mission.link.discovery import autopilots_in
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, AutopilotVersion, Current, Heartbeat, Message, Position
from ipoa_mission.link.onboard_list import OnboardList, prove
from ipoa_mission.link.upload import Replaced
from ipoa_mission.link.vehicle_state import NotReady, VehicleState

log = logging.getLogger(__name__)
SILENT_S = 3.0  # counts as a link loss
GIVE_UP_S = 300.0
RETRY_S = 1.0


class NotTheSameVehicle(MissionError, code="not-the-same-vehicle"):
    def __init__(self, system: int, lost_s: float, why: str) -> None:
        super().__init__(f"after {lost_s:.0f} s vehicle {system} is heard again, but {why}: nothing is sent to it")


class IdentityChanged(MissionError, code="identity-changed"):
    """It is another vehicle, or has changed; with the evidence."""


@dataclass(frozen=True)
class KnownVehicle:
    system: int
    state: VehicleState
    clock_s: float
    about: AutopilotVersion | None
    onboard: OnboardList | None
    retry_policy: RetryPolicy


@dataclass
class LinkLoss:
    """`seconds`: its duration so far, None without a loss. `meanwhile`: what the vehicle does alone."""

    connection: MessageLink
    seconds: float | None = None
    words: str = ""
    meanwhile: str = ""
    _is_open: bool = True
    _since_s: float = 0.0
    _ends_s: float = 0.0
    _reported_s: float = 0.0
    _reopens_s: float = 0.0
    _why: str = ""
    _others: str = ""

    def end(
        self, lost: MissionError, known: KnownVehicle, report: Callable[[str], None], until_s: float = math.inf
    ) -> list[Message]:
        """Wait until the vehicle is identified; return its messages until then. Call `report` every second.

        Raise LinkDown (no link), NotTheSameVehicle, OtherKind, NoAnswer (after `GIVE_UP_S`) or TimeUp (at `until_s`).
        """
        self._is_open = not isinstance(lost, LinkDown)
        if not (self._is_open or self.connection.reopens):
            raise lost
        self._reopens_s = self.connection.now()
        self._since_s = self._reopens_s - (SILENT_S if self._is_open else 0.0)
        self._ends_s = min(self._since_s + GIVE_UP_S, until_s)
        self._reported_s = -RETRY_S
        self._why = "" if self._is_open else str(lost)
        self._others = ""
        self._report_loss(report)
        log.warning("%s; listening for %g s", self.words, GIVE_UP_S)
        try:
            with noted_interrupts() as interrupt:
                messages = self._identified(known, interrupt, report)
                while messages is None:
                    if self.connection.now() >= until_s:
                        raise TimeUp("the time is up")
                    if self._is_over:
                        words = _with(f"the link is lost for {GIVE_UP_S:g} s: ", self._why, self._others)
                        raise NoAnswer(words, code="link-lost")
                    messages = self._identified(known, interrupt, report)
            words = "it is the same vehicle" + (", with the mission that was uploaded" if known.onboard else "")
            log.warning("the link is back after %.0f s: %s", self.connection.now() - self._since_s, words)
            return messages
        finally:
            self.seconds = None
            self.words = ""

    def _identified(
        self, known: KnownVehicle, interrupt: Interrupt, report: Callable[[str], None]
    ) -> list[Message] | None:
        """Return its messages, None without an answer; raise NotTheSameVehicle."""
        candidate = VehicleState(known.state.autopilot, known.state.kind)
        messages = list[Message]()

        def note(message: Message) -> None:
            candidate.note(message)
            messages.append(message)
            self._report_loss(report)

        target = Target(known.system, AUTOPILOT_COMPONENT)
        try:
            while Heartbeat not in candidate.heard:
                if self._is_over:
                    return None
                self._report_loss(report)
                if interrupt.take():
                    raise Cancelled("cancelled")
                for heard in self._receive():
                    if heard.message is not None and (heard.system, heard.component) == target:
                        note(heard.message)
                    elif autopilots_in([heard]):
                        self._others = f"vehicle {heard.system} is heard; nothing is sent to it"
            dialogue = observed(recognize(candidate, known), lambda heard: candidate.expect_flown())
            listening = Listening(note, self._ends_s, SILENT_S)
            run_dialogue(self.connection, target, dialogue, RoundTrip(known.retry_policy), listening)
            return messages
        except LinkDown as down:
            self._is_open = False
            self._reopens_s = self.connection.now() + RETRY_S
            self._why = str(down)
        except (NoAnswer, NotReady, Silence) as unknown:
            self._why = f"it was heard, but {unknown}"
        except TimeUp:
            return None
        except (IdentityChanged, Replaced) as other:
            raise NotTheSameVehicle(known.system, self.connection.now() - self._since_s, str(other)) from None
        return None

    def _receive(self) -> list[Heard]:
        now = self.connection.now()
        if not self._is_open:
            if now < self._reopens_s:
                time.sleep(NOTICE_S)
                return []
            self.connection.reopen()
            self._is_open = True
        return self.connection.receive(now + NOTICE_S)

    @property
    def _is_over(self) -> bool:
        return self.connection.now() >= self._ends_s

    def _report_loss(self, report: Callable[[str], None]) -> None:
        now = self.connection.now()
        self.seconds = now - self._since_s
        if now - self._reported_s >= RETRY_S:
            self._reported_s = now
            details = (self._why, self._others, self.meanwhile)
            self.words = _with("the link is lost: ", *details)
            report(_with(f"link lost for {self.seconds:.0f} s; ", *details))


def recognize(candidate: VehicleState, known: KnownVehicle) -> Dialogue[None]:
    """Ask questions only. Raise IdentityChanged, OtherKind, Replaced (its list), NotReady or NoAnswer (no list)."""
    candidate.expect_flown()
    clock = yield from orders.request_clock()
    if clock is not None and clock.boot_s < known.clock_s - 1.0:
        raise IdentityChanged(f"it was restarted {clock.boot_s:.0f} s ago; {candidate}")
    about = yield from orders.request_version()
    before = known.about
    if before and about and (before.uid, before.flight_sw_version) != (about.uid, about.flight_sw_version):
        raise IdentityChanged("its AUTOPILOT_VERSION is another one")
    if known.onboard is not None:
        yield from prove([known.onboard], candidate)
    yield from until(lambda: candidate.heard >= {Current, Position}, 2.0)


def _with(words: str, *more: str) -> str:
    return (words + "; ".join(filter(None, more))).rstrip(":; ")
