"""Which peers speak for which system, and which of them may: so that an answer goes only where it is wanted.

Several peers may go by one name (a system and a component): two ground stations with the same ids are both answered.
Where only one may speak (the vehicle we talk to; the station whose transfer is under way), it claims the name.
"""

from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Framer, Target

#: A peer that was silent for so long has lost its claim to a name, and its place in a full house.
CLAIM_S = 5.0
#: From one transfer to the next of the same peer (an upload, and its reading back) [s].
REST_S = 1.0
MOST_PEERS = 32


class Routes:
    """What was heard from whom, and when; never more than `MOST_PEERS` of them, those that were spoken to first."""

    def __init__(self) -> None:
        self._heard: dict[tuple[Target, Peer], float] = {}  # the last one heard stands last
        self._claims: dict[Target, tuple[Peer, float]] = {}
        self._spoken_to: set[Target] = set()
        self._framers: dict[Peer, Framer] = {}

    def framer(self, peer: Peer) -> Framer:
        """The half-finished frames of a peer."""
        framer = self._framers.pop(peer, None) or Framer()
        self._framers[peer] = framer
        while len(self._framers) > MOST_PEERS:
            del self._framers[next(iter(self._framers))]
        return framer

    def learn(self, name: Target, peer: Peer, now: float) -> None:
        """A frame of this name came from `peer`.

        A new peer takes the place of those of its name who have fallen silent: it has moved. In a full house whoever
        was silent for `CLAIM_S` goes first, then the longest silent of those whom nobody speaks to; where all are
        spoken to, there is no room for another.
        """
        if self._heard.pop((name, peer), None) is None:
            for one in [one for one, when in self._heard.items() if one[0] == name and now - when >= CLAIM_S]:
                del self._heard[one]
        if len(self._heard) >= MOST_PEERS and not self._make_room(now):
            return
        self._heard[name, peer] = now

    def claim(self, name: Target, peer: Peer, now: float) -> bool:
        """Whether `peer` may speak for this name alone: False while another one does."""
        holder, when = self._claims.get(name, (peer, now))
        if holder != peer and now - when < CLAIM_S:
            return False
        self._claims[name] = (peer, now)
        return True

    def release(self, name: Target, now: float) -> None:
        """Whoever claimed this name has done: unless more comes within `REST_S` another may claim it."""
        holder, _ = self._claims[name]
        self._claims[name] = (holder, now - CLAIM_S + REST_S)

    def heard_s(self, name: Target) -> float | None:
        """When this name was heard last, if it ever was."""
        return max((when for (one, _), when in self._heard.items() if one == name), default=None)

    def holder(self, name: Target) -> Peer | None:
        """Who claimed this name last, if anyone did."""
        holder, _ = self._claims.get(name, (None, 0.0))
        return holder

    def speak_to(self, name: Target) -> None:
        """Whoever goes by this name is not forgotten for the sake of others."""
        self._spoken_to.add(name)

    def to(self, target: Target) -> set[Peer]:
        """The peers behind a target; all of them for a broadcast."""
        return {
            peer
            for (system, component), peer in self._heard
            if target.system in (0, system) and target.component in (0, component)
        }

    def _make_room(self, now: float) -> bool:
        oldest, when = next(iter(self._heard.items()))
        if now - when < CLAIM_S:
            strangers = (one for one in self._heard if one[0] not in self._spoken_to)
            stranger = next(strangers, None)
            if stranger is None:
                return False
            oldest = stranger
        del self._heard[oldest]
        return True
