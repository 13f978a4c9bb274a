"""Parameter files as ArduPilot's tools and QGroundControl write them, and as people spoil them."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.errors import BadInput
from ipoa_mission.timing.parameters import read_parameters
from ipoa_mission.vehicle import SINGLE_MAX

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
    assert read_parameters(path) == expected


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("WPNAV_SPEED", "line 2: expected a name and a value"),
        ("1 1 WPNAV_SPEED 800", "line 2: expected a name and a value"),
        ("WPNAV_SPEED fast", "line 2: WPNAV_SPEED: expected a number, not 'fast'"),
        ("WPNAV_SPEED nan", "line 2: WPNAV_SPEED: expected a number, not 'nan'"),
        ("WPNAV_SPEED 1e300", "line 2: WPNAV_SPEED: expected a number that fits in single precision, not '1e300'"),
        ("800,WPNAV_SPEED", "line 2: expected a parameter's name"),
    ],
)
def test_a_broken_line_is_named(tmp_path: Path, line: str, message: str) -> None:
    path = tmp_path / "vehicle.parm"
    path.write_text(f"# a comment\n{line}\n")
    with pytest.raises(BadInput, match=message):
        read_parameters(path)


@given(st.dictionaries(st.from_regex(r"[A-Z][A-Z0-9_]{0,15}", fullmatch=True), st.floats(-SINGLE_MAX, SINGLE_MAX)))
def test_what_is_written_comes_back(tmp_path_factory: pytest.TempPathFactory, values: dict[str, float]) -> None:
    path = tmp_path_factory.mktemp("parameters") / "a.params"
    path.write_text("".join(f"1\t1\t{name}\t{value!r}\t9\n" for name, value in values.items()))
    assert read_parameters(path) == values
