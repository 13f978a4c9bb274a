"""One request at a time each; a process that dies is restarted."""

import asyncio
import json
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeAlias

Hear: TypeAlias = Callable[[dict[str, Any]], None]
LINE_LIMIT = 256 * 1024 * 1024  # of an answer [bytes]


class ProcessDied(Exception):
    """The process ended before it had answered."""


class Process:
    def __init__(self, module: str) -> None:
        self._module = module
        self._process: asyncio.subprocess.Process | None = None
        self._one_at_a_time = asyncio.Lock()
        self._number = 0

    async def start(self) -> asyncio.subprocess.Process:
        if self._process is None or self._process.returncode is not None:
            self._process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                self._module,
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                limit=LINE_LIMIT,
            )
        return self._process

    async def ask(self, order: dict[str, Any], hear: Hear) -> None:
        """Send a job, and call `hear` with every answer; pass on cancellation."""
        async with self._one_at_a_time:
            process = await self.start()
            self._number += 1
            await _send(process, order | {"id": self._number})
            cancelled = False
            while True:
                try:
                    line = await _line(process)
                except asyncio.CancelledError:
                    cancelled = True
                    await _send(process, {"cancel": self._number})
                    continue
                if line is None:
                    raise ProcessDied(self._module)
                if line.get("id") == self._number:
                    if "done" in line:
                        break
                    if not cancelled:
                        hear(line["answer"])
            if cancelled:
                raise asyncio.CancelledError

    async def send(self, order: dict[str, Any]) -> None:
        if self._process is not None:
            await _send(self._process, order)

    async def close(self) -> None:
        process, self._process = self._process, None
        if process is not None and process.returncode is None:
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()


async def _send(process: asyncio.subprocess.Process, order: dict[str, Any]) -> None:
    assert process.stdin is not None
    with suppress(ConnectionError):
        process.stdin.write(json.dumps(order).encode() + b"\n")
        await process.stdin.drain()


async def _line(process: asyncio.subprocess.Process) -> Any:
    assert process.stdout is not None
    while text := await process.stdout.readline():
        if text.startswith(b"{"):  # a library's prints
            return json.loads(text)
    await process.wait()
    return None
