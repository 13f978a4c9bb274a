"""A process that plans for the studio: it may be slow, be told to stop, or crash, and the server lives on.

Its standard input and output carry a JSON object a line. A job is `{"id", "job", ...}`; what comes back is
`{"id", "answer"}`, and at the end `{"id", "done": true}`. `{"cancel": id}` breaks a job off.
"""

import _thread
import copy
import json
import os
import pickle
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from ipoa_mission.errors import MissionError
from ipoa_mission.flight import Flight, plan_flight
from ipoa_mission.planning.sketch import sketch_path
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.scenario.read import parse_toml, scenario_of
from ipoa_mission.studio.answers import Progress, Trouble
from ipoa_mission.studio.edits import apply_changes
from ipoa_mission.studio.planned import planned, sketched
from ipoa_mission.studio.requests import Change
from ipoa_mission.studio.view import world_of
from ipoa_mission.studio.vocabulary import Message

CHANGES: TypeAdapter[tuple[Change, ...]] = TypeAdapter(tuple[Change, ...])
TELL_EVERY_S = 0.1  # progress is told no more often


class Cancelled(BaseException):
    """The job is not wanted any more; no library may catch it by `except Exception`."""


class Worker:
    """Does jobs one after the other, in the main thread; another thread listens for what cancels them."""

    def __init__(self, tell: Callable[[dict[str, Any]], None]) -> None:
        self._tell = tell
        self._jobs: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._current: int | None = None
        self._lock = threading.Lock()
        self._flight: Flight | None = None

    def listen(self, lines: Any) -> None:
        """Take orders until there are no more."""
        for line in lines:
            order = json.loads(line)
            if "cancel" in order:
                with self._lock:
                    if order["cancel"] == self._current:
                        _thread.interrupt_main(signal.SIGINT)
            else:
                self._jobs.put(order)
        self._jobs.put(None)

    def run(self) -> None:
        """Work until there are no more orders."""
        signal.signal(signal.SIGINT, self._interrupted)
        while (order := self._jobs.get()) is not None:
            try:
                with self._lock:
                    self._current = order["id"]
                self._do(order)
            except Cancelled:
                pass
            finally:
                with self._lock:
                    self._current = None
            self._tell({"id": order["id"], "done": True})

    def _interrupted(self, *_: object) -> None:
        if self._current is not None:
            raise Cancelled

    def _do(self, order: dict[str, Any]) -> None:
        number, revision = order["id"], order.get("revision", 0)

        def answer(message: Message) -> None:
            self._tell({"id": number, "answer": message.model_dump(mode="json")})

        try:
            JOBS[order["job"]](self, order, answer)
        except MissionError as error:
            of = OF[order["job"]]
            answer(Trouble(of=of, message=str(error), hint=error.hint, revision=revision))

    def look(self, order: dict[str, Any], answer: Callable[[Message], None]) -> None:
        """What the map shows of a scenario."""
        answer(world_of(_scenario(order["text"], order["path"]), order["revision"]))

    def sketch(self, order: dict[str, Any], answer: Callable[[Message], None]) -> None:
        """A coarse path, of the scenario as it is or as it would be."""
        begun = time.perf_counter()
        if order["changes"]:
            table = copy.deepcopy(_table(order["text"], order["path"]))
            apply_changes(table, CHANGES.validate_python(order["changes"]))
            scenario = scenario_of(table, Path(order["path"]))
        else:
            scenario = _scenario(order["text"], order["path"])
        found = sketch_path(scenario)
        took = time.perf_counter() - begun
        answer(sketched(found, scenario, order["revision"], order["number"], took))

    def plan(self, order: dict[str, Any], answer: Callable[[Message], None]) -> None:
        """The proved flight."""
        revision, begun, told = order["revision"], time.perf_counter(), 0.0

        def progress(share: float, words: str) -> None:
            nonlocal told
            if time.perf_counter() - told > TELL_EVERY_S:
                told = time.perf_counter()
                answer(Progress(revision=revision, share=share, words=words))

        self._flight = None
        flight = plan_flight(_scenario(order["text"], order["path"]), order["seed"], progress=progress)
        self._flight = flight
        answer(planned(flight, revision, time.perf_counter() - begun))

    def write(self, order: dict[str, Any], answer: Callable[[Message], None]) -> None:
        """The flight's files, its report among them; or, with `pickle`, itself for another process of ours."""
        from ipoa_mission.studio.answers import Written

        flight, folder = self._expect_flight(), Path(order["folder"])
        if order["pickle"]:
            file = folder / "flight.pickle"
            file.write_bytes(pickle.dumps((flight.scenario, flight.mission, flight.estimate)))
            answer(Written(files=(str(file),)))
            return
        files = flight.write(folder)
        report = folder / f"{flight.name}.html"
        flight.report(report)
        answer(Written(files=tuple(str(file) for file in (*files, report))))

    def _expect_flight(self) -> Flight:
        if self._flight is None:
            raise MissionError("there is no proved plan", hint="plan first")
        return self._flight


JOBS = {"look": Worker.look, "sketch": Worker.sketch, "plan": Worker.plan, "write": Worker.write}
OF: dict[str, Any] = {"look": "scenario", "sketch": "sketch", "plan": "plan", "write": "file"}


@lru_cache(maxsize=4)
def _table(text: str, path: str) -> dict[str, Any]:
    return parse_toml(text, Path(path))


@lru_cache(maxsize=2)
def _scenario(text: str, path: str) -> Scenario:
    return parse_scenario(text, Path(path))


def main() -> None:
    """Work for whoever started this process."""
    channel = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8", newline="\n")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints is no answer
    lock = threading.Lock()

    def tell(message: dict[str, Any]) -> None:
        with lock:
            channel.write(json.dumps(message, allow_nan=False) + "\n")
            channel.flush()

    worker = Worker(tell)
    threading.Thread(target=worker.listen, args=(sys.stdin,), daemon=True).start()
    worker.run()


if __name__ == "__main__":
    main()
