from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, takeoff
from ipoa_mission.mission.mission_io import read_mission, write_mission
from tests.mission_strategies import same
from tests.refused import refuses

HOME = Geodetic(39.101, 121.82, 20.0)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), Item(20, 2)), Autopilot.PX4)


@pytest.mark.parametrize("suffix", [".plan", ".waypoints"])
def test_written_missions_are_read_under_any_name(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    write_mission(MISSION, path)
    assert same(read_mission(path), MISSION)
    renamed = path.rename(tmp_path / "a.txt")
    assert same(read_mission(renamed), MISSION)


@pytest.mark.parametrize("suffix", [".plan", ".waypoints"])
@pytest.mark.parametrize("autopilot", list(registered()))
def test_the_autopilot_can_be_said(suffix: str, autopilot: Autopilot, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    write_mission(MISSION, path)
    assert read_mission(path, autopilot).autopilot is autopilot


@pytest.mark.parametrize("suffix", [".plan", ".waypoints"])
def test_a_file_that_is_not_there_is_an_error_with_its_name(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"nowhere{suffix}"
    with refuses("unreadable", "", "No such file") as refused:
        read_mission(path)
    assert refused.value.place == str(path)


def test_another_suffix_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "a.doc"
    with refuses("wrong-suffix", "a.doc", '".doc"'):
        write_mission(MISSION, path)


def test_a_file_of_another_kind_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("hello")
    with refuses("wrong-format", "a.txt", "QGC"):
        read_mission(path)
