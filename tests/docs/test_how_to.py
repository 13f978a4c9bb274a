"""docs/how-to: each page's files are written and its commands run, in order, and print what stands below them."""

import re
import shutil
from pathlib import Path

import pytest

from tools.generate import tutorial

PAGES = sorted((Path(__file__).parents[2] / "docs" / "how-to").glob("*.md"))
FILES = re.compile(r'^```python title="([\w.]+)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs a shell")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_prints_what_stands_below_it(page: Path, tmp_path: Path, programs: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name, content in FILES.findall(text):
        (tmp_path / name).write_text(content, encoding="utf-8")
    steps = tutorial.steps(text)
    assert len(steps) >= 2
    printed = tutorial.run([step.command for step in steps], tmp_path, programs)
    for step, lines in zip(steps, printed, strict=True):
        assert "Traceback" not in "\n".join(lines), lines
        if step.shown:
            tutorial.matched(step, lines)
        else:
            assert not [line for line in lines if line.startswith("error: ")], lines
