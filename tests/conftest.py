"""What every test may lean on."""

from pathlib import Path

import pytest
from hypothesis import settings

REPOSITORY = Path(__file__).parent.parent

settings.register_profile("steady", deadline=None, derandomize=True)  # CI's machines are noisy; a failure comes again
settings.load_profile("steady")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Simulations to fly on: see tests/sitl."""
    for name in ("ardupilot", "px4"):
        parser.addoption(f"--{name}", metavar='LINK|"COMMAND @ LINK"', help=f"a simulated {name} for the sitl tests")


@pytest.fixture
def missions() -> Path:
    """The folder of scenarios that ship with the repository."""
    return REPOSITORY / "missions"
