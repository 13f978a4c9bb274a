"""Open files by the token of their address, and the start page."""

import asyncio
import hmac
import secrets
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

from ipoa_mission import BadInput, MissionError, read_flights, write_mission
from ipoa_mission.files import MISSIONS, packed, unused, write_atomically
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.report.compare import compare_logged
from ipoa_mission.scenario.scenario_file import new_scenario
from ipoa_mission.studio.answers import Beginning, Redirect, Trouble
from ipoa_mission.studio.dropped import LOGS, keep
from ipoa_mission.studio.requests import Begin, Open
from ipoa_mission.studio.session import OpenFile, Session
from ipoa_mission.studio.vocabulary import Window, as_json, place_of

OPENED = (".toml", *MISSIONS, *LOGS)
FILE_CHECK_S = 1.0


@dataclass(eq=False)
class Lobby:
    folder: Path
    open_file: OpenFile

    def join(self, window: Window) -> None:
        window.put_nowait(as_json(self._start()))

    def leave(self, window: Window) -> None:
        pass

    async def handle(self, request: Any, window: Window) -> None:
        try:
            match request:
                case Open():
                    token = await asyncio.to_thread(self.opened, self._offered(request.path))
                case Begin():
                    target = unused(self.folder / "mission.toml")
                    latitude, longitude = place_of(request.place)
                    home = round(latitude, 7), round(longitude, 7), round(request.altitude, 1)
                    write_atomically(target, new_scenario(target, home).text)
                    token = self.open_file(target, None, None)
                case _:
                    raise BadInput("expected a file that is open", hint="open one first")
            window.put_nowait(as_json(Redirect(address=f"../{token}/")))
        except MissionError as error:
            window.put_nowait(as_json(Trouble(of="file", message=str(error), hint=error.hint)))

    def opened(self, path: Path, world: Path | None = None) -> str:
        """Open a scenario, a mission, or a log with its mission; return its token."""
        if path.suffix.lower() in LOGS:
            return self.open_file(_mission_of(path), world, path)
        return self.open_file(path, world, None)

    def take(self, name: str, content: bytes) -> str:
        """Keep and open a dropped file; return its relative address."""
        return f"../{self.opened(keep(name, content, self.folder, OPENED))}/"

    def _start(self) -> Beginning:
        here = sorted(path for path in self.folder.iterdir() if path.suffix.lower() in OPENED)[:40]
        return Beginning(folder=str(self.folder), here=tuple(map(str, here)), examples=(str(packed("campus.toml")),))

    def _offered(self, path: str) -> Path:
        start = self._start()
        if path in start.examples:
            return keep(Path(path).name, Path(path).read_bytes(), self.folder, OPENED)
        if path not in start.here:
            raise BadInput("expected a file that the page offers", hint="drop it on the page", place=path)
        return Path(path)


Host: TypeAlias = Session | Lobby


@dataclass(eq=False)
class Sessions:
    """`hosts`: by the secret token of the address."""

    seed: int = 0
    hosts: dict[str, Host] = field(default_factory=dict)

    def add(self, host: Host) -> str:
        token = secrets.token_urlsafe(24)
        self.hosts[token] = host
        return token

    def open_file(self, path: Path, world: Path | None = None, log: Path | None = None) -> str:
        """Return the token of a file, which is opened once."""
        for token, host in self.hosts.items():
            if isinstance(host, Session) and host.path.resolve() == path.resolve():
                return token
        return self.add(Session(path.resolve(), self.seed, self.open_file, world, log))

    def at(self, token: str) -> Host | None:
        known = (host for name, host in self.hosts.items() if hmac.compare_digest(name.encode(), token.encode()))
        return next(known, None)

    async def run(self) -> None:
        try:
            while True:
                await asyncio.sleep(FILE_CHECK_S)
                for session in self._sessions():
                    await session.look_after(FILE_CHECK_S)
        finally:
            await asyncio.gather(*(session.close() for session in self._sessions()))

    def _sessions(self) -> list[Session]:
        return [host for host in self.hosts.values() if isinstance(host, Session)]


def _mission_of(log: Path) -> Path:
    read = read_flights(log)
    for flight in read.flights:
        compared = compare_logged(flight) if flight.in_mission else None
        if compared is not None:
            mission = replace(compared.forecast.mission_as_read, parameters=compared.parameters)
            target = keep(f"{log.stem}-flown.plan", plan_text(mission).encode(), log.parent, MISSIONS)
            write_mission(mission, target)
            return target
    words = ["expected the mission that was flown in it", *read.remarks]
    raise MissionError("; ".join(words), hint="open the mission, then the log", code="log-incomplete", place=log.name)
