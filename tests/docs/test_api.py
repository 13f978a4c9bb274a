"""docs/api.md: its examples run, one after the other, and it names what there is."""

import doctest
import re
import socket
import threading
from collections.abc import Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import ipoa_mission
from ipoa_mission.link.channel import open_channel
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.simulator.autopilot import BuiltInAutopilot
from ipoa_mission.simulator.server import Server
from ipoa_mission.simulator.station import Station
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.world.frame import Geodetic
from tests.quick_link import hurry
from tests.quick_search import QUICK, search_quickly

REPOSITORY = Path(__file__).parents[2]
TEXT = (REPOSITORY / "docs" / "api.md").read_text(encoding="utf-8")
PORT = "14550"


@pytest.fixture
def vehicle_at() -> Iterator[str]:
    """A port to which the built-in autopilot speaks, a hundred times as fast as real, as if it were a vehicle."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    channel = open_channel(f"udpout:127.0.0.1:{port}")
    station = Station(BuiltInAutopilot(Autopilot.PX4, Geodetic(47.397742, 8.545594, 488.0)), 1, None, channel.datagrams)
    enough = threading.Event()
    thread = threading.Thread(target=Server(channel, station, speedup=100.0).run, args=(enough.is_set,))
    thread.start()
    yield str(port)
    enough.set()
    thread.join()
    channel.close()


@pytest.mark.usefixtures("coarse")
def test_the_examples_run_one_after_the_other(
    vehicle_at: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    search_quickly(monkeypatch.setattr)
    monkeypatch.setattr("ipoa_mission.plan_path", partial(plan_path, strategy=QUICK))
    hurry(monkeypatch.setattr)
    monkeypatch.chdir(tmp_path)
    Path("missions").symlink_to(REPOSITORY / "missions")
    names: dict[str, Any] = {}
    flown = list[ipoa_mission.FlightRecord]()
    for example in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        exec(compile(example.replace(PORT, vehicle_at), "docs/api.md", "exec"), names)
        if "record" in names and names["record"] not in flown:
            flown.append(names["record"])
    said = capsys.readouterr().out
    assert re.search(r"^-\d+\.\d+ mast \(", said, re.MULTILINE)
    assert re.search(r"^1 px4 Geodetic\(latitude_deg=47\.3977", said, re.MULTILINE)
    assert "nothing.plan: cannot be read" in said
    assert names["record"].completed
    assert names["later"].total_s == pytest.approx(flown[0].total_s, abs=0.5)
    assert [item.command for item in names["same"].items] == [item.command for item in names["mission"].items]
    assert names["best"].cost < 1000.0
    for file in ("sitl.plan", "sitl.waypoints", "sitl.kml", "sitl.tlog", "sitl.html", "sitl.png", "vehicle.tlog"):
        assert Path(file).stat().st_size > 300


def test_the_page_names_all_that_is_public() -> None:
    table = TEXT[TEXT.index("## All names") :]
    assert set(re.findall(r"`(\w+)[(`]", "\n".join(re.findall(r"^\| (.*?) \|", table, re.MULTILINE)))) == set(
        ipoa_mission.__all__
    )
    assert dir(ipoa_mission) == ipoa_mission.__all__ == sorted(ipoa_mission.__all__)
    for name in ipoa_mission.__all__:
        assert callable(getattr(ipoa_mission, name))
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*", ipoa_mission.__version__)


@pytest.mark.parametrize("name", [*ipoa_mission.__all__])
def test_what_a_public_docstring_raises_can_be_caught_by_its_public_name(name: str) -> None:
    public = getattr(ipoa_mission, name)
    members = [public, *(vars(public).values() if isinstance(public, type) else ())]
    for docstring in filter(None, (getattr(member, "__doc__", None) for member in members)):
        _, raises, promised = docstring.partition("Raises:")
        for error in re.findall(r"[A-Z][a-z]+[A-Za-z]*", promised.partition("\n\n")[0]) if raises else ():
            kind = getattr(ipoa_mission, error, None)
            is_word = not re.search(rf"(^|, |\n *){error}(, |\.|:)", promised)
            assert is_word or (isinstance(kind, type) and issubclass(kind, Exception)), f"{name} raises {error}"


WITH_EXAMPLES = [
    path for path in sorted(Path(ipoa_mission.__file__).parent.rglob("*.py")) if ">>> " in path.read_text()
]


@pytest.mark.parametrize(
    "module", [".".join(path.relative_to(REPOSITORY).with_suffix("").parts) for path in WITH_EXAMPLES]
)
def test_the_examples_in_docstrings_run(module: str) -> None:
    found = doctest.testmod(import_module(module))
    assert found.attempted > 0
    assert found.failed == 0


def test_the_index_names_every_page() -> None:
    index = (REPOSITORY / "docs" / "README.md").read_text(encoding="utf-8")
    pages = {path.name for path in (REPOSITORY / "docs").glob("*.md")} - {"README.md"}
    assert pages <= set(re.findall(r"\]\(([\w-]+\.md)\)", index))
