"""The command line works without the rooms that entry points name."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import pytest

from tests.cli.conftest import Outcome
from tests.cli.test_surveying import SCENARIO

REPOSITORY = Path(__file__).parents[2]
#: Runs the command of each line of its input, in the folder that the line names.
GONE = """
import contextlib, io, json, os, sys
ROOM = sys.argv.pop(1)

class Gone:
    def find_spec(self, name, path=None, target=None):
        if name.startswith(f"ipoa_mission.{ROOM}"):
            raise ImportError(name)

sys.meta_path.insert(0, Gone())
from ipoa_mission import files
every = files.plug_ins
files.plug_ins = lambda group: [
    entry for entry in every(group) if not entry.value.startswith(f"ipoa_mission.{ROOM}")
]
from ipoa_mission.cli.app import main
from tests.quick_search import search_quickly
search_quickly()
for line in sys.stdin:
    folder, words = json.loads(line)
    os.chdir(folder)
    sys.argv[1:], said = words.split(), (io.StringIO(), io.StringIO())
    with contextlib.redirect_stdout(said[0]), contextlib.redirect_stderr(said[1]):
        try:
            main()
        except SystemExit as ended:
            code = ended.code or 0
    print(json.dumps([code, *(stream.getvalue() for stream in said)]), flush=True)
"""

Run = Callable[..., list[Outcome]]


@pytest.fixture(scope="module")
def without() -> Iterator[Callable[[str], subprocess.Popen[str]]]:
    """Start a process without a room, once for all tests."""
    with ExitStack() as started:

        @cache
        def process(room: str) -> subprocess.Popen[str]:
            command = [sys.executable, "-c", GONE, room]
            pipe, seen = subprocess.PIPE, os.environ | {"PYTHONPATH": str(REPOSITORY)}
            return started.enter_context(subprocess.Popen(command, stdin=pipe, stdout=pipe, env=seen, text=True))

        yield process


@pytest.fixture
def run(tmp_path: Path, without: Callable[[str], subprocess.Popen[str]]) -> Run:
    """Run commands without a room."""

    def run_without(room: str, *commands: str) -> list[Outcome]:
        process = without(room)
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.writelines(json.dumps([str(tmp_path), words]) + "\n" for words in commands)
        process.stdin.flush()
        return [Outcome(*json.loads(process.stdout.readline())) for _ in commands]

    return run_without


@pytest.mark.parametrize("room", ["fleet", "learn", "paper", "studio", "survey"])
def test_a_room_can_be_taken_out(room: str, missions: Path, run: Run) -> None:
    verb = {"paper": "reproduce", "fleet": "deconflict"}.get(room, room)
    plan, check = (f"{verb} {missions / 'sitl.toml'}" for verb in ("plan", "check sitl.plan --scenario"))
    usage, unknown, *others = run(room, "--help", verb, plan, check, "show sitl.plan")
    assert f"│ {verb} " not in usage.out
    assert unknown.code == 2
    assert [(outcome.code, outcome.err) for outcome in others] == [(0, "")] * 3


def test_a_survey_is_refused_without_its_room(run: Run, tmp_path: Path) -> None:
    (tmp_path / "field.toml").write_text(SCENARIO)
    usage, *refused = run("survey", "plan --help", "plan field.toml", "fly field.toml")
    assert "--survey" not in usage.out
    assert "--survey" in run("learn", "plan --help")[0].out
    for ended in refused:
        assert (ended.code, ended.out) == (2, "")
        assert "field.toml: survey: unknown key" in ended.err
        assert "Traceback" not in ended.err
    assert [path.name for path in tmp_path.iterdir()] == ["field.toml"]
