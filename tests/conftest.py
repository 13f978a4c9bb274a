"""What every test may lean on."""

from pathlib import Path

import pytest
from hypothesis import settings

REPOSITORY = Path(__file__).parent.parent

settings.register_profile("steady", deadline=None, derandomize=True)  # CI's machines are noisy; a failure comes again
settings.load_profile("steady")


@pytest.fixture
def missions() -> Path:
    """The folder of scenarios that ship with the repository."""
    return REPOSITORY / "missions"
