"""Uploads and flights of one document: one at a time, in a process of their own."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ipoa_mission import MissionError
from ipoa_mission.files import unused
from ipoa_mission.studio.answers import Trouble
from ipoa_mission.studio.flight_answers import State
from ipoa_mission.studio.processes import Process
from ipoa_mission.studio.requests import Order, Start, Upload
from ipoa_mission.studio.scenario_document import Document
from ipoa_mission.studio.vocabulary import PageMessage


class FlightDesk:
    def __init__(self, document: Document, send: Callable[[PageMessage | dict[str, Any]], None]) -> None:
        self._document = document
        self._send = send
        died = Trouble(of="flight", message="the flight worker ended unexpectedly", hint="look at the vehicle")
        self._process = Process("ipoa_mission.studio.flight_worker", died)
        self._task: asyncio.Task[Any] | None = None
        self._loaded: dict[str, Any] | None = None
        self._phase = "idle"
        self._batteries = BatteryGuard()

    def upload(
        self, request: Upload, hand_over: Callable[[Path], Awaitable[bool]], name: str, is_survey: bool = False
    ) -> None:
        """Upload the plan (first step); `hand_over` writes it to a file."""
        self._expect_free("a flight is under way", "let it end, or stop watching it")
        request = self._batteries.expect_charged(request, is_survey)
        self._loaded = None
        self._phase = "uploading"
        self._task = asyncio.create_task(self._fly(request, hand_over, name))

    def listen(self, link: str) -> None:
        self._expect_free("a flight is under way: no other link can be heard", "let it end")
        self._task = asyncio.create_task(self._process.ask({"job": "listen", "link": link}, self._send))

    @property
    def is_busy(self) -> bool:
        return self._task is not None and not self._task.done() and self._phase != "over"

    def _expect_free(self, words: str, hint: str) -> None:
        if self.is_busy:
            raise MissionError(words, hint=hint, code="flight-under-way")

    async def start(self, request: Start) -> None:
        """Arm and fly (second step), if nothing has changed."""
        if self._loaded is None:
            raise MissionError("not started: no mission is loaded", hint="upload first", code="upload-again")
        if self._loaded["revision"] != self._document.revision:
            words = "not started: the document was changed after the upload"
            raise MissionError(words, hint="upload again", code="upload-again")
        for key in ("vehicle", "mission", "proof"):
            requested = getattr(request, key)
            if requested != self._loaded[key]:
                words = f"not started: {key} is {self._loaded[key]!r}, not {requested!r}"
                raise MissionError(words, hint="upload again", code="upload-again")
        self._loaded = None
        await self._process.send(request.model_dump(mode="json"))

    async def order(self, request: Order) -> None:
        if self._phase != "flying":
            name = {"rtl": "return", "land": "landing", "go_on": "going on"}.get(request.what, request.what)
            words = f"{name} was not ordered: no vehicle is flying"
            raise MissionError(words, hint="start a flight first", code="not-in-the-air")
        await self._process.send(request.model_dump(mode="json"))

    def abandon(self) -> None:
        """Stop watching; a vehicle in the air flies on."""
        if self._task is not None:
            self._task.cancel()
        self._loaded = None

    async def close(self) -> None:
        self.abandon()
        await self._process.close()
        if self._task is not None:
            await asyncio.gather(self._task, return_exceptions=True)

    async def _fly(self, request: Upload, hand_over: Callable[[Path], Awaitable[bool]], name: str) -> None:
        log = unused(self._document.path.with_name(f"{name}.tlog"))
        revision = self._document.revision  # of this revision, even if the document changes

        def hear(answer: dict[str, Any]) -> None:
            self._batteries.hear(answer)
            if answer["kind"] == "loaded":
                self._loaded = answer
            if answer["kind"] == "state":
                self._phase = answer["phase"]
            self._send(answer)

        self._show(State(phase="uploading", words="getting the plan"))
        with TemporaryDirectory(prefix="ipoa-studio-") as folder:  # readable by this user only
            file = Path(folder) / "flight.pickle"
            if not await hand_over(file):
                self._show(State(phase="idle", words=""))
                return
            order = request.model_dump(mode="json")
            order |= {"job": "fly", "file": str(file), "revision": revision, "log": str(log)}
            try:
                went_well = await self._process.ask(order, hear)
            except asyncio.CancelledError:
                self._show(State(phase="idle", words="the flight is no longer watched"))
                raise
        if not went_well:
            self._show(State(phase="idle", words=f"every frame up to there is in {log.name}" if log.exists() else ""))

    def _show(self, state: State) -> None:
        self._phase = state.phase
        self._send(state)


@dataclass
class BatteryGuard:
    _link: str | None = None
    _systems: dict[str, int] = field(default_factory=dict)
    _loaded: str = ""
    _flown: str = ""

    def hear(self, answer: dict[str, Any]) -> None:
        if self._link is None:
            return
        if answer["kind"] == "loaded":
            self._loaded = answer["mission"]
            self._systems[self._link] = answer["system"]
        elif answer["kind"] == "state" and answer["phase"] == "flying":
            self._flown = self._loaded

    def expect_charged(self, request: Upload, is_survey: bool) -> Upload:
        """Return the upload for the same vehicle. Raises MissionError until a charged battery is confirmed."""
        if not is_survey or request.link is None:
            self._link = None
            return request
        if self._flown and not request.charged:
            words = f"expected a charged battery, not the one that flew {self._flown}"
            hint = "confirm that it is in, and that nobody is near the propellers"
            raise MissionError(words, hint=hint, code="battery-flown")
        self._flown = ""
        self._link = request.link
        return request.model_copy(update={"system": request.system or self._systems.get(request.link)})
