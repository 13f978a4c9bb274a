"""`pytest -m sitl --ardupilot LINK|"COMMAND @ LINK" --px4 LINK|"COMMAND @ LINK"`, loopback only."""

import shlex
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.link.messages import MissionType
from tests.sitl.simulated import Sitl

LISTS = (MissionType.MISSION, MissionType.FENCE, MissionType.RALLY)


@pytest.fixture(scope="module", params=list(registered()), ids=str)
def simulation(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sitl]:
    """One simulation for a module; its lists come back at the end."""
    family: Autopilot = request.param
    option = request.config.getoption(f"--{family}")
    if option is None:
        pytest.skip(f"no --{family} LINK was given")
    command, at, link = str(option).rpartition("@")
    started = subprocess.Popen(shlex.split(command), start_new_session=True) if at else None
    sitl = Sitl(family, link.strip(), tmp_path_factory.mktemp(f"{family}-sitl"))
    try:
        sitl.home = sitl.wait_for_home()
        with sitl.connect() as vehicle:
            before = {kind: vehicle.download_items(kind) for kind in LISTS}
        yield sitl
        with sitl.connect() as vehicle:
            for kind, items in before.items():
                vehicle.upload_items(items, kind)
    finally:
        if started is not None:
            started.terminate()
            started.wait(timeout=20.0)


@pytest.fixture
def sitl(simulation: Sitl, tmp_path: Path) -> Sitl:
    simulation.folder = tmp_path
    return simulation
