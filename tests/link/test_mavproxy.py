import importlib.util
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.messages import MissionType

MAVPROXY = Path(sys.executable).parent / "mavproxy.py"
pytestmark = [
    pytest.mark.skipif(importlib.util.find_spec("MAVProxy") is None, reason="MAVProxy is not installed"),
    pytest.mark.skipif(not MAVPROXY.exists(), reason="there is no mavproxy.py beside this Python"),
]

MISSION = """QGC WPL 110
0\t1\t0\t16\t0\t0\t0\t0\t47.4\t8.5\t400\t1
1\t0\t3\t22\t0\t0\t0\t0\t47.4\t8.5\t20\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.4004\t8.5\t30\t1
3\t0\t3\t16\t0\t0\t0\t0\t47.4008\t8.5\t30\t1
4\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1
"""
FENCE = """QGC WPL 110
0\t0\t3\t5003\t500\t0\t0\t0\t47.4\t8.5\t0\t1
"""
RALLY = "RALLY 47.4005 8.5 25.0 20.0 0.0 0\n"


class Console:
    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self._lines: queue.Queue[str] = queue.Queue()
        self._heard: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line)

    def say(self, command: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()

    def expect(self, words: str, seconds: float = 120.0) -> str:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            try:
                line = self._lines.get(timeout=0.1)
            except queue.Empty:
                continue
            self._heard.append(line)
            if words in line:
                return line
        raise AssertionError(f"{words!r} did not come; MAVProxy said:\n{''.join(self._heard)}")


@contextmanager
def console(port: int, folder: Path) -> Iterator[Console]:
    modules = "wp,param,mode,arm,misc,fence,rally,cmdlong"
    command = [sys.executable, "-u", str(MAVPROXY), f"--master=udpout:127.0.0.1:{port}"]
    with subprocess.Popen(
        [*command, f"--state-basedir={folder}", f"--default-modules={modules}"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=folder,
        env={"HOME": str(folder), "PATH": "/usr/bin:/bin"},
    ) as process:
        try:
            yield Console(process)
        finally:
            process.kill()


def test_mavproxy_reads_parameters_and_uploads_lists_and_flies_a_mission(
    run_mock: Callable[..., object], tmp_path: Path
) -> None:
    (tmp_path / "mission.txt").write_text(MISSION)
    (tmp_path / "fence.txt").write_text(FENCE)
    (tmp_path / "rally.txt").write_text(RALLY)
    with (
        run_mock(Autopilot.ARDUPILOT, speedup=20.0) as running,  # type: ignore[attr-defined]  # as much as MAVProxy reads
        console(running.port, tmp_path) as mavproxy,
    ):
        mavproxy.expect(f"Received {len(running.mock.table.values)} parameters")
        for name in ("GPS_RAW_INT", "GLOBAL_POSITION_INT", "VFR_HUD", "MISSION_CURRENT", "BATTERY_STATUS"):
            mavproxy.say(f"status {name}")  # it asks for them with REQUEST_DATA_STREAM
            mavproxy.expect(f": {name} {{")
        mavproxy.say("wp load mission.txt")
        mavproxy.expect("MISSION_ACK: TYPE_MISSION: ACCEPTED")
        mavproxy.say("wp list")
        mavproxy.expect("Saved 5 waypoints")
        mavproxy.say("fence load fence.txt")
        mavproxy.expect("TYPE_FENCE: ACCEPTED")
        mavproxy.say("rally load rally.txt")
        mavproxy.expect("TYPE_RALLY: ACCEPTED")
        mavproxy.say("fence list")
        mavproxy.say("rally list")
        mavproxy.expect("47.40050")
        mavproxy.say("wp set 1")
        mavproxy.expect("DO_SET_MISSION_CURRENT: ACCEPTED")
        mavproxy.say("arm throttle")
        mavproxy.expect("ARMED")
        mavproxy.say("mode auto")
        mavproxy.say("long MISSION_START 0 0 0 0 0 0 0")
        mavproxy.expect("Mode AUTO")
        mavproxy.expect("Reached command #3")
        mavproxy.expect("DISARMED")
        stores = running.mock.transfers.stores
        assert [len(stores[kind].items) for kind in (MissionType.MISSION, MissionType.FENCE, MissionType.RALLY)] == [
            5,
            1,
            1,
        ]
        mavproxy.say("wp clear")
        mavproxy.expect("MISSION_ACK: TYPE_MISSION: ACCEPTED")
        assert stores[MissionType.MISSION].items == ()
