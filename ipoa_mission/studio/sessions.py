import asyncio
import hmac
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

from ipoa_mission.errors import MissionError
from ipoa_mission.studio import memory
from ipoa_mission.studio.session import Session
from ipoa_mission.studio.vocabulary import PageMessage
from ipoa_mission.studio.window import Window


class Host(Protocol):
    @property
    def folder(self) -> Path: ...

    def join(self, window: Window) -> None: ...

    def leave(self, window: Window) -> None: ...

    def tell_all(self, message: PageMessage | dict[str, Any]) -> None:
        """Send to every window, also to later ones."""

    async def handle(self, request: Any, window: Window) -> None: ...

    async def run(self) -> None: ...


class Sessions:
    """Hosts by the token of their address; a page of an earlier run reopens its file."""

    def __init__(self, port: int = 0, seed: int = 0) -> None:
        self._port, self._seed = port, seed
        self._hosts: dict[str, Host] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._told: list[PageMessage] = []
        self._more = asyncio.Event()

    def add(self, token: str, host: Host) -> None:
        self._hosts[token] = host
        for message in self._told:
            host.tell_all(message)
        self._more.set()

    def tell_everyone(self, message: PageMessage) -> None:
        self._told.append(message)
        for host in self._hosts.values():
            host.tell_all(message)

    def open_file(self, path: Path, world: Path | None = None, log: Path | None = None) -> str:
        known = memory.address_of(path.resolve())
        known = replace(known, world=str((world or Path(known.world)).resolve()) if world or known.world else "")
        known = replace(known, log=str(log.resolve()) if log else known.log)
        if known.token not in self._hosts:
            self.add(known.token, self._session(known))
        memory.remember(known, self._port)
        return known.token

    def at(self, token: str) -> Host | None:
        """Return the host at a token; reopen one of an earlier run."""
        for known, host in self._hosts.items():
            if hmac.compare_digest(known.encode(), token.encode()):
                return host
        for one in memory.recent():
            if one.path and hmac.compare_digest(one.token.encode(), token.encode()):
                with suppress(MissionError):
                    self.add(one.token, self._session(one))
                    return self._hosts[one.token]
        return None

    async def run(self) -> None:
        try:
            while True:
                for token, host in self._hosts.items():
                    if token not in self._tasks:
                        self._tasks[token] = asyncio.create_task(host.run())
                self._more.clear()
                await self._more.wait()
        finally:
            for task in self._tasks.values():
                task.cancel()
            await asyncio.gather(*self._tasks.values(), return_exceptions=True)

    def _session(self, known: memory.Opened) -> Session:
        def open_beside(path: Path, world: Path | None) -> str:
            return f"../{self.open_file(path, world)}/"

        world, log = (Path(one) if one and Path(one).is_file() else None for one in (known.world, known.log))
        return Session(Path(known.path), self._seed, open_beside, world, log)
