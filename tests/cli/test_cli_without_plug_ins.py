"""The command line works without the rooms that entry points name."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.test_cli_surveying import SCENARIO

GONE = """
import importlib.metadata, sys
ROOM = sys.argv.pop(1)

class Gone:
    def find_spec(self, name, path=None, target=None):
        if name.startswith(f"ipoa_mission.{ROOM}"):
            raise ImportError(name)

sys.meta_path.insert(0, Gone())
every = importlib.metadata.entry_points
importlib.metadata.entry_points = lambda **asked: every() if not asked else [  # numba asks for all
    entry for entry in every(**asked) if not entry.value.startswith(f"ipoa_mission.{ROOM}")
]
from ipoa_mission.cli.app import main
main()
"""


Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Run the command line without a room."""

    def without(room: str, *words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", GONE, room, *words]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)

    return without


@pytest.mark.parametrize("room", ["learn", "paper", "studio", "survey"])
def test_a_room_can_be_taken_out(room: str, missions: Path, run: Run) -> None:
    verb = "reproduce" if room == "paper" else room
    assert f"│ {verb} " not in run(room, "--help").stdout
    assert run(room, verb).returncode == 2
    planned = run(room, "plan", str(missions / "sitl.toml"))
    assert planned.returncode == 0, planned.stderr
    assert run(room, "check", "sitl.plan", "--scenario", str(missions / "sitl.toml")).returncode == 0
    assert run(room, "show", "sitl.plan").returncode == 0


def test_a_survey_is_refused_without_its_room(run: Run, tmp_path: Path) -> None:
    (tmp_path / "field.toml").write_text(SCENARIO)
    assert "--survey" not in run("survey", "plan", "--help").stdout
    assert "--survey" in run("learn", "plan", "--help").stdout
    for verb in ("plan", "fly"):
        refused = run("survey", verb, "field.toml")
        assert (refused.returncode, refused.stdout) == (2, "")
        assert "field.toml: survey: unknown key" in refused.stderr
        assert "Traceback" not in refused.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["field.toml"]
