"""What a verb has to import before it can begin: none of the large packages that it has no use for."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from ipoa_mission.link.address import parse_address
from ipoa_mission.link.channel import UdpChannel
from ipoa_mission.simulator.autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.faults import Faults
from ipoa_mission.simulator.server import Server
from ipoa_mission.simulator.station import Station
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.world.frame import Geodetic

MISSIONS = Path(__file__).parents[2] / "missions"
FOR_ARDUPILOT, FOR_PX4 = str(MISSIONS / "campus.plan"), str(MISSIONS / "sitl.plan")
LARGE = {"numpy", "scipy", "shapely", "pyproj", "matplotlib", "contourpy", "numba", "pymavlink", "mavsdk", "rasterio"}
#: Of our own: pydantic's models are built when their module is imported.
OURS = {"ipoa_mission.scenario", "ipoa_mission.planning", "ipoa_mission.simulator", "ipoa_mission.report.page"}
#: Runs a command line and tells what is imported when it ends.
WATCHED = f"""
import sys
sys.argv[0] = "ipoa-mission"
from ipoa_mission.cli.app import main
try:
    main()
finally:
    sys.__stderr__.write("IMPORTED " + " ".join(p for p in {sorted(LARGE | OURS)!r} if p in sys.modules))
"""


def imported(*arguments: str, before: str = "") -> set[str]:
    run = subprocess.run(
        [sys.executable, "-c", before + WATCHED, *arguments],
        capture_output=True, text=True, timeout=300, cwd=MISSIONS.parent,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return set(run.stderr.rpartition("IMPORTED ")[2].split())


@pytest.fixture
def link() -> Iterator[str]:
    """Where the built-in autopilot answers."""
    channel = UdpChannel(parse_address("udpin:127.0.0.1:0"))
    server = Server(channel, Station(Mock(Autopilot.PX4, Geodetic(47.397742, 8.545594, 488.0))), 60.0, Faults(), 0)
    stop = threading.Event()
    thread = threading.Thread(target=server.run, args=(stop.is_set,))
    thread.start()
    yield f"udpout:127.0.0.1:{channel.port}"
    stop.set()
    thread.join()
    channel.close()


def test_help_needs_none_of_them() -> None:
    assert imported("--help") == set()


@pytest.mark.parametrize("verb", ["show", "check", "estimate"])
def test_a_mission_file_is_looked_at_without_what_only_scenarios_need(verb: str) -> None:
    assert imported(verb, FOR_ARDUPILOT) == {"numpy", "pyproj"}


def test_an_upload_needs_the_messages_besides(link: str, tmp_path: Path) -> None:
    log = str(tmp_path / "upload.tlog")
    hurried = "from tests.quick_link import hurry; hurry()"
    needed = imported("upload", FOR_PX4, "--link", link, "--log", log, before=hurried)
    assert needed - {"pymavlink"} == {"numpy", "pyproj"}  # that only in a checkout


def test_a_picture_without_matplotlib_is_an_error_that_names_the_extra(tmp_path: Path) -> None:
    log = MISSIONS / "logs" / "campus-arducopter.tlog"
    code = "import sys; sys.modules['matplotlib'] = None\nfrom ipoa_mission.cli.app import main\nmain()"
    command = [sys.executable, "-c", code, "compare", str(log), "--picture", str(tmp_path / "flown.png")]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert run.returncode == 1
    assert "pip install 'ipoa-mission[pictures]'" in run.stderr
    assert not list(tmp_path.iterdir())
