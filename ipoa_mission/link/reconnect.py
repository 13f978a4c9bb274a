"""A vehicle in flight that is not heard any more: the link is opened anew, and who is heard then must be known again.

Nothing is told to whoever comes back until it is of the same kind under the same system id, was not restarted, and
holds the mission that was uploaded; what it says meanwhile counts only from then on.
"""

import logging
import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.errors import MissionError
from ipoa_mission.link import orders
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.codec import Heard, Target
from ipoa_mission.link.conversations import noting
from ipoa_mission.link.dialogue import Cancelled, Dialogue, NoAnswer, Patience, Silence, TimeUp, until
from ipoa_mission.link.discovery import autopilots_in
from ipoa_mission.link.interrupt import Interrupt, noted_interrupts
from ipoa_mission.link.line import NOTICE_S, Carrier, converse
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, Current, Heartbeat, Message
from ipoa_mission.link.onboard_list import OnboardList, prove
from ipoa_mission.link.telemetry import AutopilotVersion, Position
from ipoa_mission.link.upload import Replaced
from ipoa_mission.link.vehicle_state import NotReady, VehicleState

log = logging.getLogger(__name__)
SILENT_S = 3.0  # so long without a word the link is lost
GONE_S = 300.0  # and so long the vehicle is
AGAIN_S = 1.0  # between two attempts to open the link, and how often it is told how long it is lost
SHOWN_S = 2.0  # how long one waits for where the vehicle is, and at which item
EARLIER_S = 1.0  # a clock that is so much behind what it was has begun anew


class NotTheSameVehicle(MissionError):
    """Who is heard on the link again is not the vehicle that was lost, or not as it was: it is told nothing."""

    def __init__(self, system: int, lost_s: float, why: str) -> None:
        super().__init__(f"after {lost_s:.0f} s vehicle {system} is heard again, but {why}: it is told nothing")


class IdentityChanged(MissionError):
    """It is another vehicle, or has become one; the message says by what."""


@dataclass(frozen=True)
class KnownVehicle:
    """What is known of the vehicle that was lost: its state, clock and version, and the mission that it holds."""

    system: int
    state: VehicleState
    clock_s: float
    about: AutopilotVersion | None
    holding: OnboardList | None


class LinkLoss:
    """Whether a vehicle that is watched is away, for how long [s], and what is known of that in `words`.

    `seconds` is None and `words` are empty while it is heard. `meanwhile`: what it does without its ground station.
    """

    def __init__(self, line: Carrier) -> None:
        self.seconds: float | None = None
        self.words, self.meanwhile = "", ""
        self._line, self._why = line, ""
        self._since_s = self._told_s = self._open_s = 0.0
        self._until_s = math.inf
        self._is_open = True
        self._others = ""

    def end(
        self,
        lost: MissionError,
        known: KnownVehicle,
        patience: Patience,
        tell: Callable[[str], None],
        until_s: float = math.inf,
    ) -> list[Message]:
        """Wait until the vehicle is heard again, and known to be the same: what it has said by then.

        Args:
            lost: how it was lost.
            known: what is known of it.
            patience: how long answers are waited for.
            tell: told every second in which it is not known again.
            until_s: when the user's time is up, on the line's clock.

        Raises:
            LinkDown: the link broke, and is not ours to open anew.
            NotTheSameVehicle, OtherKind: somebody else is heard in its place, or another mission is on it.
            NoAnswer: it was not known again in `GONE_S`.
            TimeUp: nor until `until_s`.
            Cancelled: by Ctrl-C.
        """
        now, self._until_s = self._line.now(), until_s
        self._is_open = not isinstance(lost, LinkDown)
        if not (self._is_open or self._line.reopens):
            raise lost
        self._since_s, self._told_s, self._open_s = now - SILENT_S * self._is_open, -AGAIN_S, now
        self._why, self._others = ("" if self._is_open else str(lost)), ""
        self._look(tell)
        log.warning("%s; it is listened for, for %g s", self.words, GONE_S)
        try:
            with noted_interrupts() as interrupt:
                while (kept := self._kept(known, patience, interrupt, tell)) is None:
                    if self._line.now() >= until_s:
                        raise TimeUp("the time is up")
                    if self._is_over:
                        words = _with(f"the link is lost for {GONE_S:g} s: ", self._why, self._others)
                        raise NoAnswer(words, code="link-lost")
            log.warning("the link is there again after %.0f s: %s", self._line.now() - self._since_s, _same(known))
            return kept
        finally:
            self.seconds, self.words = None, ""

    def _kept(
        self, known: KnownVehicle, patience: Patience, interrupt: Interrupt, tell: Callable[[str], None]
    ) -> list[Message] | None:
        """What the vehicle has said, if it was heard and is known; None where that is to be tried again."""
        stranger, kept = VehicleState(known.state.autopilot, known.state.kind), list[Message]()

        def note(message: Message) -> None:
            stranger.note(message)
            kept.append(message)
            self._look(tell)

        target = Target(known.system, AUTOPILOT_COMPONENT)
        try:
            while Heartbeat not in stranger.heard and not self._is_over:
                self._look(tell)
                if interrupt.take():
                    raise Cancelled("cancelled")
                for heard in self._heard():
                    if heard.message is not None and (heard.system, heard.component) == target:
                        note(heard.message)
                    elif autopilots_in([heard]):
                        self._others = f"vehicle {heard.system} is heard, and is told nothing"
            if Heartbeat not in stranger.heard:
                return None
            dialogue = noting(recognize(stranger, known), lambda heard: stranger.expect_flown())
            end_s = min(self._since_s + GONE_S, self._until_s)
            converse(self._line, target, dialogue, patience, overhear=note, until=end_s, quiet_s=SILENT_S)
            return kept
        except LinkDown as down:
            self._is_open, self._open_s, self._why = False, self._line.now() + AGAIN_S, str(down)
        except (NoAnswer, NotReady, Silence) as unknown:
            self._why = f"it was heard, but {unknown}"
        except TimeUp:
            return None
        except (IdentityChanged, Replaced) as other:
            raise NotTheSameVehicle(known.system, self._line.now() - self._since_s, str(other)) from None
        return None

    def _heard(self) -> list[Heard]:
        """What is heard in a moment; a link that broke is opened anew first, now and then."""
        now = self._line.now()
        if not self._is_open:
            if now < self._open_s:
                time.sleep(NOTICE_S)
                return []
            self._line.reopen()
            self._is_open = True
        return self._line.receive(now + NOTICE_S)

    @property
    def _is_over(self) -> bool:
        return self._line.now() >= min(self._since_s + GONE_S, self._until_s)

    def _look(self, tell: Callable[[str], None]) -> None:
        """Time has passed."""
        now = self._line.now()
        self.seconds = now - self._since_s
        if now - self._told_s >= AGAIN_S:
            self._told_s = now
            self.words = _with("the link is lost: ", self._why, self._others, self.meanwhile)
            tell(_with(f"link lost for {self.seconds:.0f} s; ", self._why, self._others, self.meanwhile))


def recognize(stranger: VehicleState, known: KnownVehicle) -> Dialogue[None]:
    """See that who is heard is the vehicle that is known; only questions are asked.

    Raises:
        OtherKind, Replaced, Another: it is not, or holds another mission.
        NotReady, NoAnswer: it does not tell.
    """
    stranger.expect_flown()
    clock = yield from orders.clock()
    if clock is not None and clock.boot_s < known.clock_s - EARLIER_S:
        raise IdentityChanged(f"its clock has begun anew, {clock.boot_s:.0f} s ago: it was restarted; {stranger}")
    before, about = known.about, (yield from orders.about())
    if before and about and (before.uid, before.flight_sw_version) != (about.uid, about.flight_sw_version):
        raise IdentityChanged("by its AUTOPILOT_VERSION it is another one")
    if known.holding is not None:
        yield from prove([known.holding], stranger)
    yield from until(lambda: stranger.heard >= {Current, Position}, SHOWN_S)


def _with(words: str, *more: str) -> str:
    """The same, and what else there is to say behind it."""
    return (words + "; ".join(filter(None, more))).rstrip(":; ")


def _same(known: KnownVehicle) -> str:
    return "it is the same vehicle" + ("" if known.holding is None else ", with the mission that was uploaded")
