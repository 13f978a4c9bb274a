"""A list transferred in order; a `Carrier` may answer its expected messages."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.link.item_payloads import Payloads, pack_items
from ipoa_mission.link.messages import Message, Request
from ipoa_mission.mission.items import Item


@dataclass
class _Run:
    """`at` is the item requested last, by either side; `wait_s`: timeout for its answer."""

    kind: int
    count: int
    at: int = -1
    sent_s: float = 0.0
    wait_s: float = 0.0
    round_trip_s: float = 0.0

    @property
    def is_ending(self) -> bool:
        """The dialogue takes the last step."""
        return self.at >= self.count - 2


@dataclass
class ItemsSent(_Run):
    items: Sequence[Item] = ()
    packed: Payloads | None = None
    asked: Callable[[int], None] = lambda seq: None
    is_legacy: bool = False  # by MISSION_REQUEST
    doubt: int | None = None  # a refusal without a later request

    def asked_for(self, seq: int) -> None:
        self.at, self.doubt = seq, None
        self.asked(seq)

    @property
    def payloads(self) -> Payloads:
        if self.packed is None:
            self.packed = pack_items(self.items, self.kind)
        return self.packed

    @property
    def acted_on(self) -> Message:
        return Request(self.at, self.kind, self.is_legacy)


@dataclass
class ItemsRead(_Run):
    keep: Callable[[bytes], None] = lambda payload: None

    @property
    def question(self) -> Message:
        return Request(self.at, self.kind)


ItemRun: TypeAlias = ItemsSent | ItemsRead
