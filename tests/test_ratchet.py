"""Hold the counts of `tools.census` to their limits; .ci/ratchet compares these with those of the parent commit."""

import tomllib
from pathlib import Path

import pytest

from tools.census import COUNTS

LIMITS = tomllib.loads((Path(__file__).parent / "ratchet.toml").read_text(encoding="utf-8"))


def test_every_count_has_a_limit() -> None:
    assert LIMITS.keys() == COUNTS.keys()


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_a_count_does_not_rise(name: str) -> None:
    counted = sum(1 for _ in COUNTS[name]())
    assert counted <= LIMITS[name], f"see: python -m tools.census --where {name}"
