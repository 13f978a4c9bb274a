"""The ground station's end of a link, and `run_dialogue` with one vehicle on it."""

import logging
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from ipoa_mission.errors import MissionError
from ipoa_mission.interrupts import noted_interrupts
from ipoa_mission.link.channel import Channel, Peer
from ipoa_mission.link.codec import EVERYONE, Codec, Framer, Heard, LongTexts, Target, TlogWriter, is_old, is_signed
from ipoa_mission.link.dialogue import Cancelled, Dialogue, Exchange, NoAnswer, RoundTrip, Silence, T, TimeUp
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, NO_AUTOPILOT, Heartbeat, Message
from ipoa_mission.link.signing import Doubt
from ipoa_mission.link.vehicle_state import NotFlown

log = logging.getLogger(__name__)
NOTICE_S = 0.1  # until Ctrl-C is noticed
CAUSE_S = 5.0  # of silence, until its cause is reported
CLAIM_S = 5.0  # of silence, which end a claim
MAX_PEERS = 32


class Routes:
    """Which peers send as which system, and which may: `MAX_PEERS`, preferably addressed ones.

    Two ground stations with one name (system, component) both get the answers. A vehicle claims its name alone.
    """

    def __init__(self) -> None:
        self._heard: dict[tuple[Target, Peer], float] = {}  # by the time of the last message
        self._claims: dict[Target, tuple[Peer, float]] = {}
        self._spoken_to: set[Target] = set()
        self._framers: dict[Peer, Framer] = {}

    def frames(self, data: bytes, peer: Peer) -> Iterator[bytes]:
        framer = self._framers.pop(peer, None) or Framer()
        self._framers[peer] = framer
        while len(self._framers) > MAX_PEERS:
            del self._framers[next(iter(self._framers))]
        return framer.feed(data)

    def learn(self, name: Target, peer: Peer, now: float) -> None:
        """Replace peers of its name silent for `CLAIM_S`; a full table drops such an entry, else one unaddressed."""
        if self._heard.pop((name, peer), None) is None:
            for entry in [entry for entry, when in self._heard.items() if entry[0] == name and now - when >= CLAIM_S]:
                del self._heard[entry]
        if len(self._heard) >= MAX_PEERS and not self._make_room(now):
            return
        self._heard[name, peer] = now

    def claim(self, name: Target, peer: Peer, now: float) -> bool:
        """Return False while another peer holds the name."""
        holder, when = self._claims.get(name, (peer, now))
        if holder != peer and now - when < CLAIM_S:
            return False
        self._claims[name] = (peer, now)
        return True

    def heard_s(self, name: Target) -> float | None:
        return max((when for (known, _), when in self._heard.items() if known == name), default=None)

    def holder(self, name: Target) -> Peer | None:
        holder, _ = self._claims.get(name, (None, 0.0))
        return holder

    def to(self, target: Target) -> set[Peer]:
        """Return the peers of a target, all for a broadcast; an addressed name stays in a full table."""
        if 0 not in target:
            self._spoken_to.add(target)
        return {
            peer
            for (system, component), peer in self._heard
            if target.system in (0, system) and target.component in (0, component)
        }

    def _make_room(self, now: float) -> bool:
        for (name, peer), when in self._heard.items():
            if now - when >= CLAIM_S or name not in self._spoken_to:
                del self._heard[name, peer]
                return True
        return False


class SpeaksMavlink1(MissionError, code="speaks-mavlink1"):
    def __init__(self, system: int) -> None:
        super().__init__(
            f"vehicle {system} speaks MAVLink 1 only, and does not answer to MAVLink 2",
            hint="set it to MAVLink 2 on this link (ArduPilot: SERIALn_PROTOCOL 2, PX4: MAV_PROTO_VER 2)",
        )


class SignsOtherwise(MissionError, code="signs-otherwise"):
    def __init__(self, system: int, doubt: Doubt | None) -> None:
        ours = "give the key that it has: --key FILE"
        words, hint = {
            None: ("it signs its messages, and does not answer our unsigned ones", ours),
            Doubt.UNSIGNED: (
                "it does not sign, and only messages signed with our key are accepted",
                "give it this key, or connect without one",
            ),
            Doubt.FOREIGN: ("it signs with another key than ours", ours),
            Doubt.STALE: (
                "it signs with our key, but its timestamps are old",
                "is its clock wrong, or this computer's? Or are old messages replayed?",
            ),
        }[doubt]
        super().__init__(f"vehicle {system} is there, but {words}", hint=hint)


class MessageLink(Protocol):
    """Carry messages; by default without known peers, and not to be opened again."""

    def now(self) -> float: ...

    def send(self, message: Message, target: Target = EVERYONE) -> None: ...

    def receive(self, until: float) -> list[Heard]:
        """Return messages at once, or none at `until`."""

    def close(self) -> None: ...

    def note_answer(self, target: Target) -> None:
        return

    def no_reply_cause(self, target: Target) -> MissionError | None:
        """Return why a heard target never answers, if known."""
        return None

    def expect_alone(self, system: int) -> None:
        """Raise Contested if two vehicles use this system id."""
        return

    reopens: bool = False  # `reopen` can repair the link

    def reopen(self) -> None:
        """Raise LinkDown, or open the link; all peers are then unknown."""
        return


class Contested(MissionError, code="contested"):
    """Two vehicles use one system id: both may obey an order to one."""

    def __init__(self, system: int) -> None:
        super().__init__(
            f"two vehicles on this link have the system id {system}",
            hint="give each its own (ArduPilot: SYSID_THISMAV or MAV_SYSID, PX4: MAV_SYS_ID), or a link of its own",
        )


class Connection(MessageLink):
    """The ground station's end of a link; `again` opens a new channel."""

    def __init__(
        self, channel: Channel, codec: Codec, log: str | Path | None = None, again: Callable[[], Channel] | None = None
    ) -> None:
        self.channel = channel
        self.reopens = again is not None
        self._again = again
        self.codec = codec
        self._log = TlogWriter(log) if log else None
        self._routes = Routes()
        self._rivals: dict[Target, tuple[float, float]] = {}  # first and last heard
        self._is_warned = False
        self._is_old: dict[Target, bool] = {}
        self._signing: set[Target] = set()
        self._understands: set[Target] = set()
        self._next_heartbeat = channel.now()
        self._texts = LongTexts()

    def now(self) -> float:
        return self.channel.now()

    def send(self, message: Message, target: Target = EVERYONE) -> None:
        frame = self.codec.encode(message, target, self.channel.unix_s())
        if self._log:
            self._log.write(frame, self.channel.unix_s())
        for peer in self._routes.to(target) or (None,):
            self.channel.send(frame, peer)

    def receive(self, until: float) -> list[Heard]:
        """Return messages of known peers to us or to everyone; send our heartbeat when due."""
        now = self.now()
        if now >= self._next_heartbeat:  # MAV_TYPE_GCS
            self._next_heartbeat = now + 1.0
            self.send(Heartbeat(6, NO_AUTOPILOT))
        heard = self._hear(self.channel.receive(min(until, self._next_heartbeat)))
        us = (self.codec.system, self.codec.component)
        return [each for each in heard if each.message is not None and each.is_for(*us)]

    def _hear(self, received: list[tuple[bytes, Peer]]) -> list[Heard]:
        heard = list[Heard]()
        now = self.channel.now()
        for data, peer in received:
            for frame in self._routes.frames(data, peer):
                decoded = self.codec.decode(frame)
                if decoded is not None and self._is_known(decoded, peer, now):
                    heard.append(decoded)
                    if self._log:
                        self._log.write(frame, self.channel.unix_s())
        return list(self._texts.joined(heard, now))

    def contested(self, system: int) -> bool:
        name = Target(system, AUTOPILOT_COMPONENT)
        first, last = self._rivals.get(name, (math.inf, -math.inf))
        heard = self._routes.heard_s(name)
        return heard is not None and heard > first and self.channel.now() - last < CLAIM_S

    def expect_alone(self, system: int) -> None:
        if self.contested(system):
            raise Contested(system)

    def note_answer(self, target: Target) -> None:
        self._understands.add(target)

    def no_reply_cause(self, target: Target) -> MissionError | None:
        if target in self._understands:
            return None
        if self._is_old.get(target, False):
            return SpeaksMavlink1(target.system)
        return SignsOtherwise(target.system, None) if target in self._signing and not self.codec.signer else None

    def rejected(self, system: int | None) -> SignsOtherwise | None:
        """Return why frames of this autopilot, or of any, are not accepted."""
        doubts = self.codec.signer.doubts if self.codec.signer else {}
        for (sender, component), doubt in sorted(doubts.items()):
            if component == AUTOPILOT_COMPONENT and system in (None, sender):
                return SignsOtherwise(sender, doubt)
        return None

    def reopen(self) -> None:
        assert self._again is not None, "asked of `reopens` first"
        self.channel.close()
        self.channel = self._again()
        self._routes = Routes()
        self._rivals = {}

    def close(self) -> None:
        self.channel.close()
        if self._log:
            self._log.close()
        if self.codec.signer:
            self.codec.signer.close()

    def _is_known(self, heard: Heard, peer: Peer, now: float) -> bool:
        """Return whether the message is of the name's known peer; note rivals."""
        name = Target(heard.system, heard.component)
        before = self._routes.holder(name)
        if self._routes.claim(name, peer, now):
            if before != peer:
                self._rivals.pop(name, None)
            self._routes.learn(name, peer, now)
            self._is_old[name] = is_old(heard.raw) and self._is_old.get(name, True)
            if is_signed(heard.raw):
                self._signing.add(name)
            return True
        if isinstance(heard.message, Heartbeat) and heard.message.vehicle is not None:
            first, last = self._rivals.get(name, (now, now))
            self._rivals[name] = (first if now - last < CLAIM_S else now, now)
            if not self._is_warned and self.contested(heard.system):
                self._is_warned = True
                log.warning("another vehicle with system id %d is on the link; it is not listened to", heard.system)
        return False

    def __enter__(self) -> "Connection":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@dataclass(frozen=True)
class Listening:
    """`overhear` gets each message; raise TimeUp at `until`, on the connection's clock, and Silence after `quiet_s`."""

    overhear: Callable[[Message], None] = lambda message: None
    until: float = math.inf
    quiet_s: float = math.inf


def run_dialogue(
    connection: MessageLink, target: Target, dialogue: Dialogue[T], rtt: RoundTrip, listening: Listening | None = None
) -> T:
    """Hold a dialogue with one vehicle.

    Raise `Cancelled` in it at Ctrl-C (a second one ends it), and the errors of `listening`. Raise SpeaksMavlink1 or
    SignsOtherwise if the target never answers.
    """
    listening = listening or Listening()
    now = connection.now
    until = listening.until
    with noted_interrupts() as interrupt:
        exchange = Exchange(dialogue, now(), rtt.policy, rtt)
        try:
            while not exchange.finished:
                for message in exchange.outgoing():
                    connection.send(message, target)
                moment = min(until, now() + NOTICE_S)
                for heard in connection.receive(min(exchange.deadline, moment)):
                    if (heard.system, heard.component) == target and heard.message is not None:
                        if now() - exchange.heard_s >= listening.quiet_s:
                            break
                        listening.overhear(heard.message)
                        exchange.receive(heard.message, now())
                if exchange.was_answered:
                    connection.note_answer(target)
                elif exchange.asked_for_s(now()) >= CAUSE_S and (cause := connection.no_reply_cause(target)):
                    exchange.interrupt(cause, now())
                if now() - exchange.heard_s >= listening.quiet_s:
                    exchange.interrupt(Silence("the vehicle is not heard"), now())
                exchange.tick(now())
                if not exchange.finished and interrupt.take():
                    exchange.interrupt(Cancelled("cancelled"), now())
                if now() >= until:
                    until = math.inf
                    exchange.interrupt(TimeUp("the time is up"), now())
        except NoAnswer as silence:
            raise connection.no_reply_cause(target) or silence from None
        except (NotFlown, Silence):
            exchange.outgoing()  # drop messages that were due before
            raise
        finally:
            for message in exchange.outgoing():
                connection.send(message, target)
        return exchange.result
