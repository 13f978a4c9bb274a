"""A vehicle's list, replaced as a whole or item by item."""

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import as_stored


class Store:
    """`truncating`: drop the old items at a transfer's start; a failed one leaves a mixture."""

    def __init__(self, autopilot: Autopilot, version: Version, truncating: bool) -> None:
        self._autopilot, self._version = autopilot, version
        self._truncating = truncating
        self._incoming: list[Item] = []
        self.items: tuple[Item, ...] = ()

    def begin(self, count: int) -> None:
        self._incoming = []
        if self._truncating:
            self.items = self.items[:count]

    def keep(self, seq: int, item: Item) -> None:
        (kept,) = as_stored((item,), self._autopilot, self._version)
        if self._truncating:
            self.items = (*self.items[:seq], kept, *self.items[seq + 1 :])
        else:
            self._incoming.append(kept)

    @property
    def staged(self) -> tuple[Item, ...]:
        """Return the list after a complete transfer."""
        return self.items if self._truncating else tuple(self._incoming)

    def commit(self) -> None:
        if not self._truncating:
            self.items = tuple(self._incoming)
        self._incoming = []

    def clear(self) -> None:
        self.items = ()
        self._incoming = []
