"""Route messages: which peers send as which system, and which may.

Two ground stations with one name (system, component) both get the answers. A vehicle claims its name alone.
"""

from collections.abc import Iterator

from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Framer, Target

#: Silence that ends a claim [s].
CLAIM_S = 5.0
MAX_PEERS = 32


class Routes:
    """`MAX_PEERS` peers, preferably addressed ones."""

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

    def is_torn(self, peer: Peer) -> bool:
        return peer in self._framers and self._framers[peer].buffer != b""

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
