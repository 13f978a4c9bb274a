import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent


@pytest.mark.skipif(importlib.util.find_spec("osmium") is None, reason="osmium is not installed")
def test_extracts_are_read_in_a_process_without_minionpy() -> None:
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:xdist", "-p", "no:cacheprovider", "-o", "addopts="]
    where = [str(TESTS / "maps" / "test_pbf.py"), str(TESTS / "cli" / "test_maps.py")]
    run = subprocess.run([*words, "-m", "alone", *where], cwd=TESTS.parent, capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "passed" in run.stdout
    assert "skipped" not in run.stdout
