"""MAVSDK's file import as an oracle, started once."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot


class MavsdkImport:
    """Asks `mavsdk_import.py` in a process of its own: MAVSDK keeps threads."""

    def __init__(self) -> None:
        script = Path(__file__).with_name("mavsdk_import.py")
        self.process = subprocess.Popen(
            [sys.executable, str(script)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self._heard() == {"ready": ["ardupilot", "px4"]}

    def read(self, text: str, kind: str, autopilot: Autopilot) -> dict[str, Any]:
        """`mission`, `fence` and `rally` as lists of the fields of MISSION_ITEM_INT, or `error`."""
        assert self.process.stdin
        self.process.stdin.write(json.dumps({"autopilot": str(autopilot), "kind": kind, "text": text}) + "\n")
        self.process.stdin.flush()
        return self._heard()

    def close(self) -> None:
        self.process.communicate(timeout=120)

    def _heard(self) -> dict[str, Any]:
        assert self.process.stdout
        return json.loads(self.process.stdout.readline())


@pytest.fixture(scope="session")
def mavsdk() -> Iterator[MavsdkImport]:
    pytest.importorskip("mavsdk")
    oracle = MavsdkImport()
    yield oracle
    oracle.close()
