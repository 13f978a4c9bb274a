"""The table of MAVLink's messages: as a wheel carries it, and as pymavlink has it."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ipoa_mission.errors import MissionError
from ipoa_mission.link import definitions
from tools import REPOSITORY

#: All that a definition says, in a process that has the package in its folder, with or without pymavlink.
SAID = """
import json, sys
if sys.argv[1] == "without":
    sys.modules["pymavlink"] = None
from ipoa_mission.errors import MissionError
try:
    from ipoa_mission.link.definitions import DEFINITIONS
except MissionError as error:
    sys.exit(f"{error}; {error.hint}")
print(json.dumps([[d.number, d.name, d.layout.format, d.names, d.lengths, d.crc_extra] for d in DEFINITIONS.values()]))
"""


def said(folder: Path, how: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", SAID, how]
    return subprocess.run(command, cwd=folder, env={}, capture_output=True, text=True, check=False)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    leave_out = shutil.ignore_patterns(definitions.TABLE, "node_modules", "__pycache__", "*.bin")
    shutil.copytree(REPOSITORY / "ipoa_mission", tmp_path / "ipoa_mission", ignore=leave_out)
    return tmp_path


def test_the_table_of_a_wheel_says_what_pymavlink_says(checkout: Path) -> None:
    pymavlink = said(checkout, "with")
    (checkout / "ipoa_mission" / "link" / definitions.TABLE).write_text(json.dumps(definitions.rows()))
    table = said(checkout, "without")
    assert (pymavlink.returncode, table.returncode) == (0, 0), pymavlink.stderr + table.stderr
    assert json.loads(table.stdout) == json.loads(pymavlink.stdout)
    assert len(json.loads(table.stdout)) > 250


def test_without_table_and_pymavlink_the_error_names_the_way_out(checkout: Path) -> None:
    neither = said(checkout, "without")
    assert neither.returncode == 1
    assert "no table of MAVLink's messages, and pymavlink is not installed; pip install pymavlink" in neither.stderr


def test_a_table_that_is_not_there_is_pymavlinks_or_an_error_that_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    table = json.loads(json.dumps(definitions._table()))
    monkeypatch.setattr(definitions, "TABLE", "nowhere.json")
    assert json.loads(json.dumps(definitions._table())) == table
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    with pytest.raises(MissionError, match="no table of MAVLink's messages, and pymavlink is not installed"):
        definitions.rows()


def test_a_table_that_is_there_is_taken_as_it_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    table = json.loads(json.dumps(definitions.rows()))[:3]
    (tmp_path / definitions.TABLE).write_text(json.dumps(table))
    monkeypatch.setattr(definitions, "__file__", str(tmp_path / "definitions.py"))
    assert definitions._table() == table
