"""Run clients in their own processes."""

import json
import subprocess
import sys
import threading

from ipoa_mission.mission.items import Mission
from tools import REPOSITORY
from tools.benchmarks.link_benchmark import clients
from tools.benchmarks.link_benchmark.clients import LIMIT_S, NotConnected


class Worker:
    """Run a client in its own process, one upload after the other."""

    def __init__(self, client: str) -> None:
        command = [sys.executable, "-m", clients.__name__, client]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=REPOSITORY
        )

    def upload(self, port: int, sent: Mission) -> tuple[bool, float, float | None]:
        """Return success, seconds to the Ack, seconds until verified.

        Raises:
            NotConnected: the client did not connect; the worker has ended.
        """
        pipe = self._process.stdin, self._process.stderr
        assert pipe[0] is not None
        assert pipe[1] is not None
        timer = threading.Timer(LIMIT_S + 60, self._process.kill)
        timer.start()
        pipe[0].write(f"{port} {sent.autopilot} {len(sent.items)}\n")
        pipe[0].flush()
        words = []
        for line in pipe[1]:
            if line.startswith("RESULT "):
                timer.cancel()
                said, seconds, verified_s = json.loads(line[7:])
                return said, seconds, verified_s
            words.append(line)
        is_late = not timer.is_alive()
        timer.cancel()
        if is_late:
            return False, LIMIT_S, None
        raise NotConnected("".join(words)[-500:])

    def close(self) -> None:
        with self._process:
            self._process.kill()


class Workers:
    """Use one worker a thread again, or a new one for each upload."""

    def __init__(self, client: str, is_reused: bool) -> None:
        self._client = client
        self._is_reused = is_reused
        self._mine = threading.local()
        self._all: list[Worker] = []

    def upload(self, port: int, sent: Mission) -> tuple[bool, float, float | None]:
        worker = getattr(self._mine, "worker", None) or Worker(self._client)
        self._mine.worker = worker
        self._all.append(worker)
        is_usable = False
        try:
            result = worker.upload(port, sent)
            is_usable = self._is_reused
            return result
        finally:
            if not is_usable:
                worker.close()
                self._mine.worker = None

    def close(self) -> None:
        for worker in self._all:
            worker.close()
