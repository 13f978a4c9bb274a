"""An autopilot with a voice: the bytes of the built-in autopilot, for any number of ground stations at once."""

from ipoa_mission.link.channel import Peer
from ipoa_mission.link.codec import EVERYONE, Codec, Target, frames
from ipoa_mission.link.loopback import EPOCH_S
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT
from ipoa_mission.link.routes import Routes
from ipoa_mission.link.signing import Signer
from ipoa_mission.simulator.autopilot import Autopilot


class Station:
    """A `FarEnd`: answers go where the question came from, streams to all who were heard."""

    def __init__(
        self, autopilot: Autopilot, system: int = 1, signer: Signer | None = None, datagrams: bool = True
    ) -> None:
        self.autopilot = autopilot
        self._codec = Codec(system, AUTOPILOT_COMPONENT, signer)
        self._routes = Routes()
        self._datagrams = datagrams
        self._now = 0.0

    def receive(self, data: bytes, peer: Peer, now: float) -> None:
        """Bytes have arrived; what is no frame, is not signed with our key, or is not for us, is passed over."""
        self._now = now
        for frame in frames(data) if self._datagrams else self._routes.framer(peer).feed(data):
            heard = self._codec.decode(frame)
            if heard is None or not self._routes.learn(heard.system, heard.component, peer, now):
                continue
            if heard.message is not None and heard.is_for(self._codec.system, self._codec.component):
                self.autopilot.receive(heard.message, Target(heard.system, heard.component), now)

    def tick(self, now: float) -> None:
        """Time has passed."""
        self._now = now
        self.autopilot.tick(now)

    def outgoing(self) -> list[tuple[bytes, Peer | None]]:
        """The frames to be sent, and to whom; None: to whomever the channel was opened for."""
        sent: list[tuple[bytes, Peer | None]] = []
        for message, target in self.autopilot.outgoing():
            frame = self._codec.encode(message, target, EPOCH_S + self._now)
            peers = self._routes.to(EVERYONE if target == EVERYONE else target)
            sent += [(frame, peer) for peer in peers or {None}]
        return sent

    @property
    def deadline(self) -> float:
        """When `tick` is next needed."""
        return self.autopilot.deadline
