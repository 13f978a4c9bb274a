import asyncio
from typing import Any


class Window:
    """An open page; a task of its own sends messages in order from the `queue`."""

    def __init__(self) -> None:
        self.queue: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    def tell(self, message: dict[str, Any]) -> None:
        self.queue.put_nowait(message)
