"""Which peer speaks for which system: so that an answer goes only where the question came from."""

from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import Framer, Target

#: A peer that was silent for so long has lost its claim to a system id.
CLAIM_S = 5.0
MOST_PEERS = 32


class Routes:
    """What was heard from whom, and when; never more than `MOST_PEERS` of them."""

    def __init__(self) -> None:
        self._claims: dict[tuple[int, int], tuple[Peer, float]] = {}
        self._framers: dict[Peer, Framer] = {}

    def framer(self, peer: Peer) -> Framer:
        """The half-finished frames of a peer whose bytes come as a stream."""
        framer = self._framers.pop(peer, None) or Framer()
        self._framers[peer] = framer
        while len(self._framers) > MOST_PEERS:
            del self._framers[next(iter(self._framers))]
        return framer

    def learn(self, system: int, component: int, peer: Peer, now: float) -> bool:
        """A frame of this system came from `peer`. Whether it may: False for one who takes another's id."""
        name = (system, component)
        owner, when = self._claims.get(name, (peer, now))
        if owner != peer and now - when < CLAIM_S:
            return False
        self._claims.pop(name, None)
        self._claims[name] = (peer, now)
        while len(self._claims) > MOST_PEERS:
            del self._claims[next(iter(self._claims))]
        return True

    def to(self, target: Target) -> set[Peer]:
        """The peers behind a target; all of them for a broadcast."""
        return {
            peer
            for (system, component), (peer, _) in self._claims.items()
            if target.system in (0, system) and target.component in (0, component)
        }
