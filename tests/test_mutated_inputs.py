from pathlib import Path

import pytest

from ipoa_mission.errors import BadInput
from tools.fuzz.mutated_inputs import KINDS, tries
from tools.fuzz.outcome import Reading, judge


@pytest.mark.parametrize("suffix", KINDS)
def test_no_change_is_lost_without_a_word(suffix: str) -> None:
    """`python -m tools.fuzz.mutated_inputs` tries 10,000."""
    count = {".plan": 120, ".waypoints": 60, ".params": 60}.get(suffix, 20)
    tried = list(tries(count, 39, (suffix,)))
    assert [(change, shown) for _, change, outcome, shown in tried if outcome == "lost"] == []
    assert "named" in {outcome for _, _, outcome, _ in tried}


@pytest.mark.long
def test_no_change_of_many_is_lost_without_a_word() -> None:
    assert [(suffix, change) for suffix, change, outcome, _ in tries(1500, 40) if outcome == "lost"] == []


def test_outcome_of_a_change_is_told(tmp_path: Path) -> None:
    """A reader of a file's first word, which names a second one only if "odd"."""

    def read(path: Path) -> Reading:
        first, *others = path.read_text().split()
        if first == "no":
            raise BadInput(f"{path}: expected a number")
        return Reading(int(first), frozenset(w for w in others if w == "odd"), lambda was, now: bool(now >= was))

    outcomes = [judge(tmp_path / "a", "5", after, read) for after in ("5 6", "no", "4 odd", "7", "4 even")]
    assert outcomes == ["same", "named", "named", "more cautious", "lost"]
