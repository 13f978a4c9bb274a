"""docs/tutorial.md does what it says: each of its commands is run, in order, and prints what stands below it."""

import importlib.util
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from ipoa_mission.mission.files import read_mission

REPOSITORY = Path(__file__).parents[2]
#: How far a number may be from the one that stands in the page: another processor finds another path, a little.
SHARE, UNITS = 0.2, 1.5


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    """The command that writes the page's outputs."""
    spec = importlib.util.spec_from_file_location("make_tutorial", REPOSITORY / "tools" / "make_tutorial.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs a shell")
def test_every_command_prints_what_stands_below_it(tool: ModuleType, tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    tutorial = tool.steps((REPOSITORY / "docs" / "tutorial.md").read_text(encoding="utf-8"))
    assert sum(step.command.startswith("ipoa-mission") for step in tutorial) >= 9
    printed = tool.run([step.command for step in tutorial], tmp_path)
    for step, lines in zip(tutorial, printed, strict=True):
        assert "Traceback" not in "\n".join(lines)
        for here, there in tool.matched(step, lines):
            for one, other in zip(tool.numbers(here), tool.numbers(there), strict=True):
                message = f"{step.command}: {here!r} is now {there!r}: run python tools/make_tutorial.py"
                assert one == pytest.approx(other, rel=SHARE, abs=UNITS), message
    flight = tmp_path / "flight"
    assert len(read_mission(flight / "out" / "town.plan").items) >= 4
    for file in ("out/town.html", "flown/town.tlog"):
        assert (flight / file).stat().st_size > 5000


def test_numbers_are_told_from_words(tool: ModuleType) -> None:
    assert tool.words("   3   NAV_WAYPOINT   62.9   047   +15.3  ▇▇") == "# NAV_WAYPOINT # # #"
    assert tool.numbers("least clearance 4.00 m at -3 m on px4") == [4.0, -3.0]
    step = tool.Step("x", ("a 1", "...", "c 3"))
    assert tool.matched(step, ["a 2", "b", "c 4"]) == [("a 1", "a 2"), ("c 3", "c 4")]
    for printed in (["a 2", "c"], ["b", "a 2", "c 3"], ["a 1", "c 3", "d"]):
        with pytest.raises(LookupError):
            tool.matched(step, printed)
