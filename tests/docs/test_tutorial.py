"""docs/tutorial.md does what it says: each of its commands is run, in order, and prints what stands below it."""

import shutil

import pytest

from ipoa_mission.mission.files import read_mission
from tests.docs.conftest import Follow
from tools.generate import tutorial

#: How far a number may be from the one that stands in the page: another processor finds another path, a little.
SHARE, UNITS = 0.2, 1.5


@pytest.mark.xdist_group("commands of the docs")
@pytest.mark.skipif(shutil.which("bash") is None, reason="needs a shell")
def test_every_command_prints_what_stands_below_it(follow: Follow) -> None:
    pytest.importorskip("rasterio")
    followed = follow(tutorial.TUTORIAL)
    assert sum(step.command.startswith("ipoa-mission") for step in followed.steps) >= 9
    for step, lines in zip(followed.steps, followed.printed, strict=True):
        assert "Traceback" not in "\n".join(lines)
        for here, there in tutorial.matched(step, lines):
            for one, other in zip(tutorial.numbers(here), tutorial.numbers(there), strict=True):
                message = f"{step.command}: {here!r} is now {there!r}: run python -m tools.generate.tutorial"
                assert one == pytest.approx(other, rel=SHARE, abs=UNITS), message
    flight = followed.folder / "flight"
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
