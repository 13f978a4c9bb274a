import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot

MISSION = """QGC WPL 110
0\t1\t0\t16\t0\t0\t0\t0\t47.4\t8.5\t400\t1
1\t0\t3\t22\t0\t0\t0\t0\t47.4\t8.5\t20\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.4004\t8.5\t30\t1
3\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1
"""


def test_mavutil_and_mavwp_complete_a_session(run_mock: Callable[..., object], tmp_path: Path) -> None:
    path = tmp_path / "mission.txt"
    path.write_text(MISSION)
    rally = tmp_path / "rally.txt"
    rally.write_text("RALLY 47.4005 8.5 25.0 20.0 0.0 0\n")
    with run_mock(Autopilot.ARDUPILOT, speedup=60.0) as running:  # type: ignore[attr-defined]
        client = Path(__file__).parent / "mavutil_client.py"
        done = subprocess.run(
            [sys.executable, str(client), str(running.port), str(path), str(rally)],
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        report = json.loads(done.stdout.splitlines()[-1])
        assert report == {
            "results": [0, 0, 0],
            "parameters": len(running.mock.table.values),
            "commands": [[16, 22, 16, 20], [5001] * 3, [5100]],
            "reached": [1, 2, 3],
            "set": True,
            "silent": [],
        }
        assert running.mock.table.values["WPNAV_SPEED"] == 600.0
