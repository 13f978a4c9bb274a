"""A run of items: a list that goes over the link in order, where each side knows what the other will say next.

As long as that is what is heard, a `Carrier` may answer by itself; anything else is the dialogue's business.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.link.item_payloads import Payloads, pack_items
from ipoa_mission.link.messages import Message, Request
from ipoa_mission.mission.items import Item


@dataclass
class _Run:
    """A list of `count` items; `at` is the one that was asked for last, by whichever side asks.

    `said_s` is when something was said last, `wait_s` how long an answer to it is waited for;
    `round_trip_s` is how long the last answer took.
    """

    kind: int
    count: int
    at: int = -1
    said_s: float = 0.0
    wait_s: float = 0.0
    round_trip_s: float = 0.0

    @property
    def is_ending(self) -> bool:
        """Whether the next step is the last: a list ends in the dialogue."""
        return self.at >= self.count - 2


@dataclass
class ItemsSent(_Run):
    """We have the items, and the other side asks for one after the other."""

    items: Sequence[Item] = ()
    packed: Payloads | None = None
    asked: Callable[[int], None] = lambda seq: None
    is_legacy: bool = False  # asked for by MISSION_REQUEST
    doubt: int | None = None  # a refusal that no request has followed yet

    def asked_for(self, seq: int) -> None:
        """The other side asks for this item."""
        self.at, self.doubt = seq, None
        self.asked(seq)

    @property
    def payloads(self) -> Payloads:
        """The items as they go over the wire."""
        if self.packed is None:
            self.packed = pack_items(self.items, self.kind)
        return self.packed

    @property
    def acted_on(self) -> Message:
        """What was heard last."""
        return Request(self.at, self.kind, self.is_legacy)


@dataclass
class ItemsRead(_Run):
    """The other side has the items, and we ask for one after the other; `keep` is handed each payload."""

    keep: Callable[[bytes], None] = lambda payload: None

    @property
    def question(self) -> Message:
        """What we ask now."""
        return Request(self.at, self.kind)


#: A run of either kind.
ItemRun: TypeAlias = ItemsSent | ItemsRead
