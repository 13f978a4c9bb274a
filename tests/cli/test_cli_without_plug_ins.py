"""The command line works without the rooms that entry points name."""

import subprocess
import sys
from pathlib import Path

import pytest

GONE = """
import importlib.metadata, sys
ROOM = sys.argv.pop(1)

class Gone:
    def find_spec(self, name, path=None, target=None):
        if name.startswith(f"ipoa_mission.{ROOM}"):
            raise ImportError(name)

sys.meta_path.insert(0, Gone())
every = importlib.metadata.entry_points
importlib.metadata.entry_points = lambda **asked: [
    entry for entry in every(**asked) if not entry.value.startswith(f"ipoa_mission.{ROOM}")
]
from ipoa_mission.cli.app import main
main()
"""


@pytest.mark.parametrize("room", ["learn", "paper", "studio"])
def test_a_room_can_be_taken_out(room: str, missions: Path, tmp_path: Path) -> None:
    def run(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", GONE, room, *words]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)

    verb = "reproduce" if room == "paper" else room
    assert f"│ {verb} " not in run("--help").stdout
    assert run(verb).returncode == 2
    planned = run("plan", str(missions / "sitl.toml"))
    assert planned.returncode == 0, planned.stderr
    assert run("check", "sitl.plan", "--scenario", str(missions / "sitl.toml")).returncode == 0
