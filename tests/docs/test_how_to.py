"""docs/how-to: each page's files are written and its commands run, in order, and print what stands below them."""

import shutil
from pathlib import Path

import pytest

from tests.docs.conftest import HOW_TO, Follow
from tools.generate import tutorial


@pytest.mark.xdist_group("commands of the docs")
@pytest.mark.skipif(shutil.which("bash") is None, reason="needs a shell")
@pytest.mark.parametrize("page", HOW_TO, ids=lambda page: page.stem)
def test_every_command_prints_what_stands_below_it(page: Path, follow: Follow) -> None:
    followed = follow(page)
    assert len(followed.steps) >= 2
    for step, lines in zip(followed.steps, followed.printed, strict=True):
        assert "Traceback" not in "\n".join(lines), lines
        if step.shown:
            tutorial.matched(step, lines)
        else:
            assert not [line for line in lines if line.startswith("error: ")], lines
