import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import TAKEOFFS
from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, Item, Mission, change_speed, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission_file, write_mission
from ipoa_mission.mission.waypoints_file import TAKEOFF_LOST
from tests.mission_strategies import missions, same
from tests.refused import refuses

FILES = Path(__file__).parent / "files"
HOME = Geodetic(39.101, 121.82, 20.0)
FLIGHT = Mission(HOME, (takeoff(HOME, 40.0), change_speed(15.0), waypoint(Geodetic(39.1023, 121.8212), 40.0)))


@given(mission=missions(frames=(0, 3), fences=False))
def test_written_mission_is_read_back_the_same(mission: Mission, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "round.waypoints"
    assume((mission.home.latitude_deg, mission.home.longitude_deg) != (0.0, 0.0))  # which stands for no place
    takes_off = any(item.command in TAKEOFFS for item in mission.items)
    assert write_mission(mission, path) == ((TAKEOFF_LOST,) if takes_off else ())
    back = read_mission_file(path, mission.autopilot).mission
    if mission.autopilot is Autopilot.ARDUPILOT:
        mission = replace(mission, items=tuple(replace(i, params=_zeros(i.params)) for i in mission.items))
    assert same(back, replace(mission, cruise_speed=None))


def _zeros(params: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    p1, p2, p3, p4 = (0.0 if math.isnan(p) else p for p in params)
    return p1, p2, p3, p4


def test_infinite_param_is_not_written(tmp_path: Path) -> None:
    mission = replace(FLIGHT, items=(FLIGHT.items[0], change_speed(math.inf)))
    with refuses("bad-input", "item 2 (DO_CHANGE_SPEED): param2", kind=BadInput):
        write_mission(mission, tmp_path / "no.waypoints")
    assert not list(tmp_path.iterdir())


@given(mission=missions(frames=(0, 3), fences=False))
def test_every_line_is_as_the_strictest_reader_wants_it(mission: Mission, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "strict.waypoints"
    write_mission(mission, path)
    data = path.read_bytes()
    assert b"\r" not in data
    assert not data.startswith(b"\xef\xbb\xbf")
    first, *lines, last = data.decode("ascii").split("\n")
    assert (first, last) == ("QGC WPL 110", "")
    assert len(lines) == len(mission.items) + 1
    for seq, line in enumerate(lines):
        fields = line.split("\t")
        assert len(fields) == 12
        assert fields[:2] == [str(seq), str(int(seq == 0))]
        assert all(re.fullmatch(r"\d+", field) for field in (*fields[:4], fields[11])), "integers as integers"
        assert all(re.fullmatch(r"-?\d+\.\d{8,}", field) for field in fields[8:10]), "at least eight decimals"
        assert all(re.fullmatch(r"-?\d+\.\d+|nan", field) for field in (*fields[4:8], fields[10]))


def test_a_file_reads_as_it_should(tmp_path: Path) -> None:
    path = tmp_path / "flight.waypoints"
    write_mission(FLIGHT, path)
    assert path.read_text() == (
        "QGC WPL 110\n"
        "0	1	0	16	0.000000	0.000000	0.000000	0.000000	39.10100000	121.82000000	20.000000	1\n"
        "1	0	3	22	0.000000	0.000000	0.000000	nan	39.10100000	121.82000000	40.000000	1\n"
        "2	0	2	178	1.000000	15.000000	-1.000000	0.000000	0.00000000	0.00000000	0.000000	1\n"
        "3	0	3	16	0.000000	0.000000	0.000000	nan	39.10230000	121.82120000	40.000000	1\n"
    )


def test_nan_stays_for_px4_which_would_turn_north_and_is_0_for_ardupilot(tmp_path: Path) -> None:
    path = tmp_path / "flight.waypoints"
    write_mission(replace(FLIGHT, autopilot=Autopilot.ARDUPILOT), path)
    assert "nan" not in path.read_text()


def test_lost_parts_are_remarked(tmp_path: Path) -> None:
    mission = replace(FLIGHT, fence=(FenceCircle((39.1, 121.8), 100.0),), rally=(HOME,))
    assert write_mission(mission, tmp_path / "fence.waypoints") == (
        "a .waypoints file cannot contain the geofence",
        "a .waypoints file cannot contain the rally points: its RTL flies home, by another way, time and energy",
        TAKEOFF_LOST,
    )


@pytest.mark.parametrize("frame", [10, 11])
def test_terrain_altitudes_are_not_written_to_waypoints_files(frame: int, tmp_path: Path) -> None:
    mission = Mission(HOME, (takeoff(HOME, 40.0), Item(16, frame, altitude=30.0)), Autopilot.ARDUPILOT)
    with refuses("frame-not-written", "item 2 (NAV_WAYPOINT)", kind=BadInput):
        write_mission(mission, tmp_path / "terrain.waypoints")
    assert not list(tmp_path.iterdir())


def test_an_empty_file_is_called_empty(tmp_path: Path) -> None:
    (tmp_path / "empty.waypoints").touch()
    with refuses("wrong-format", "line 1", "an empty file"):
        read_mission_file(tmp_path / "empty.waypoints", Autopilot.PX4)


@pytest.mark.parametrize("item", ["5001\t3", "5100\t0"], ids=["fence", "rally point"])
def test_a_fence_or_rally_points_are_no_mission(item: str, tmp_path: Path) -> None:
    path = tmp_path / "fence.waypoints"
    path.write_text(f"QGC WPL 110\n0\t1\t3\t{item}\t0\t0\t0\t39.1\t121.8\t40\t1\n")
    with refuses("not-a-mission-item", path.name, kind=BadInput):
        read_mission_file(path, Autopilot.ARDUPILOT)


def test_a_position_that_is_no_number_is_refused(tmp_path: Path) -> None:
    with refuses("position-missing", "item 1 (NAV_WAYPOINT)", kind=BadInput):
        write_mission(Mission(HOME, (Item(16, 3, altitude=math.nan),)), tmp_path / "nan.waypoints")


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text + "\n\n",
        lambda text: text.replace("\t", " "),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("\n", "\n# a comment\n", 1),
        lambda text: text.rstrip("\n"),
    ],
    ids=["CRLF", "blank lines", "spaces", "byte order mark", "comment", "no last line end"],
)
def test_files_of_other_programs_are_read(change: Any, tmp_path: Path) -> None:
    path = tmp_path / "lenient.waypoints"
    write_mission(FLIGHT, path)
    path.write_bytes(change(path.read_text()).encode())
    assert same(read_mission_file(path).mission, FLIGHT)


def test_a_file_of_mission_planner_is_read() -> None:
    mission = read_mission_file(FILES / "mission_planner.waypoints", Autopilot.ARDUPILOT).mission
    assert mission.home == Geodetic(-35.3632622, 149.1652376, 584.09)
    assert [(item.command, item.frame) for item in mission.items] == [
        (22, 3),
        (178, 2),
        (16, 3),
        (82, 3),
        (177, 2),
        (20, 2),
    ]
    assert mission.items[2].params[0] == 2.0


@pytest.mark.parametrize("name", ["corners-ardupilot", "hold-px4"])
def test_recorded_missions_are_read_and_written_back(name: str, tmp_path: Path) -> None:
    source = FILES / f"{name}.waypoints"
    mission = read_mission_file(source).mission
    path = tmp_path / "again.waypoints"
    write_mission(mission, path)
    assert same(read_mission_file(path).mission, mission)
    assert len(mission.items) == len(source.read_text().splitlines()) - 2


def test_a_home_without_an_altitude_is_not_written(tmp_path: Path) -> None:
    with refuses("position-missing", "home", kind=BadInput):
        write_mission(Mission(Geodetic(39.1, 121.8, math.nan), ()), tmp_path / "no.waypoints")


def test_a_first_line_of_another_number_is_named_as_home(tmp_path: Path) -> None:
    """ArduPilot/MAVProxy #494: a list that begins with item 1, so that its first waypoint is home."""
    path = tmp_path / "way.txt"
    rows = [f"{n} 0 0 16 0 0 0 0 -35.36{n} 149.165 80 1" for n in (1, 2)]
    path.write_text("\n".join(["QGC WPL 110", *rows]).replace(" ", "\t").replace("QGC\tWPL\t", "QGC WPL "))
    file = read_mission_file(path, Autopilot.ARDUPILOT)
    assert file.mission.home == Geodetic(-35.361, 149.165, 80.0)
    (finding,) = file.findings
    assert finding.message == "line 2: seq 1 is not 0: taken as home, which the file may lack"


def test_a_fence_item_among_the_items_is_not_written(tmp_path: Path) -> None:
    corner = replace(waypoint(HOME, 0.0), command=5003)
    with refuses("not-a-mission-item", "item 4 (NAV_FENCE_CIRCLE_INCLUSION)", kind=BadInput):
        write_mission(replace(FLIGHT, items=(*FLIGHT.items, corner)), tmp_path / "fenced.waypoints")
    assert not (tmp_path / "fenced.waypoints").exists()


def test_scaled_degrees_are_refused_with_their_unit(tmp_path: Path) -> None:
    """pymavlink's MAVWPLoader saves a MISSION_ITEM_INT so."""
    path = tmp_path / "scaled.waypoints"
    items = ["0 1 0 16 0 0 0 0 47.3977 8.5456 488 1", "1 0 3 16 0 0 0 0 473977418.000000 85455941.000000 20 1"]
    path.write_text("QGC WPL 110\n" + "\n".join(item.replace(" ", "\t") for item in items) + "\n")
    with pytest.raises(BadInput) as refused:
        read_mission_file(path, Autopilot.PX4)
    assert refused.value.place == f"{path}: line 3: latitude"
    assert "1e7" in str(refused.value.hint)
