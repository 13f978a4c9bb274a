"""Describe a run of items: a list that is transferred in order, so that each next message is known.

A `Carrier` may answer the expected messages by itself; the dialogue handles all others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.link.item_payloads import Payloads, pack_items
from ipoa_mission.link.messages import Message, Request
from ipoa_mission.mission.items import Item


@dataclass
class _Run:
    """Follow a list of `count` items; `at` is the item requested last, by either side.

    `sent_s` is the time of the last sent message, `wait_s` the timeout for its answer, `round_trip_s` the delay of the
    last answer [s].
    """

    kind: int
    count: int
    at: int = -1
    sent_s: float = 0.0
    wait_s: float = 0.0
    round_trip_s: float = 0.0

    @property
    def is_ending(self) -> bool:
        """Check whether the next step is the last, which the dialogue takes itself."""
        return self.at >= self.count - 2


@dataclass
class ItemsSent(_Run):
    items: Sequence[Item] = ()
    packed: Payloads | None = None
    asked: Callable[[int], None] = lambda seq: None
    is_legacy: bool = False  # requested by MISSION_REQUEST
    doubt: int | None = None  # a refusal, unless a request followed it

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
    """Request items one by one; `keep` receives each payload."""

    keep: Callable[[bytes], None] = lambda payload: None

    @property
    def question(self) -> Message:
        return Request(self.at, self.kind)


#: A run of either kind.
ItemRun: TypeAlias = ItemsSent | ItemsRead
