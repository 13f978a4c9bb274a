"""Serve the start page: recent files, this folder, a new scenario."""

import asyncio
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.files import MISSIONS, packed, unused, write_atomically
from ipoa_mission.logs.flight_log import read_flights
from ipoa_mission.mission.mission_io import write_mission
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.report.compare import compare_logged
from ipoa_mission.scenario.new import new_scenario
from ipoa_mission.studio import memory
from ipoa_mission.studio.answers import Beginning, Elsewhere, StartFile, Trouble
from ipoa_mission.studio.dropped import LOGS, keep
from ipoa_mission.studio.place import place_of
from ipoa_mission.studio.requests import Begin, Open
from ipoa_mission.studio.vocabulary import PageMessage
from ipoa_mission.studio.window import Window

SCENARIO = ".toml"
FILE_LIMIT = 40
#: of a file, given a mission's scenario or log; returns the token
OpenAt: TypeAlias = Callable[[Path, Path | None, Path | None], str]


class Lobby:
    """Serve a page before a file is open."""

    def __init__(self, folder: Path, open_file: OpenAt) -> None:
        self._folder, self._open_file = folder, open_file
        self._windows: set[Window] = set()

    @property
    def folder(self) -> Path:
        return self._folder

    def join(self, window: Window) -> None:
        self._windows.add(window)
        window.tell(self._start().model_dump(mode="json"))

    def leave(self, window: Window) -> None:
        self._windows.discard(window)

    def tell_all(self, message: PageMessage | dict[str, Any]) -> None:
        """Do nothing: the start page has no map."""

    async def run(self) -> None:
        """Do nothing."""

    async def handle(self, request: Any, window: Window) -> None:
        try:
            match request:
                case Open():
                    path = self._offered(request.path)
                    token = await asyncio.to_thread(self.opened, path)
                case Begin():
                    token = await asyncio.to_thread(self._begin, request)
                case _:
                    raise BadInput("expected a file that is open", hint="open one first")
            window.tell(Elsewhere(address=f"../{token}/").model_dump(mode="json"))
        except MissionError as error:
            window.tell(Trouble(of="file", message=str(error), hint=error.hint).model_dump(mode="json"))

    def opened(self, path: Path, world: Path | None = None) -> str:
        """Open a scenario, a mission, or a log with its mission; return its token."""
        if path.suffix.lower() in LOGS:
            return self._open_file(_mission_of(path), world, path)
        return self._open_file(path, world, None)

    def take(self, name: str, content: bytes) -> str:
        """Keep a dropped file and open it; return its relative address."""
        path = keep(name, content, self._folder, (SCENARIO, *MISSIONS, *LOGS))
        return f"../{self.opened(path)}/"

    def _begin(self, request: Begin) -> str:
        latitude, longitude = place_of(request.place)
        target = unused(self._folder / "mission.toml")
        begin_scenario(target, (latitude, longitude, request.altitude))
        return self._open_file(target, None, None)

    def _start(self) -> Beginning:
        recent = [Path(one.path) for one in memory.recent() if one.path]
        here = sorted(path for path in self._folder.iterdir() if path.suffix.lower() in (SCENARIO, *MISSIONS, *LOGS))
        return Beginning(
            folder=str(self._folder),
            recent=_files(path for path in recent if path.is_file()),
            here=_files(path for path in here[:FILE_LIMIT] if path not in recent),
            examples=_files(packed(name) for name in ("campus.toml",)),
        )

    def _offered(self, asked: str) -> Path:
        """Return an offered file; copy an example into the folder first."""
        told = self._start()
        if asked in [one.path for one in told.examples]:
            return keep(Path(asked).name, Path(asked).read_bytes(), self._folder, (SCENARIO,))
        if asked not in [one.path for one in (*told.recent, *told.here)]:
            raise BadInput("expected a file that the page offers", hint="drop it on the page", place=asked)
        return Path(asked)


def begin_scenario(target: Path, home: tuple[float, float, float]) -> None:
    """Write a new scenario with a goal north of home."""
    latitude, longitude, altitude = home
    rounded = round(latitude, 7), round(longitude, 7), round(altitude, 1)
    write_atomically(target, new_scenario(target, rounded).text)


def _files(paths: Iterable[Path]) -> tuple[StartFile, ...]:
    return tuple(
        StartFile.model_validate({"path": str(path), "name": path.name, "folder": str(path.parent), "of": _sort(path)})
        for path in paths
    )


def _sort(path: Path) -> str:
    suffix = path.suffix.lower()
    return "scenario" if suffix == SCENARIO else "log" if suffix in LOGS else "mission"


def _mission_of(log: Path) -> Path:
    read = read_flights(log)
    for flight in read.flights:
        held = compare_logged(flight) if flight.in_mission else None
        if held is not None:
            mission = replace(held.forecast.given, parameters=held.parameters)
            target = keep(f"{log.stem}-flown.plan", plan_text(mission).encode(), log.parent, MISSIONS)
            write_mission(mission, target)
            return target
    words = ["expected the mission that was flown in it", *read.remarks]
    raise MissionError("; ".join(words), hint="open the mission, then the log", code="log-incomplete", place=log.name)
