"""One of the three lists that a vehicle keeps: replaced as a whole when a transfer is complete, or item by item."""

from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import as_stored
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.version import Version


class Store:
    """A list; `truncating`: the old items go when a transfer begins, and a broken one leaves a mixture."""

    def __init__(self, autopilot: Autopilot, version: Version, truncating: bool) -> None:
        self._autopilot, self._version = autopilot, version
        self._truncating = truncating
        self._incoming: list[Item] = []
        self.items: tuple[Item, ...] = ()

    def begin(self, count: int) -> None:
        """A transfer of `count` items begins."""
        self._incoming = []
        if self._truncating:
            self.items = self.items[:count]

    def keep(self, seq: int, item: Item) -> None:
        """Item `seq` has come; items come in order."""
        (kept,) = as_stored((item,), self._autopilot, self._version)
        if self._truncating:
            self.items = (*self.items[:seq], kept, *self.items[seq + 1 :])
        else:
            self._incoming.append(kept)

    @property
    def staged(self) -> tuple[Item, ...]:
        """The list as it will be once the transfer is complete."""
        return self.items if self._truncating else tuple(self._incoming)

    def commit(self) -> None:
        """The transfer is complete."""
        if not self._truncating:
            self.items = tuple(self._incoming)
        self._incoming = []

    def clear(self) -> None:
        """Forget everything."""
        self.items = ()
        self._incoming = []
