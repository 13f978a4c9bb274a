import json
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.mission_io import write_mission
from tests.cli.conftest import Run

HOME, THERE = Geodetic(47.397742, 8.545594, 488.0), Geodetic(47.3985, 8.5456)


@pytest.mark.parametrize("version", ["1.15", "1.18"])
def test_a_circle_that_px4_does_not_take(run: Run, tmp_path: Path, version: str) -> None:
    turns = Item(Command.NAV_LOITER_TURNS, 3, (2.0, 0.0, 30.0, 0.0), THERE.latitude_deg, THERE.longitude_deg, 20.0)
    items = (takeoff(HOME, 20.0), waypoint(THERE, 20.0), turns, return_to_launch())
    write_mission(Mission(HOME, items, Autopilot.PX4), file := tmp_path / "turns.plan")
    about = f"{file} --autopilot px4 --firmware-version {version} --unmeasured-version --json"
    checked, timed = run(f"check {about}"), run(f"estimate {about}")
    words = f"item 3 (NAV_LOITER_TURNS): PX4 {version} does not take NAV_LOITER_TURNS"
    assert (checked.code, timed.code) == (1, 0)
    assert words in checked.out
    assert words in json.loads(timed.out)["remarks"]
