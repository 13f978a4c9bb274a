"""Serve one document to its windows, and plan after every change."""

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeAlias

from ipoa_mission import MissionError
from ipoa_mission.files import MISSIONS, unused
from ipoa_mission.studio import requests
from ipoa_mission.studio.answers import Found, Redirect, Trouble, Written
from ipoa_mission.studio.flight_desk import FlightDesk
from ipoa_mission.studio.processes import Process
from ipoa_mission.studio.scenario_document import Document
from ipoa_mission.studio.vocabulary import PageMessage, Window, as_json, place_of

SETTLE_TIME_S = 0.6  # before the proved path is planned
ALONE_LIMIT_S = 120.0  # of planners, without window and flight
#: Obsolete after a change of the document.
OF_REVISION = ("sketch", "coarse_survey", "plan", "survey", "contingencies", "checked", "replay")
OBSOLETE = (*OF_REVISION, "trouble of scenario", "trouble of sketch", "trouble of plan")
#: Their latest answer is for a new window too.
LATEST = {*OF_REVISION, "area", "world", "mission", "loaded", "state", "trouble"}
PLANNER = "ipoa_mission.studio.plan_worker"
#: of a file, given a mission's scenario or log; returns the token
OpenFile: TypeAlias = Callable[[Path, Path | None, Path | None], str]
Work: TypeAlias = Callable[[], Coroutine[Any, Any, object]]


@dataclass(eq=False)
class Session:
    path: Path
    seed: int = 0
    open_file: OpenFile | None = None
    world: Path | None = None
    log: Path | None = None

    def __post_init__(self) -> None:
        self.document = Document(self.path)
        self.folder = self.path.parent
        self._windows: set[Window] = set()
        self._flown: tuple[Path, ...] = ()
        words = "the planner ended unexpectedly; nothing of the scenario is lost"
        died = Trouble(of="plan", message=words, hint="plan again")
        self._quick = Process(PLANNER, died)
        self._thorough = Process(PLANNER, died)
        self._flights = FlightDesk(self.document, self.send_all)
        self._jobs: dict[str, asyncio.Task[object]] = {}
        self._drags: dict[Window, requests.Drag] = {}
        self._latest: dict[str, dict[str, Any]] = {}
        self._alone_s = 0.0

    def join(self, window: Window) -> None:
        self._windows.add(window)
        for message in (as_json(self.document.as_answer()), *self._latest.values()):
            window.put_nowait(message)
        if "world" not in self._latest:
            self._follow()

    def leave(self, window: Window) -> None:
        self._windows.discard(window)
        self._drags.pop(window, None)

    def send_all(self, message: PageMessage | dict[str, Any]) -> None:
        """Send to every window; later windows get the latest answer of each kind."""
        answer = as_json(message)
        kind = answer["kind"]
        slot = _slot(answer)
        if kind in LATEST and slot != "trouble of edit":
            self._latest[slot] = answer
        if kind == "state" and answer["phase"] in ("idle", "over"):
            self._forget("loaded")
        if kind == "survey" and not answer["flown"]:
            self._flown = ()  # of another survey
        for window in self._windows:
            window.put_nowait(answer)

    async def handle(self, request: Any, window: Window) -> None:
        try:
            match request:
                case requests.Edit():
                    self._changed(self.document.edit(request.changes, request.label, request.seen))
                case requests.Rewrite():
                    self._changed(self.document.rewrite(request.text, request.seen))
                case requests.Drag():
                    self._drags[window] = request
                    self._job("drag", self._answer_drags)
                case requests.Do():
                    self._do(request)
                case requests.Rest():
                    self._flown = tuple(self.folder / Path(log).name for log in request.logs)
                    self._start("plan", self._plan)
                case requests.Open():
                    path = self.folder / Path(request.path).name
                    if path.suffix.lower() not in MISSIONS:
                        words = f'expected a name that ends in {" or ".join(MISSIONS)}, not in "{path.suffix}"'
                        raise MissionError(words, place=path.name)
                    window.put_nowait(as_json(self._opened(path)))
                case requests.SaveAs():
                    file, remarks = self.document.save_as(request.suffix)
                    self.send_all(Written(files=(file.name,), remarks=remarks))
                case requests.SetScenario():
                    self.world = None if request.scenario is None else Path(request.scenario)
                    self.document.read_for(request.autopilot)
                    self._changed(True)
                case requests.Upload():
                    self._expect_ready()
                    self._forget("trouble of flight")
                    name = self._name_of(request.flight)
                    hand_over = partial(self._hand_over, request.flight)
                    self._flights.upload(request, hand_over, name, "survey" in self._latest)
                case requests.Start():
                    await self._flights.start(request)
                case requests.Find():
                    latitude, longitude = place_of(request.place)
                    window.put_nowait(as_json(Found(place=(longitude, latitude), words=request.place.strip())))
                case requests.Listen():
                    self._flights.listen(request.link)
                case requests.Order():
                    await self._flights.order(request)
        except MissionError as error:
            of_flight = isinstance(request, requests.Upload | requests.Start | requests.Order | requests.Listen)
            of: Literal["flight", "edit"] = "flight" if of_flight else "edit"
            window.put_nowait(as_json(Trouble(of=of, message=str(error), hint=error.hint)))
            window.put_nowait(as_json(self.document.as_answer()))

    def _do(self, request: requests.Do) -> None:
        document = self.document
        match request.what:
            case "undo" | "redo":
                self._changed(document.step(-1 if request.what == "undo" else 1))
            case "save" | "save_over":
                document.save(over=request.what == "save_over")
                self.send_all(document.as_answer())
            case "take_theirs":
                self._changed(document.take_theirs())
            case "plan":
                self._start("plan", self._plan)
            case "cancel":
                self._stop("plan")
                self.send_all(Trouble(of="plan", message="planning was cancelled", revision=document.revision))
            case "export":
                self._expect_proved()
                order = {"job": "write", "folder": str(self.folder)}
                self._start("write", partial(self._ask, self._thorough, order))
            case "detach":
                self._expect_proved()
                self._start("write", partial(self._detach, request.flight))
            case "abandon":
                self._flights.abandon()

    def _opened(self, mission: Path) -> Redirect:
        assert self.open_file is not None, "the server opens files"
        token = self.open_file(mission, None if self.document.is_mission else self.document.path, None)
        return Redirect(address=f"../{token}/")

    def _changed(self, different: bool) -> None:
        if different:
            self.send_all(self.document.as_answer())
            self._follow()

    def _follow(self) -> None:
        self._forget(*OBSOLETE)
        self._stop("plan")
        self._stop("contingencies")
        self._job("look", self._look)
        if not self.document.is_mission:
            self._start("plan", self._plan_when_idle)

    async def _look(self) -> None:
        shown = -1
        while shown != self.document.revision:
            shown = self.document.revision
            if self.document.is_mission:
                await self._judge()
            elif not await self._ask(self._quick, {"job": "look"}):
                self._stop("plan")
            elif shown == self.document.revision:
                await self._ask(self._quick, {"job": "sketch", "number": None, "changes": []})
        if self.document.is_mission and "plan" in self._latest:
            self._start("contingencies", self._show_contingencies)

    async def _judge(self) -> None:
        worlds = sorted(str(path) for path in await asyncio.to_thread(list, self.folder.glob("*.toml")))
        if self.world is not None and str(self.world) not in worlds:
            worlds = [str(self.world), *worlds]
        log = None if self.log is None else str(self.log)
        await self._ask(self._quick, {"job": "judge", "worlds": worlds, "log": log})

    @property
    def _planner(self) -> Process:
        return self._quick if self.document.is_mission else self._thorough

    async def _answer_drags(self) -> None:
        while self._drags:
            window, drag = self._drags.popitem()
            changes = [change.model_dump(mode="json") for change in drag.changes]
            order = {"job": "sketch", "number": drag.number, "changes": changes}
            await self._ask(self._quick, order, window.put_nowait)

    async def _plan_when_idle(self) -> None:
        await self._thorough.start()
        await asyncio.sleep(SETTLE_TIME_S)
        await self._plan()

    async def _plan(self) -> None:
        self._forget("trouble of plan", "contingencies")
        self._stop("contingencies")
        order = {"job": "plan", "seed": self.seed, "flown": [str(log) for log in self._flown]}
        if await self._ask(self._thorough, order):
            self._start("contingencies", self._show_contingencies)

    async def _show_contingencies(self) -> None:
        flights = self._latest["survey"]["flights"] if "survey" in self._latest else [None]
        for flight in range(len(flights)):
            await self._ask(self._planner, {"job": "contingencies", "flight": flight})

    async def _detach(self, flight: int) -> None:
        target = unused(self.folder / f"{self._name_of(flight)}-edited.plan")
        if await self._ask(self._thorough, {"job": "detach", "file": str(target), "flight": flight}):
            self.send_all(self._opened(target))

    async def _hand_over(self, flight: int, file: Path) -> bool:
        return await self._ask(self._planner, {"job": "hand over", "file": str(file), "flight": flight})

    def _name_of(self, flight: int) -> str:
        if "survey" not in self._latest:
            return self.document.path.stem
        flights = self._latest["survey"]["flights"]
        if not flight < len(flights):
            raise MissionError(f"expected one of {len(flights)}", code="no-such-item", place=f"flight {flight + 1}")
        return str(flights[flight]["plan"]["name"])

    def _expect_ready(self) -> None:
        if not self.document.is_mission:
            self._expect_proved()
            return
        checked = self._latest.get("checked")
        if checked is None or checked["revision"] != self.document.revision:
            raise MissionError("the current mission is not checked yet", hint="wait for the check", code="not-checked")
        if checked["timeless"] is not None:
            raise MissionError(f"it cannot be flown: {checked['timeless']}", code="no-time")

    def _expect_proved(self) -> None:
        revisions = {self._latest[kind]["revision"] for kind in ("plan", "survey") if kind in self._latest}
        if self.document.revision not in revisions:
            words = "there is no proved plan of the current scenario"
            raise MissionError(words, hint="wait for it, or correct the scenario", code="not-planned")

    async def _ask(
        self, process: Process, order: dict[str, Any], send: Callable[[dict[str, Any]], None] | None = None
    ) -> bool:
        """Return whether the answers had no error."""
        document = self.document
        about = {"text": document.text, "path": str(document.path), "revision": document.revision}
        judged_by = {"world": None if self.world is None else str(self.world), "autopilot": document.autopilot}
        return await process.ask(about | judged_by | order, send or self.send_all)

    def _job(self, name: str, work: Work) -> None:
        if name not in self._jobs or self._jobs[name].done():
            self._jobs[name] = asyncio.create_task(work())

    def _start(self, name: str, work: Work) -> None:
        self._stop(name)
        self._jobs[name] = asyncio.create_task(work())

    def _stop(self, name: str) -> None:
        if name in self._jobs:
            self._jobs[name].cancel()

    async def look_after(self, step_s: float) -> None:
        """Follow the file, and close the planners after `ALONE_LIMIT_S` without a window."""
        revision = self.document.revision
        if self.document.look_at_disk():
            self.send_all(self.document.as_answer())
            if self.document.revision != revision:
                self._follow()
        self._alone_s = 0.0 if self._windows or self._flights.is_busy else self._alone_s + step_s
        if ALONE_LIMIT_S <= self._alone_s < ALONE_LIMIT_S + step_s:
            await self._close_planners()
            self._forget(*OBSOLETE, "world", "mission")

    async def close(self) -> None:
        await asyncio.gather(self._flights.close(), self._close_planners())

    async def _close_planners(self) -> None:
        for name in self._jobs:
            self._stop(name)
        await asyncio.gather(self._quick.close(), self._thorough.close())
        await asyncio.gather(*self._jobs.values(), return_exceptions=True)

    def _forget(self, *names: str) -> None:
        self._latest = {
            slot: answer for slot, answer in self._latest.items() if slot not in names and answer["kind"] not in names
        }


def _slot(answer: dict[str, Any]) -> str:
    of = {"trouble": "of", "contingencies": "flight"}.get(answer["kind"])
    return str(answer["kind"]) if of is None else f"{answer['kind']} of {answer[of]}"
