"""docs/tutorial.md does what it says: each of its commands is run, in order, and prints what stands below it."""

import shutil
from pathlib import Path

import pytest

from ipoa_mission.mission.files import read_mission
from tools.generate import tutorial

REPOSITORY = Path(__file__).parents[2]
#: How far a number may be from the one that stands in the page: another processor finds another path, a little.
SHARE, UNITS = 0.2, 1.5


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs a shell")
def test_every_command_prints_what_stands_below_it(tmp_path: Path, programs: Path) -> None:
    pytest.importorskip("rasterio")
    steps = tutorial.steps((REPOSITORY / "docs" / "tutorial.md").read_text(encoding="utf-8"))
    assert sum(step.command.startswith("ipoa-mission") for step in steps) >= 9
    printed = tutorial.run([step.command for step in steps], tmp_path, programs)
    for step, lines in zip(steps, printed, strict=True):
        assert "Traceback" not in "\n".join(lines)
        for here, there in tutorial.matched(step, lines):
            for one, other in zip(tutorial.numbers(here), tutorial.numbers(there), strict=True):
                message = f"{step.command}: {here!r} is now {there!r}: run python -m tools.generate.tutorial"
                assert one == pytest.approx(other, rel=SHARE, abs=UNITS), message
    flight = tmp_path / "flight"
    assert len(read_mission(flight / "out" / "town.plan").items) >= 4
    for file in ("out/town.html", "flown/town.tlog"):
        assert (flight / file).stat().st_size > 5000


def test_numbers_are_told_from_words() -> None:
    assert tutorial.words("   3   NAV_WAYPOINT   62.9   047   +15.3  ▇▇") == "# NAV_WAYPOINT # # #"
    assert tutorial.numbers("least clearance 4.00 m at -3 m on px4") == [4.0, -3.0]
    step = tutorial.Step("x", ("a 1", "...", "c 3"))
    assert tutorial.matched(step, ["a 2", "b", "c 4"]) == [("a 1", "a 2"), ("c 3", "c 4")]
    for printed in (["a 2", "c"], ["b", "a 2", "c 3"], ["a 1", "c 3", "d"]):
        with pytest.raises(LookupError):
            tutorial.matched(step, printed)
