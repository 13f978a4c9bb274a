"""Upload a mission by each client to a vehicle at a UDP port; run as a module: one client process."""

import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.errors import MissionError
from ipoa_mission.link import connect as link_connect
from ipoa_mission.link import mavsdk_backend
from ipoa_mission.link.messages import MissionType
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.stored_mission import to_wire
from tools.benchmarks.link_benchmark.vehicle import mission

LIMIT_S = 240.0


class NotConnected(Exception):
    """Raised if the client does not connect."""


def ours(port: str, sent: Mission, fast: bool = False) -> tuple[bool, float, float | None]:
    """Upload by our client, in the client's process; `fast`: as ArduPilot's mission file."""
    acknowledged: list[float] = []

    def note(share: float, words: str) -> None:
        if share == 1 and not acknowledged:
            acknowledged.append(time.monotonic())

    link_connect.PRESENCE_S = 60.0
    with link_connect.connect(f"udpout:127.0.0.1:{port}", fast=fast) as here:
        items = to_wire(sent)
        begun = time.monotonic()
        try:
            here.upload_items(items, MissionType.MISSION, note)
        except MissionError:
            return False, LIMIT_S, None
        verified = time.monotonic()
    return True, (acknowledged or [verified])[0] - begun, verified - begun


def by_file(port: str, sent: Mission) -> tuple[bool, float, float | None]:
    """Upload by our fast path: its time ends with the last piece written, its bytes include reading back."""
    return ours(port, sent, fast=True)


def mavsdk(port: str, sent: Mission) -> tuple[bool, float, float | None]:
    """Upload by MAVSDK, in the client's process."""
    mavsdk_backend.PRESENCE_S = 60.0
    with mavsdk_backend.connect(f"udpout:127.0.0.1:{port}") as here:
        assert isinstance(here, mavsdk_backend.MavsdkVehicle)
        rows = [here._mavsdk_item(seq, item, 0) for seq, item in enumerate(to_wire(sent))]
        begun = time.monotonic()
        try:
            here._raw.upload_mission(rows)
        except here._refused:
            return False, LIMIT_S, None
        return True, time.monotonic() - begun, None


def mavproxy(port: int, sent: Mission) -> tuple[bool, float, float | None]:
    """Upload by MAVProxy, in a process of its own, from a file with seven decimals."""
    rows = ["QGC WPL 110"]
    wire = to_wire(sent)
    for seq, item in enumerate(wire):
        place = f"{item.latitude_deg:.7f}\t{item.longitude_deg:.7f}\t{item.altitude:.6f}"
        rows.append(f"{seq}\t{int(seq == 0)}\t{item.frame}\t{item.command}\t0\t0\t0\t0\t{place}\t1")
    script = Path(sys.executable).parent / "mavproxy.py"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.txt"
        path.write_text("\n".join(rows) + "\n")
        command = [sys.executable, "-u", str(script), f"--master=udpout:127.0.0.1:{port}"]
        with subprocess.Popen(
            [*command, f"--state-basedir={folder}", "--default-modules=wp"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
            env={**os.environ, "HOME": folder},
        ) as process:
            lines: queue.Queue[str] = queue.Queue()
            assert process.stdout is not None
            assert process.stdin is not None
            threading.Thread(target=lambda: [*map(lines.put, process.stdout or ())], daemon=True).start()
            try:
                if not _until(lines, "online system", 60.0):
                    raise NotConnected("MAVProxy heard nobody")
                begun = time.monotonic()
                process.stdin.write(f"wp load {path}\n")
                process.stdin.flush()
                said = _until(lines, "MISSION_ACK: TYPE_MISSION: ACCEPTED", 60.0)
                return said, time.monotonic() - begun, None
            finally:
                process.kill()


def _until(lines: "queue.Queue[str]", words: str, seconds: float) -> bool:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        try:
            if words in lines.get(timeout=0.05):
                return True
        except queue.Empty:
            continue
    return False


if __name__ == "__main__":
    act = {"ours": ours, "by-file": by_file, "mavsdk": mavsdk}[sys.argv[1]]
    for asked in sys.stdin:
        port, family, count = asked.split()
        result = act(port, mission(autopilot_named(family), int(count)))
        sys.stderr.write("\nRESULT " + json.dumps(result) + "\n")
        sys.stderr.flush()
