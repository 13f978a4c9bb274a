"""Run a worker process that may be slow, be cancelled, or crash without the server.

One JSON object a line: a job `{"id", "job", ...}`, answers `{"id", "answer"}`, the end `{"id", "done": true}`.
`{"cancel": id}` cancels; other lines go to the running job.
"""

import _thread
import json
import os
import queue
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, TypeAlias

from ipoa_mission.errors import MissionError
from ipoa_mission.studio.answers import Trouble
from ipoa_mission.studio.vocabulary import PageMessage, as_on_map

Order: TypeAlias = dict[str, Any]
Answer: TypeAlias = Callable[[PageMessage], None]
Job: TypeAlias = Callable[[Order, Answer], None]
Subject: TypeAlias = Literal["scenario", "sketch", "plan", "file", "flight"]


class JobCancelled(BaseException):
    """A BaseException, so that no library catches it."""


class Harness:
    """Do jobs one after the other in the main thread; another thread reads cancellations."""

    def __init__(self, jobs: Mapping[str, tuple[Job, Subject]], tell: Callable[[Order], None]) -> None:
        self._known = jobs
        self._tell = tell
        self._jobs: queue.SimpleQueue[Order | None] = queue.SimpleQueue()
        self.beside: queue.SimpleQueue[Order] = queue.SimpleQueue()
        self._current: int | None = None
        self._is_cancelled = False
        self._lock = threading.Lock()

    def listen(self, lines: Iterable[str]) -> None:
        for line in lines:
            order = json.loads(line)
            if "cancel" in order:
                self._cancel(order["cancel"])
            elif "job" in order:
                self._jobs.put(order)
            else:
                self.beside.put(order)
        self._jobs.put(None)
        self._cancel(self._current)

    def run(self) -> None:
        signal.signal(signal.SIGINT, self._interrupted)
        while (order := self._jobs.get()) is not None:
            try:
                with self._lock:
                    self._current, self._is_cancelled = order["id"], False
                self._do(order)
            except (JobCancelled, SystemError):  # compiled code raises SystemError when interrupted
                if not self._is_cancelled:
                    raise
            finally:
                with self._lock:
                    self._current = None
            self._tell({"id": order["id"], "done": True})

    def _cancel(self, number: int | None) -> None:
        with self._lock:
            if number is not None and number == self._current:
                self._is_cancelled = True
                _thread.interrupt_main(signal.SIGINT)

    def _interrupted(self, *_: object) -> None:
        if self._current is not None:
            raise JobCancelled

    def _do(self, order: Order) -> None:
        def answer(message: PageMessage) -> None:
            self._tell({"id": order["id"], "answer": message.model_dump(mode="json")})

        job, subject = self._known[order["job"]]
        try:
            job(order, answer)
        except MissionError as error:
            answer(Trouble(of=subject, message=as_on_map(str(error)), hint=error.hint, revision=order.get("revision")))


def work(make_jobs: Callable[[queue.SimpleQueue[Order]], Mapping[str, tuple[Job, Subject]]]) -> None:
    """Work for the parent process; `make_jobs` gets the queue of lines for the running job."""
    channel = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8", newline="\n")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # a library's prints are no answers
    lock = threading.Lock()

    def tell(message: Order) -> None:
        with lock:
            channel.write(json.dumps(message, allow_nan=False) + "\n")
            channel.flush()

    jobs: dict[str, tuple[Job, Subject]] = {}
    harness = Harness(jobs, tell)
    jobs.update(make_jobs(harness.beside))
    threading.Thread(target=harness.listen, args=(sys.stdin,), daemon=True).start()
    harness.run()
