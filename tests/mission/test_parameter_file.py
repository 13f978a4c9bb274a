from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import SINGLE_MAX
from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, takeoff
from ipoa_mission.mission.mission_io import read_mission, read_mission_file, write_files, write_mission
from ipoa_mission.mission.parameter_file import read_parameter_file
from tests.refused import refuses

HOME = Geodetic(39.101, 121.82, 20.0)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), Item(20, 2)))

QGROUNDCONTROL = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
#
# Vehicle-Id Component-Id Name Value Type
1\t1\tMPC_XY_CRUISE\t7.500000000000000000\t9
1\t1\tNAV_DLL_ACT\t0\t6
"""
MAVPROXY = "WPNAV_SPEED      800.000000\nWPNAV_JERK       1.500000   # gentle\n\n"
MISSION_PLANNER = "#NOTE: 1/2/2024 frame\r\nWPNAV_SPEED,800\r\nWPNAV_JERK,1.5\r\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (QGROUNDCONTROL, {"MPC_XY_CRUISE": 7.5, "NAV_DLL_ACT": 0.0}),
        (MAVPROXY, {"WPNAV_SPEED": 800.0, "WPNAV_JERK": 1.5}),
        (MISSION_PLANNER, {"WPNAV_SPEED": 800.0, "WPNAV_JERK": 1.5}),
        ("WPNAV_SPEED 1\nWPNAV_SPEED 2\n", {"WPNAV_SPEED": 2.0}),
        ("", {}),
    ],
    ids=["QGroundControl", "MAVProxy", "Mission Planner", "the last one counts", "empty"],
)
def test_each_tools_file_is_read(tmp_path: Path, text: str, expected: dict[str, float]) -> None:
    path = tmp_path / "vehicle.parm"
    path.write_bytes(text.encode())
    assert read_parameter_file(path).parameters == expected


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("WPNAV_SPEED", ("bad-input", "vehicle.parm: line 2")),
        ("1 1 WPNAV_SPEED 800", ("bad-input", "vehicle.parm: line 2")),
        ("WPNAV_SPEED fast", ("bad-input", "vehicle.parm: line 2: WPNAV_SPEED", "'fast'")),
        ("WPNAV_SPEED nan", ("bad-input", "vehicle.parm: line 2: WPNAV_SPEED", "'nan'")),
        ("WPNAV_SPEED 1e300", ("bad-input", "vehicle.parm: line 2: WPNAV_SPEED", "'1e300'")),
        ("800,WPNAV_SPEED", ("bad-input", "vehicle.parm: line 2")),
        ("WPNAV_SPEED 8_0", ("bad-input", "vehicle.parm: line 2: WPNAV_SPEED", "'8_0'")),
        ("1 1 NAV_DLL_ACT 0.5 6", ("bad-input", "vehicle.parm: line 2: NAV_DLL_ACT", "'0.5'")),
        ("1 1 NAV_DLL_ACT 0 77", ("bad-input", "vehicle.parm: line 2: NAV_DLL_ACT", "77")),
        ("1 1 NAV_DLL_ACT 0 ²", ("bad-input", "vehicle.parm: line 2", "²")),
    ],
)
def test_a_broken_line_is_named(tmp_path: Path, line: str, message: tuple[str, ...]) -> None:
    path = tmp_path / "vehicle.parm"
    path.write_text(f"# a comment\n{line}\n")
    with refuses(*message):
        read_parameter_file(path)


@pytest.mark.parametrize(
    ("text", "parameters", "words"),
    [
        (QGROUNDCONTROL, {"MPC_XY_CRUISE": 7.5, "NAV_DLL_ACT": 0.0}, []),
        (
            "WPNAV_SPEED 500\nWPNAV_SPEED 800\nWPNAV_SPEED 800\n",
            {"WPNAV_SPEED": 800.0},
            ['values of parameters that a later line overrides: line 1: WPNAV_SPEED ("500")'],
        ),
        (
            "1 1 NAV_ACC_RAD 3 9\n1 100 NAV_ACC_RAD 9 9\n2 1 NAV_ACC_RAD 8 9\n",
            {"NAV_ACC_RAD": 3.0},
            [
                "parameters of another vehicle or component: "
                '2 times, first line 2: vehicle 1, component 100 ("NAV_ACC_RAD")'
            ],
        ),
        ("WPNAV_SPED 500\n", {"WPNAV_SPED": 500.0}, ['parameters that no model uses: line 1 ("WPNAV_SPED")']),
        ("WP_SPD 8\nWPNAV_SPEED 800\n", {"WP_SPD": 8.0, "WPNAV_SPEED": 800.0}, []),
        (
            "WP_SPD 8\nWPNAV_SPEED 500\n",
            {"WP_SPD": 8.0, "WPNAV_SPEED": 500.0},
            ['old name next to WP_SPD: line 2: WPNAV_SPEED ("500")'],
        ),
        (
            "WP_SPD 800\n",
            {"WP_SPD": 800.0},
            ['the unit of WP_SPD, taken as documented: 80 times the default: line 1 ("800")'],
        ),
        (
            "MPC_XY_CRUISE 300\n",
            {"MPC_XY_CRUISE": 300.0},
            ['the unit of MPC_XY_CRUISE, taken as m/s: beyond 40 m/s: line 1 ("300")'],
        ),
        (
            "#\n# Vehicle: Fixed Wing\n1 1 NAV_ACC_RAD 3 9\n",
            {"NAV_ACC_RAD": 3.0},
            ['the vehicle\'s class: taken as multicopter: header ("Fixed Wing")'],
        ),
        (
            "WPNAV_SPEED,80",
            {"WPNAV_SPEED": 80.0},
            ['the rest, if any: the last line has no line end: line 1 ("WPNAV_SPEED")'],
        ),
        ("# only words\n", {}, ["parameters: the file has none: the file"]),
    ],
)
def test_repeated_and_odd_parameters_are_named(
    tmp_path: Path, text: str, parameters: dict[str, float], words: list[str]
) -> None:
    path = tmp_path / "a.params"
    path.write_text(text)
    read = read_parameter_file(path)
    assert read.parameters == parameters
    assert [thing.words for thing in read.unread] == [f"a.params: not read: {each}" for each in words]
    write_mission(MISSION, tmp_path / "a.plan")
    if "WP" not in text:
        findings = read_mission_file(tmp_path / "a.plan").findings
        assert [finding.message for finding in findings if finding.code == "file-parameters"] == [
            thing.words for thing in read.unread
        ]


@pytest.mark.parametrize("others", [0, 150])
@pytest.mark.parametrize(("value", "is_named"), [(2, True), (0, False)])
def test_a_parameter_that_steers_off_the_path_is_named(tmp_path: Path, others: int, value: int, is_named: bool) -> None:
    """ArduPilot #13016, #11566: BendyRuler and Dijkstra's fly round what they sense, and round fences, in AUTO."""
    path = tmp_path / "a.param"
    path.write_text("".join(f"SERVO{n}_TRIM,1500\n" for n in range(others)) + f"RTL_ALT,3000\nOA_TYPE,{value}\n")
    named = [thing.words for thing in read_parameter_file(path).unread if "OA_TYPE, which lets" in thing.what]
    assert bool(named) == is_named


def test_a_whole_list_is_asked_for_what_it_lacks(tmp_path: Path) -> None:
    table = Autopilot.PX4.parameter_table
    lines = [*(f"ZZ_{n} 1" for n in range(200)), *(f"{name} {value}" for name, value in table.moving.items())]
    path = tmp_path / "whole.params"
    path.write_text("\n".join(lines) + "\n")
    assert read_parameter_file(path).unread == ()
    path.write_text(path.read_text().replace("MPC_XY_CRUISE", "MPC_XY_KRUISE"))
    (unread,) = read_parameter_file(path).unread
    assert unread.words.endswith("not read: parameters missing in the list: their defaults apply: MPC_XY_CRUISE")


@given(
    st.dictionaries(
        st.from_regex(r"[A-Z][A-Z0-9_]{0,15}", fullmatch=True), st.floats(-SINGLE_MAX, SINGLE_MAX, allow_nan=False)
    )
)
def test_parameters_written_beside_a_mission_come_back(
    tmp_path_factory: pytest.TempPathFactory, values: dict[str, float]
) -> None:
    path = tmp_path_factory.mktemp("parameters") / "a.plan"
    write_mission(replace(MISSION, parameters=values), path)
    assert read_mission(path).parameters == values


def test_a_failsafe_s_parameter_is_written_as_an_integer(tmp_path: Path) -> None:
    """As the parameters of PX4 1.18's sources."""
    parameters = {"COM_LOW_BAT_ACT": 3.0, "NAV_RCL_ACT": 2.0, "COM_POS_LOW_ACT": 3.0, "COM_WIND_MAX": 8.0}
    write_mission(replace(MISSION, parameters=parameters), tmp_path / "a.plan")
    kinds = [line.split("\t")[4] for line in (tmp_path / "a.params").read_text().splitlines()[2:]]
    assert kinds == ["6", "6", "6", "9"]


def test_a_mission_without_parameters_deletes_the_file_written_before(tmp_path: Path) -> None:
    path = tmp_path / "a.waypoints"
    write_mission(replace(MISSION, parameters={"MPC_XY_VEL_MAX": 9.5, "MPC_YAW_MODE": 1.0}), path)
    lines = (tmp_path / "a.params").read_text().splitlines()
    assert lines[-2:] == ["1\t1\tMPC_XY_VEL_MAX\t9.5\t9", "1\t1\tMPC_YAW_MODE\t1\t6"]
    write_mission(MISSION, path)
    assert not (tmp_path / "a.params").exists()


def test_a_parameter_file_of_somebody_else_stays_as_it_is(tmp_path: Path) -> None:
    theirs = tmp_path / "a.params"
    theirs.write_text(QGROUNDCONTROL)
    write_mission(MISSION, tmp_path / "a.plan")
    assert read_mission(tmp_path / "a.plan").parameters == {"MPC_XY_CRUISE": 7.5, "NAV_DLL_ACT": 0.0}
    with refuses("already-there", "a.params", kind=BadInput):
        write_mission(replace(MISSION, parameters={"MPC_XY_CRUISE": 6.0}), tmp_path / "a.plan")
    assert theirs.read_text() == QGROUNDCONTROL


def test_several_missions_are_written_all_or_none(tmp_path: Path) -> None:
    theirs = tmp_path / "s-2.params"
    theirs.write_text(QGROUNDCONTROL)
    slow = replace(MISSION, parameters={"MPC_XY_CRUISE": 6.0})
    page = {tmp_path / "s.html": "a page"}
    with refuses("already-there", "s-2.params", kind=BadInput):
        write_files([("s-1", slow, {}), ("s-2", slow, {})], tmp_path, page, ("s", {}))
    assert [*tmp_path.iterdir()] == [theirs]
    write_files([("s-1", slow, {}), ("s-2", MISSION, None)], tmp_path, page, ("s", {}))
    written = write_files([("s-1", MISSION, {}), ("s-2", MISSION, None)], tmp_path, page, ("s", {}))
    names = ["s-1.plan", "s-1.waypoints", "s-1.json", "s-2.plan", "s-2.waypoints", "s.html", "s.json"]
    assert [path.name for path in written] == names
    assert {*tmp_path.iterdir()} == {theirs, *written}


@pytest.mark.parametrize(("name", "value"), [("RTL_CONE_ANG", 44.5), ("A" * 20, 1.0), ("MPC ACC", 1.0)])
def test_no_parameters_are_written_that_are_not_read(name: str, value: float, tmp_path: Path) -> None:
    mission = read_mission("missions/sitl.plan")
    with refuses("bad-input"):
        write_mission(replace(mission, parameters={name: value}), tmp_path / "a.plan")
    assert not list(tmp_path.iterdir())


def test_a_name_in_small_letters_is_the_same_parameter() -> None:
    """RTL_RETURN_ALT stayed at 70 in memory, and a written file had 1."""
    mission = read_mission("missions/sitl.plan").with_parameters({"rtl_return_alt": 1.0})
    assert mission.parameters["RTL_RETURN_ALT"] == 1.0
    assert "rtl_return_alt" not in mission.parameters


def test_a_cruise_speed_that_is_none_is_not_written(tmp_path: Path) -> None:
    with refuses("bad-input", "cruise_speed"):
        write_mission(replace(read_mission("missions/sitl.plan"), cruise_speed=-8.0), tmp_path / "a.plan")
