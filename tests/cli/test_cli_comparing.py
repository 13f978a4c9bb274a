"""`compare` on logs of real autopilots: with a mission file and without, one flight and several."""

import json
from pathlib import Path

import pytest

from ipoa_mission.link.flight_log import read_flights
from ipoa_mission.mission.files import write_mission
from tests.cli.conftest import Run

LOGS = Path(__file__).parents[1] / "logs"


@pytest.fixture
def px4_mission(tmp_path: Path) -> Path:
    mission = read_flights(LOGS / "sitl-px4.tlog").flights[0].mission
    assert mission is not None
    write_mission(mission, tmp_path / "sitl.waypoints")
    return tmp_path / "sitl.waypoints"


@pytest.mark.parametrize(
    ("name", "flown_s", "autopilot"),
    [
        ("sitl-ardupilot.bin", 68.08, "ardupilot"),
        ("sitl-ardupilot.tlog", 68.08, "ardupilot"),
        ("sitl-px4.tlog", 66.37, "px4"),
    ],
)
def test_the_log_alone_will_do(run: Run, name: str, flown_s: float, autopilot: str) -> None:
    held = json.loads(run(f"compare {LOGS / name} --json").out)
    assert held["flown_s"] == pytest.approx(flown_s, abs=0.3)
    assert held["completed"]
    assert abs(held["total_error"]) < 0.06
    assert held["autopilot"] == autopilot
    assert held["flights"] == [{key: held[key] for key in held["flights"][0]}]


def test_each_flight_is_held_against_its_own_estimate(run: Run) -> None:
    held = json.loads(run(f"compare {LOGS / 'twice-ardupilot.bin'} --json").out)
    assert [flight["flight"] for flight in held["flights"]] == [1, 2]
    assert [flight["flown_s"] for flight in held["flights"]] == pytest.approx([54.38, 54.62], abs=0.1)
    for flight in held["flights"]:
        assert abs(flight["total_error"]) < 0.02, "the second one began where the first one ended"
    said = run(f"compare {LOGS / 'twice-ardupilot.bin'}").out
    assert "flight 2" in said
    second = json.loads(run(f"compare {LOGS / 'twice-ardupilot.bin'} --flight 2 --json").out)
    assert second["flights"] == held["flights"][1:]


def test_px4s_own_log_needs_the_mission_and_says_so(run: Run, px4_mission: Path) -> None:
    ended = run(f"compare {LOGS / 'sitl-px4.ulg'}")
    assert ended.code == 1
    assert "PX4 does not write its mission into its logs" in ended.err
    assert "hint: compare FILE LOG" in ended.err
    held = json.loads(run(f"compare {px4_mission} {LOGS / 'sitl-px4.ulg'} --json").out)
    assert held["flown_s"] == pytest.approx(66.37, abs=0.05)
    assert held["parameters"] == {"RTL_RETURN_ALT": 30.0, "RTL_DESCEND_ALT": 10.0, "MC_ROLL_P": 4.0}


def test_parameters_of_the_command_line_go_before_those_of_the_log(run: Run) -> None:
    own = json.loads(run(f"compare {LOGS / 'sitl-ardupilot.bin'} --json").out)
    held = json.loads(run(f"compare {LOGS / 'sitl-ardupilot.bin'} --json --param LAND_SPEED=25").out)
    assert own["parameters"] == {}
    assert held["parameters"] == {"LAND_SPEED": 25.0}
    assert held["estimated_s"] > own["estimated_s"] + 10


def test_another_mission_than_the_log_s_is_remarked(run: Run, px4_mission: Path) -> None:
    said = run(f"compare {px4_mission} {LOGS / 'sitl-ardupilot.tlog'}").out
    assert "another mission was flown: number of items: 6 in the log, not 8" in said


def test_a_flight_that_began_in_the_middle_is_remarked(run: Run) -> None:
    assert "note: it began at item 6" in run(f"compare {LOGS / 'again-px4.tlog'}").out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("{px4}", "sitl.waypoints: expected a log whose name ends in .tlog, .bin or .ulg"),
        ("{logs}/sitl-px4.ulg --autopilot ardupilot", "expected a log of ardupilot, not of px4"),
        ("{plan} {logs}/sitl-px4.ulg", "sitl.plan: expected a mission for px4"),
        ("{px4} {logs}/sitl-px4.ulg more", "more: expected a mission and a log at most"),
        ("{logs}/twice-ardupilot.bin --flight 3", "--flight 3: expected a number up to 2"),
        ("{logs}/twice-ardupilot.bin --picture both.svg", "--picture: expected --flight N too"),
    ],
)
def test_what_does_not_go_together_is_bad_input(
    run: Run, px4_mission: Path, tmp_path: Path, words: str, told: str
) -> None:
    plan = tmp_path / "sitl.plan"
    mission = read_flights(LOGS / "sitl-ardupilot.tlog").flights[0].mission
    assert mission is not None
    write_mission(mission, plan)
    ended = run(f"compare {words.format(px4=px4_mission, plan=plan, logs=LOGS)}")
    assert ended.code == 2
    assert told in " ".join(ended.err.split())
    assert "Traceback" not in ended.err
