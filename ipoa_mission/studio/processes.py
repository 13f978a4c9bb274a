"""Worker processes: a job may be slow, be cancelled, or crash without the server.

One JSON object a line: a job `{"id", "job", ...}`, answers `{"id", "answer"}`, the end `{"id", "done": true}`.
`{"cancel": id}` cancels; other lines go to the running job.
"""

import _thread
import asyncio
import json
import os
import queue
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

from ipoa_mission import MissionError
from ipoa_mission.studio.answers import Trouble
from ipoa_mission.studio.vocabulary import PageMessage, as_json, as_on_map

JobOrder: TypeAlias = dict[str, Any]
Answer: TypeAlias = Callable[[PageMessage], None]
Job: TypeAlias = Callable[[JobOrder, Answer], None]
Subject: TypeAlias = Literal["scenario", "sketch", "plan", "file", "flight"]
MakeJobs: TypeAlias = "Callable[[queue.SimpleQueue[JobOrder]], Mapping[str, tuple[Job, Subject]]]"


@dataclass(eq=False)
class Process:
    """One job at a time; a worker that dies is restarted, and its job is answered by `died`."""

    module: str
    died: Trouble
    _number: int = 0
    _process: asyncio.subprocess.Process | None = None
    _one_at_a_time: asyncio.Lock = field(default_factory=asyncio.Lock)

    async def start(self) -> None:
        if self._process is None or self._process.returncode is not None:
            pipe = asyncio.subprocess.PIPE
            limit = 256 * 1024 * 1024  # of an answer [bytes]
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", self.module, stdin=pipe, stdout=pipe, limit=limit
            )

    async def ask(self, order: dict[str, Any], hear: Callable[[dict[str, Any]], None]) -> bool:
        """Send a job, and call `hear` with every answer; return whether there was no trouble. Pass on cancellation."""
        async with self._one_at_a_time:
            await self.start()
            self._number += 1
            await self.send(order | {"id": self._number})
            cancelled = False
            went_well = True
            while True:
                try:
                    line = await self._line()
                except asyncio.CancelledError:
                    cancelled = True
                    await self.send({"cancel": self._number})
                    continue
                if line.get("id") != self._number:
                    continue
                if "answer" in line and not cancelled:
                    answer = line["answer"]
                    went_well = went_well and (answer["kind"] != "trouble" or answer["of"] == "edit")
                    hear(answer)
                if "done" in line:
                    break
            if cancelled:
                raise asyncio.CancelledError
            return went_well

    async def send(self, order: dict[str, Any]) -> None:
        if self._process is not None and self._process.stdin is not None:
            with suppress(ConnectionError):
                self._process.stdin.write(json.dumps(order).encode() + b"\n")
                await self._process.stdin.drain()

    async def close(self) -> None:
        process = self._process
        self._process = None
        if process is not None and process.returncode is None:
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()

    async def _line(self) -> Any:
        process = self._process
        if process is not None and process.stdout is not None:
            while text := await process.stdout.readline():
                if text.startswith(b"{"):  # a library's prints
                    return json.loads(text)
            await process.wait()
        return {"id": self._number, "answer": as_json(self.died), "done": True}


class JobCancelled(BaseException):
    """A BaseException, so that no library catches it."""


class Worker:
    """Do jobs in turn in the main thread, made with a queue of lines; another thread reads cancellations."""

    def __init__(self, make_jobs: MakeJobs) -> None:
        self._channel = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8", newline="\n")
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # a library's prints are no answers
        self._orders: queue.SimpleQueue[JobOrder | None] = queue.SimpleQueue()
        self._inbox: queue.SimpleQueue[JobOrder] = queue.SimpleQueue()
        self._jobs = make_jobs(self._inbox)
        self._current: int | None = None
        self._is_cancelled = False
        self._lock = threading.Lock()

    def listen(self) -> None:
        for line in sys.stdin:
            order = json.loads(line)
            if "cancel" in order:
                self._cancel(order["cancel"])
            elif "job" in order:
                self._orders.put(order)
            else:
                self._inbox.put(order)
        self._orders.put(None)
        self._cancel(self._current)

    def run(self) -> None:
        signal.signal(signal.SIGINT, self._interrupted)
        threading.Thread(target=self.listen, daemon=True).start()
        while (order := self._orders.get()) is not None:
            try:
                with self._lock:
                    self._current = order["id"]
                    self._is_cancelled = False
                self._do(order)
            except (JobCancelled, SystemError):  # compiled code raises SystemError when interrupted
                if not self._is_cancelled:
                    raise
            finally:
                with self._lock:
                    self._current = None
            self._write({"id": order["id"], "done": True})

    def _cancel(self, number: int | None) -> None:
        with self._lock:
            if number is not None and number == self._current:
                self._is_cancelled = True
                _thread.interrupt_main(signal.SIGINT)

    def _interrupted(self, *_: object) -> None:
        if self._current is not None:
            raise JobCancelled

    def _do(self, order: JobOrder) -> None:
        def answer(message: PageMessage) -> None:
            answered = message.model_dump(mode="json")
            if "revision" in answered:
                answered["revision"] = order.get("revision")
            self._write({"id": order["id"], "answer": answered})

        job, subject = self._jobs[order["job"]]
        try:
            job(order, answer)
        except MissionError as error:
            answer(Trouble(of=subject, message=as_on_map(str(error)), hint=error.hint))

    def _write(self, message: JobOrder) -> None:
        self._channel.write(json.dumps(message, allow_nan=False) + "\n")
        self._channel.flush()
