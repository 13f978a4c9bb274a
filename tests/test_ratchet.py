"""Hold the counts of `tools.census` to their limits; .ci/ratchet compares these with those of the parent commit."""

import os
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

from tools.census import COUNTS

REPOSITORY = Path(__file__).parent.parent
LIMITS = tomllib.loads((Path(__file__).parent / "ratchet.toml").read_text(encoding="utf-8"))


def test_every_count_has_a_limit() -> None:
    assert LIMITS.keys() == COUNTS.keys()


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_a_count_does_not_rise(name: str) -> None:
    counted = sum(1 for _ in COUNTS[name]())
    assert counted <= LIMITS[name], f"see: python -m tools.census --where {name}"


@pytest.mark.parametrize("script", ["ratchet", "subjects"])
@pytest.mark.parametrize(("allowed", "code"), [("", 1), ("1", 0)])
def test_missing_history_fails_unless_it_is_allowed(script: str, allowed: str, code: int, tmp_path: Path) -> None:
    (tmp_path / ".ci").mkdir()
    copied = shutil.copy(REPOSITORY / ".ci" / script, tmp_path / ".ci")
    environment = os.environ | {"ALLOW_NO_HISTORY": allowed, "GIT_CEILING_DIRECTORIES": str(tmp_path.parent)}
    ended = subprocess.run([copied], env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.partition(":")[0]) == (code, "no history")
