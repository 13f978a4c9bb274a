import re
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pytest

from ipoa_mission.mission.mission_io import read_mission
from tests.docs.forked import forked
from tools.generate import tutorial

HOW_TO = sorted((tutorial.TUTORIAL.parent / "how-to").glob("*.md"))
EXACT = (tutorial.TUTORIAL, tutorial.README)
FILES = re.compile(r'^```python title="([\w.]+)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)
#: Another processor finds a slightly different path.
SHARE, UNITS = 0.2, 1.5
needs_a_shell = pytest.mark.skipif(shutil.which("bash") is None, reason="needs a shell")


@dataclass(frozen=True)
class Followed:
    """A page's commands, their outputs, and the folder."""

    folder: Path
    steps: list[tutorial.Step]
    printed: list[list[str]]


Follow = Callable[[Path], Followed]


def follow_page(page: Path, folder: Path, programs: Path) -> Followed:
    """Write the page's files and run its commands, in order."""
    text = page.read_text(encoding="utf-8")
    for name, content in FILES.findall(text):
        (folder / name).write_text(content, encoding="utf-8")
    steps = tutorial.steps(text)
    return Followed(folder, steps, tutorial.run([step.command for step in steps], folder, programs))


@pytest.fixture(scope="module")
def follow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Follow]:
    """Follow all pages at once: they mostly wait for a flight.

    README and tutorial show a plan's numbers; others may be planned quickly.
    """
    with forked(tmp_path_factory.mktemp("programs")) as programs, ThreadPoolExecutor(len(EXACT) + len(HOW_TO)) as pool:
        pages = [*((page, programs.usual) for page in EXACT), *((page, programs.quick) for page in HOW_TO)]
        begun = {
            page: pool.submit(follow_page, page, tmp_path_factory.mktemp(page.stem), there) for page, there in pages
        }
        yield lambda page: begun[page].result()


@needs_a_shell
@pytest.mark.parametrize("page", HOW_TO, ids=lambda page: page.stem)
def test_every_command_of_a_how_to_page_prints_what_stands_below_it(page: Path, follow: Follow) -> None:
    followed = follow(page)
    assert len(followed.steps) >= 2
    for step, lines in zip(followed.steps, followed.printed, strict=True):
        assert "Traceback" not in "\n".join(lines), lines
        if step.shown:
            tutorial.matched(step, lines)
        else:
            assert not [line for line in lines if line.startswith("error: ")], lines


@needs_a_shell
def test_every_command_of_the_tutorial_prints_what_stands_below_it(follow: Follow) -> None:
    pytest.importorskip("rasterio")
    followed = follow(tutorial.TUTORIAL)
    assert sum(step.command.startswith("ipoa-mission") for step in followed.steps) >= 9
    expect_shown(followed)
    flight = followed.folder / "flight"
    assert len(read_mission(flight / "out" / "town.plan").items) >= 4
    for file in ("out/town.html", "flown/town.tlog"):
        assert (flight / file).stat().st_size > 5000


@needs_a_shell
def test_every_command_of_the_readme_prints_what_stands_below_it(follow: Follow) -> None:
    followed = follow(tutorial.README)
    assert [step.command.split()[1] for step in followed.steps] == ["fly", "compare"]
    expect_shown(followed)


def expect_shown(followed: Followed) -> None:
    """Compare every command's output with the lines below it."""
    for step, lines in zip(followed.steps, followed.printed, strict=True):
        assert "Traceback" not in "\n".join(lines)
        for here, there in tutorial.matched(step, lines):
            for printed, written in zip(tutorial.numbers(here), tutorial.numbers(there), strict=True):
                message = f"{step.command}: {here!r} is now {there!r}: run python -m tools.generate.tutorial"
                assert printed == pytest.approx(written, rel=SHARE, abs=UNITS), message


def test_numbers_are_told_from_words() -> None:
    assert tutorial.words("   3   NAV_WAYPOINT   62.9   047   +15.3  ▇▇") == "# NAV_WAYPOINT # # #"
    assert tutorial.numbers("least clearance 4.00 m at -3 m on px4") == [4.0, -3.0]
    step = tutorial.Step("x", ("a 1", "...", "c 3"))
    assert tutorial.matched(step, ["a 2", "b", "c 4"]) == [("a 1", "a 2"), ("c 3", "c 4")]
    for printed in (["a 2", "c"], ["b", "a 2", "c 3"], ["a 1", "c 3", "d"]):
        with pytest.raises(LookupError):
            tutorial.matched(step, printed)
