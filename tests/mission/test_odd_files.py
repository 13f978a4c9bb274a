import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.checks.check import check
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.forecast.itinerary.flown_legs import flown_legs
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.items import MissionFile
from ipoa_mission.mission.mission_io import read_mission_file, write_mission
from ipoa_mission.mission.program import as_flown
from tests.px4_waypoints import PX4_117

ODD = Path(__file__).parent.parent / "data" / "odd"
SAID: dict[str, list[str]] = tomllib.loads((ODD / "findings.toml").read_text(encoding="utf-8"))


def read(name: str) -> MissionFile:
    return read_mission_file(ODD / name, None if name.endswith(".plan") else Autopilot.ARDUPILOT)


def test_every_odd_file_is_in_the_list() -> None:
    assert {path.name for path in ODD.iterdir()} == set(SAID) | {"findings.toml"}


@pytest.mark.parametrize("name", SAID)
def test_an_odd_file_is_read_and_check_says_what_is_odd(name: str) -> None:
    file = read(name)
    mission = replace(file.mission, firmware_version=PX4_117.get(file.mission.autopilot))
    assert [str(finding) for finding in check(Forecast(mission), read=file.findings)] == SAID[name]


@pytest.mark.parametrize("name", SAID)
def test_unchanged_parts_are_written_as_they_were(name: str, tmp_path: Path) -> None:
    file = read(name)
    write_mission(file.mission, tmp_path / name, read_from=file)
    assert (tmp_path / name).read_bytes() == (ODD / name).read_bytes()


def test_arducopter_does_here_and_as_high_as_now_where_it_is() -> None:
    mission = read("here_and_as_high.waypoints").mission
    _, there, loiter, _ = as_flown(mission).items
    assert (there.altitude, loiter.latitude_deg, loiter.longitude_deg, loiter.altitude) == (30.0, 39.102, 121.82, 40.0)
    ends = [leg.points[-1, 2] for leg in flown_legs(mission, LocalFrame(mission.home))]
    assert ends == pytest.approx([30.0, 30.0, 40.0, 0.0], abs=0.01)
    done = [item.done_s for item in estimate(mission).items]
    assert done == sorted(done)
