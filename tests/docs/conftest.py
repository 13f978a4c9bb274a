"""The commands of the docs' pages, run side by side: most of their time they wait for one another."""

import re
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.docs.forked import forked
from tools.generate import tutorial

DOCS = Path(__file__).parents[2] / "docs"
HOW_TO = sorted((DOCS / "how-to").glob("*.md"))
FILES = re.compile(r'^```python title="([\w.]+)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Followed:
    """A page's commands, what each of them printed, and the folder in which they were run."""

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


@pytest.fixture(scope="session")
def follow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Follow]:
    """What has become of a page's commands. All pages are begun when the first is asked for.

    The tutorial shows the numbers of a plan; what the others plan may be looked for less hard.
    """
    with forked(tmp_path_factory.mktemp("programs")) as programs, ThreadPoolExecutor(1 + len(HOW_TO)) as pool:
        begun = {
            page: pool.submit(follow_page, page, tmp_path_factory.mktemp(page.stem), there)
            for page, there in [(tutorial.TUTORIAL, programs.usual), *((page, programs.quick) for page in HOW_TO)]
        }
        yield lambda page: begun[page].result()
