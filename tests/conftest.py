"""What every test may lean on."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

REPOSITORY = Path(__file__).parent.parent

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else every command that a test starts compiles the package anew

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


@pytest.fixture
def samples() -> Path:
    """Other people's files, kept beside the repository or at IPOA_SAMPLES; not everybody has them."""
    named = os.environ.get("IPOA_SAMPLES")
    folders = [Path(named)] if named else [parent / "shared" / "samples" for parent in REPOSITORY.parents]
    found = next((folder for folder in folders if folder.is_dir()), None)
    if found is None:
        pytest.skip("no samples beside the repository")
    return found
