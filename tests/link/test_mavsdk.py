import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("mavsdk")

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import upload
from ipoa_mission.link.channel import UdpChannel, parse_address
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.messages import STATION_COMPONENT, STATION_SYSTEM
from ipoa_mission.link.vehicle import ConnectionOptions
from ipoa_mission.link.wire import coordinate
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.mission.stored_mission import to_wire
from tests.examples import vehicles
from tests.link_pair import port_of
from tests.quick_link import hurry

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
SITL = REPOSITORY / "missions" / "sitl.plan"
HOME = Geodetic(47.4, 8.5, 400.0)


@pytest.mark.parametrize("family", vehicles(Autopilot.PX4))
def test_mavsdk_uploads_starts_and_sees_the_mission_finish(family: Autopilot, run_mock: Callable[..., object]) -> None:
    with run_mock(family, speedup=60.0) as running:  # type: ignore[attr-defined]
        done = subprocess.run(
            [sys.executable, "-m", "tests.link.mavsdk_client", f"udpout:127.0.0.1:{running.port}"],
            cwd=REPOSITORY,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
    line = next((line for line in done.stdout.splitlines() if "RESULT " in line), None)
    assert line is not None, done.stdout + done.stderr
    result = json.loads(line[line.index("RESULT ") + 7 :])
    assert result.pop("samples") > 10
    if family is Autopilot.PX4:
        assert "the take-off is not above home" in result.pop("unflyable")
        assert result.pop("cancelled_as_told")
    assert result == {
        "autopilot": str(family),
        "items": 5,
        "fence_is_kept": True,
        "rally_is_kept": True,
        "reached": [0, 1, 2, 3, 4],
        "completed": True,
        "by_mavsdk_alone": True,
    }


@pytest.mark.parametrize(
    ("verb", "seconds", "error"),
    [
        ("clear --link udpout:127.0.0.1:9", 1, "no autopilot is heard"),
        (f"fly {SITL} --link udpout:127.0.0.1:{{port}}", 9, "the time is up: the vehicle flies on, and is not watched"),
    ],
)
def test_time_limit_of_a_user_holds_over_mavsdk_too(
    run_mock: Callable[..., object], tmp_path: Path, verb: str, seconds: int, error: str
) -> None:
    with run_mock(Autopilot.PX4, speedup=4.0, home=read_mission(SITL).home) as running:  # type: ignore[attr-defined]
        words = verb.format(port=running.port)
        began = time.monotonic()
        done = subprocess.run(
            [sys.executable, "-m", "ipoa_mission", *words.split(), "--backend", "mavsdk", "--timeout", str(seconds)],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(REPOSITORY)},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
    assert (done.returncode, error in done.stderr) == (1, True), done.stderr
    assert seconds <= time.monotonic() - began < seconds + 10.0


def test_our_upload_puts_a_mission_on_mavsdks_own_server(monkeypatch: pytest.MonkeyPatch) -> None:
    hurry(monkeypatch.setattr)
    monkeypatch.setattr(upload, "VERDICT_S", 0.3)
    channel = UdpChannel(parse_address("udpin:127.0.0.1:0"))
    legs = [waypoint(Geodetic(47.4 + 0.00012345 * n, 8.5 - 0.00054321 * n), 30.0 + n) for n in range(1, 20)]
    items = (takeoff(HOME, 20.0), *legs, return_to_launch())
    with (
        Connection(channel, Codec(STATION_SYSTEM, STATION_COMPONENT)) as connection,
        subprocess.Popen(
            [sys.executable, str(HERE / "mavsdk_server.py"), f"udpout://127.0.0.1:{port_of(channel)}", "20"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        ) as server,
    ):
        try:
            vehicle = meet(connection, options=ConnectionOptions(reading=True))  # a generic vehicle
            vehicle._run(upload.upload(upload.Upload(to_wire(Mission(HOME, items)), vehicle.autopilot)))
            assert server.stderr is not None
            result = next(json.loads(words) for words in server.stderr if words.startswith("{"))
        finally:
            server.kill()
    assert result["result"] == "SUCCESS"
    assert [row[2] for row in result["items"]] == [item.command for item in items]
    assert [row[5:7] for row in result["items"]] == [
        [coordinate(item.latitude_deg, item.frame), coordinate(item.longitude_deg, item.frame)] for item in items
    ]
    assert [row[7] for row in result["items"]] == [item.altitude for item in items]
