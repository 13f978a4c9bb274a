"""A page that is open, as the server sees it."""

import asyncio
from typing import Any


class Window:
    """A page that is open: what it is told is sent in order by a task of its own, out of the `queue`."""

    def __init__(self) -> None:
        self.queue: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    def tell(self, message: dict[str, Any]) -> None:
        """Send it a message, soon."""
        self.queue.put_nowait(message)
