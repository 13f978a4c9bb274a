from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, MissionFile, return_to_launch, spline_waypoint, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_by_items, read_mission_file, write_mission
from ipoa_mission.mission.waypoints_file import waypoints_text

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME, NORTH = Geodetic(47.06, 9.71, 612.0), Geodetic(47.061, 9.71)
UP, AWAY, DOWN = takeoff(HOME, 20.0), waypoint(NORTH, 20.0), return_to_launch()
#: Mission Planner's take-off: no place.
HERE = replace(UP, latitude_deg=0.0, longitude_deg=0.0, params=(0.0, 0.0, 0.0, 0.0))


def by_items(path: Path) -> MissionFile:
    return read_by_items(path, read_mission_file(path))


def zeroed(*items: Item) -> tuple[Item, ...]:
    return tuple(replace(item, params=(0.0, 0.0, 0.0, 0.0)) for item in items)


@pytest.mark.parametrize(
    ("items", "autopilot"),
    [
        ((*zeroed(UP), spline_waypoint(NORTH, 20.0), DOWN), ARDUPILOT),
        ((HERE, *zeroed(AWAY), DOWN), ARDUPILOT),
        ((UP, replace(AWAY, params=(0.0, 0.0, 0.0, float("nan"))), DOWN), PX4),
        (zeroed(UP, AWAY, DOWN), None),
        ((*zeroed(UP, replace(AWAY, latitude_deg=0.0, longitude_deg=0.0)), DOWN), None),
    ],
)
def test_items_that_only_one_autopilot_takes_decide(
    tmp_path: Path, items: tuple[Item, ...], autopilot: Autopilot | None
) -> None:
    text = waypoints_text(Mission(HOME, items, autopilot or PX4))
    (tmp_path / "colleague.waypoints").write_text(text)
    read = by_items(tmp_path / "colleague.waypoints")
    assert read.mission.autopilot is (autopilot or PX4)
    assert bool(read.taken_for) == (autopilot is not None)
    assert read.taken_for is not None


def test_terrain_heights_are_ardupilots(tmp_path: Path) -> None:
    text = waypoints_text(Mission(HOME, zeroed(UP, AWAY, DOWN), ARDUPILOT)).replace("\t3\t16\t", "\t10\t16\t")
    (tmp_path / "colleague.waypoints").write_text(text)
    assert by_items(tmp_path / "colleague.waypoints").mission.autopilot is ARDUPILOT


def test_options_and_neighboring_files_go_before(tmp_path: Path) -> None:
    path = tmp_path / "colleague.waypoints"
    write_mission(Mission(HOME, zeroed(UP, AWAY, DOWN), ARDUPILOT).with_parameters({"RTL_ALT": 3000.0}), path)
    read = read_mission_file(path)
    assert (read.mission.autopilot, read.taken_for) == (ARDUPILOT, None)
    path.with_suffix(".params").unlink()
    read = read_mission_file(path, otherwise=ARDUPILOT)
    assert (read.mission.autopilot, read.taken_for) == (ARDUPILOT, None)
    assert read_mission_file(path, PX4, ARDUPILOT).mission.autopilot is PX4
