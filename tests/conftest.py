"""What every test may lean on."""

from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parent.parent


@pytest.fixture
def missions() -> Path:
    """The folder of scenarios that ship with the repository."""
    return REPOSITORY / "missions"
