import shlex
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
import typer

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.cli.app import app, main
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import UdpChannel, open_channel
from ipoa_mission.link.signing import Signer, key_of
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.mission.mission_io import write_mission
from ipoa_mission.scenario import read_scenario
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Server, Station
from tests.link_pair import port_of
from tests.px4_waypoints import waypoint
from tests.quick_link import hurry
from tests.quick_search import search_quickly

Run = Callable[[str], "Outcome"]
Planned = Callable[[str], tuple[Flight, Path]]
Serve = Callable[..., AbstractContextManager[str]]
ZURICH = Geodetic(47.397742, 8.545594, 488.0)


@dataclass(frozen=True)
class Outcome:
    code: int
    out: str
    err: str


def verbs() -> list[str]:
    return sorted(getattr(typer.main.get_command(app), "commands", {}))


@pytest.fixture
def run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, request: pytest.FixtureRequest
) -> Run:
    """Run `ipoa-mission WORDS` in a folder of its own; plan with a quick search except in long tests."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    hurry(monkeypatch.setattr)
    if request.node.get_closest_marker("long") is None:
        search_quickly(monkeypatch.setattr)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    for name in ("IPOA_MISSION_KEY", "IPOA_MISSION_PASSPHRASE"):
        monkeypatch.delenv(name, raising=False)

    def command(words: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["ipoa-mission", *shlex.split(words)])
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        return Outcome(int(ended.value.code or 0), captured.out, captured.err)

    return command


@pytest.fixture(scope="session")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Planned:
    """Plan a scenario with seed 5, once for all tests, without a return altitude: for both firmwares."""
    missions = Path(__file__).parents[2] / "missions"

    @cache
    def plan(name: str) -> tuple[Flight, Path]:
        folder = tmp_path_factory.mktemp(name)
        with pytest.MonkeyPatch.context() as patch:
            search_quickly(patch.setattr)
            scenario = read_scenario(missions / f"{name}.toml")
            safety = scenario.safety.model_copy(update={"returns": "warn"})
            flight = plan_flight(scenario.model_copy(update={"safety": safety}), seed=5)
        flight.write(folder)
        return flight, folder

    return plan


@pytest.fixture
def hop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    there = Geodetic(47.397842, 8.545594, 488.0)
    items = (takeoff(ZURICH, 5.0), waypoint(there, 5.0), land(there))
    path = tmp_path_factory.mktemp("hop") / "hop.plan"
    write_mission(Mission(ZURICH, items), path)
    return path


@pytest.fixture
def autopilot() -> Serve:
    """Serve the built-in autopilot on a UDP port, 60 times as fast as real."""

    @contextmanager
    def serve(
        home: Geodetic = ZURICH,
        family: Autopilot = Autopilot.PX4,
        passphrase: str | None = None,
        speedup: float = 60.0,
        version: Version | None = None,
    ) -> Iterator[str]:
        channel = open_channel("udpin:127.0.0.1:0")
        assert isinstance(channel, UdpChannel)
        signer = Signer(key_of(passphrase)) if passphrase else None
        aboard = BuiltInAutopilot(family, home, conditions=Conditions(version=version))
        server = Server(channel, Station(aboard, 1, signer), speedup)
        enough = threading.Event()
        thread = threading.Thread(target=server.run, args=(enough.is_set,))
        thread.start()
        try:
            yield f"udpout:127.0.0.1:{port_of(channel)} --system 1"
        finally:
            enough.set()
            thread.join()
            channel.close()

    return serve
