import gc
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is imported: its threads cost more than they give

import pytest
from hypothesis import settings

from ipoa_mission.autopilot.autopilot import Autopilot

gc.set_threshold(50_000)  # imports make many objects, and no garbage
REPOSITORY = Path(__file__).parent.parent

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else every started command compiles the package
sys.dont_write_bytecode = False  # and every worker rewrites the assertions of all tests

#: A shell's background jobs ignore Ctrl-C, and so would commands that a test starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
#: [s]
LONGEST_S = 900.0

#: Begun first: a file's tests are run by one worker.
LONGEST = (
    "studio/test_page.py",
    "studio/test_keyboard.py",
    "docs/test_commands.py",
    "studio/test_survey_page.py",
    "studio/test_stays.py",
    "studio/test_server.py",
    "survey/test_flights.py",
    "link/test_reconnect.py",
    "studio/test_mission.py",
    "routing/test_returns.py",
    "docs/test_api.py",
    "cli/test_deviation.py",
    "cli/test_interrupted.py",
    "cli/test_flags.py",
    "cli/test_output.py",
    "cli/test_without_plug_ins.py",
    "maps/test_wind_files.py",
    "cli/test_surveying.py",
    "forecast/test_flight_times.py",
    "cli/test_both_doors.py",
    "planning/test_planner.py",
    "report/test_browser.py",
    "link/test_mavproxy.py",
    "studio/test_survey.py",
    "test_ratchet.py",
)

#: CI's machines are noisy. `--hypothesis-profile thorough`, as in .ci/run, tries four times as many examples.
settings.register_profile("steady", deadline=None, derandomize=True, max_examples=50)
settings.register_profile("thorough", settings.get_profile("steady"), max_examples=200)
settings.load_profile("steady")


def pytest_addoption(parser: pytest.Parser) -> None:
    """See tests/sitl."""
    for name in ("ardupilot", "px4"):
        parser.addoption(f"--{name}", metavar='LINK|"COMMAND @ LINK"', help=f"a simulated {name} for the sitl tests")


def pytest_configure(config: pytest.Config) -> None:
    """Let each worker collect another folder first: what one has compiled the others read."""
    worker = getattr(config, "workerinput", None)
    if worker is not None and [Path(name).resolve() for name in config.args] == [REPOSITORY / "tests"]:
        parts = [str(path) for path in sorted((REPOSITORY / "tests").iterdir()) if is_collected(path)]
        first = len(parts) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
        config.args = parts[first:] + parts[:first]


def is_collected(path: Path) -> bool:
    return path.match("test_*.py") or any(path.glob("test_*.py"))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the longest first."""
    places = {REPOSITORY / "tests" / name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: (places.get(item.path, len(LONGEST)), item.path))


def pytest_collection_finish() -> None:
    """Exclude imports and collected tests from garbage collection."""
    gc.collect()
    gc.freeze()


def pytest_sessionfinish() -> None:
    """Collect garbage once: pytest collects five times after it."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Fail a test that hangs, with pytest's report."""

    def too_long(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"{item.nodeid} takes more than {LONGEST_S:g} s")

    if hasattr(signal, "setitimer") and item.get_closest_marker("sitl") is None:
        signal.signal(signal.SIGALRM, too_long)
        signal.setitimer(signal.ITIMER_REAL, LONGEST_S, 10.0)  # again
    try:
        return (yield)
    finally:
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0.0)


@pytest.fixture
def missions() -> Path:
    return REPOSITORY / "missions"


@pytest.fixture
def shared() -> Path:
    """Return the folder of other people's files that IPOA_SHARED names."""
    if (folder := os.environ.get("IPOA_SHARED")) is None:
        pytest.skip("IPOA_SHARED names no folder of other people's files")
    assert Path(folder).is_dir(), f"IPOA_SHARED: no folder {folder}"
    return Path(folder)


@pytest.fixture
def samples(shared: Path) -> Path:
    return shared / "samples"


@pytest.fixture
def field4(shared: Path) -> Path:
    return shared / "field4"


def pytest_make_parametrize_id(val: object) -> str | None:
    return str(val) if isinstance(val, Autopilot) else None
