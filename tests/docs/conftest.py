"""The command of the docs' examples."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.docs.forked import forked


@pytest.fixture(scope="session")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with an `ipoa-mission` that begins at once."""
    folder = tmp_path_factory.mktemp("programs")
    with forked(folder):
        yield folder
