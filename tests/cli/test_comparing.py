import json
from pathlib import Path

import pytest
import shapely

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.logs.flight_log import read_flights
from ipoa_mission.mission.mission_io import write_mission
from tests.cli.conftest import Run
from tests.logs.several import write_several

LOGS = Path(__file__).parents[1] / "logs"
OF_117 = "--firmware-version 1.17"  # which its telemetry does not say


@pytest.fixture
def px4_mission(tmp_path: Path) -> Path:
    mission = read_flights(LOGS / "sitl-px4.tlog").flights[0].mission
    assert mission is not None
    write_mission(mission, tmp_path / "sitl.waypoints")
    return tmp_path / "sitl.waypoints"


@pytest.mark.parametrize(
    ("name", "flown_s", "autopilot", "version"),
    [
        ("sitl-ardupilot.bin", 68.08, "ardupilot", ""),
        ("sitl-ardupilot.tlog", 68.08, "ardupilot", ""),
        ("sitl-px4.tlog", 66.37, "px4", OF_117),
    ],
)
def test_the_log_alone_will_do(run: Run, name: str, flown_s: float, autopilot: str, version: str) -> None:
    comparison = json.loads(run(f"compare {LOGS / name} {version} --json").out)
    assert comparison["flown_s"] == pytest.approx(flown_s, abs=0.3)
    assert comparison["completed"]
    assert abs(comparison["total_error"]) < 0.06
    assert comparison["autopilot"] == autopilot
    (flight,) = comparison["flights"]
    assert flight == {**{key: comparison[key] for key in flight}, "remarks": flight["remarks"]}  # the log has some, too


def test_a_flight_that_the_version_taken_does_not_finish_names_the_option(run: Run) -> None:
    ended = run(f"compare {LOGS / 'sitl-px4.tlog'}")
    assert ended.code == 1
    assert "does not reach" in ended.err
    assert "--firmware-version" in ended.err


def test_each_flight_is_held_against_its_own_estimate(run: Run) -> None:
    comparison = json.loads(run(f"compare {LOGS / 'twice-ardupilot.bin'} --json").out)
    assert [flight["flight"] for flight in comparison["flights"]] == [1, 2]
    assert [flight["flown_s"] for flight in comparison["flights"]] == pytest.approx([54.38, 54.62], abs=0.1)
    for flight in comparison["flights"]:
        assert abs(flight["total_error"]) < 0.02, "the second one began where the first one ended"
    output = run(f"compare {LOGS / 'twice-ardupilot.bin'}").out
    assert "flight 2" in output
    second = json.loads(run(f"compare {LOGS / 'twice-ardupilot.bin'} --flight 2 --json").out)
    assert second["flights"] == comparison["flights"][1:]


def test_px4s_own_log_needs_the_mission_and_says_so(run: Run, px4_mission: Path) -> None:
    ended = run(f"compare {LOGS / 'sitl-px4.ulg'}")
    assert ended.code == 1
    assert "PX4 logs no mission" in ended.err
    assert "hint: compare FILE LOG" in ended.err
    comparison = json.loads(run(f"compare {px4_mission} {LOGS / 'sitl-px4.ulg'} --json").out)
    assert comparison["flown_s"] == pytest.approx(66.37, abs=0.05)
    assert comparison["parameters"] == {"MC_ROLL_P": 4.0}


def test_the_flown_path_is_held_against_the_obstacles_of_a_scenario(run: Run, tmp_path: Path) -> None:
    log = LOGS / "sitl-ardupilot.bin"
    flight = read_flights(log).flights[0]
    assert flight.mission is not None
    home, path = flight.mission.home, flight.record().path
    frame = LocalFrame(home)
    middle = path[len(path) // 2]
    east, north, _ = frame.to_local(middle.latitude_deg, middle.longitude_deg, home.altitude)[0]  # type: ignore[arg-type]
    mast = (float(east) + 7.0, float(north))
    (tmp_path / "mast.toml").write_text(
        f"safety_distance = 30.0\n[home]\nlatitude_deg = {home.latitude_deg}\nlongitude_deg = {home.longitude_deg}\n"
        f"altitude_amsl = {home.altitude}\n"
        "[start]\neast = 0\nnorth = 0\nup = 15\n[goal]\neast = 50\nnorth = 0\nup = 15\n"
        "[vehicle]\nradius = 0.5\ncruise_speed = 5\n"
        '[[obstacles]]\nkind = "cylinder"\nname = "mast"\nradius = 1.0\nheight = 500.0\n'
        f"east = {mast[0]}\nnorth = {mast[1]}\n",
        encoding="utf-8",
    )
    clearance = json.loads(run(f"compare {log} --scenario mast.toml --json").out)["clearance"]
    fixes = [frame.to_local(s.latitude_deg, s.longitude_deg, home.altitude)[0, :2] for s in path]  # type: ignore[arg-type]
    truth = shapely.LineString(fixes).distance(shapely.Point(mast)) - 1.0
    assert clearance["least"] == pytest.approx(truth, abs=0.05)
    assert (clearance["to"], clearance["required"], clearance["kept"]) == ("mast", 30.5, False)
    output = run(f"compare {log} --scenario mast.toml").out
    assert "to mast at " in output
    assert "30.50 m required, which was NOT kept" in output


def test_the_climb_and_the_descent_are_no_clearance_of_the_ground(run: Run) -> None:
    scenario = Path(__file__).parents[2] / "missions" / "sitl.toml"
    result = json.loads(run(f"compare {LOGS / 'sitl-px4.tlog'} {OF_117} --scenario {scenario} --json").out)["clearance"]
    assert (result["to"], result["kept"]) == ("mast", True)
    assert result["least"] > result["guaranteed"]


def test_a_log_far_from_the_scenario_says_so(run: Run) -> None:
    campus = Path(__file__).parents[2] / "missions" / "campus.toml"
    outcome = run(f"compare {LOGS / 'sitl-px4.tlog'} {OF_117} --scenario {campus}")
    assert (outcome.code, outcome.err.splitlines()[0]) == (
        2,
        "error: home: it is 8375 km from the scenario's, expected within 100 km",
    )


def test_an_older_version_than_the_model_s_is_told(run: Run, tmp_path: Path) -> None:
    data = (LOGS / "sitl-ardupilot.bin").read_bytes().replace(b"ArduCopter V4.7.0", b"ArduCopter V3.7.0")
    (tmp_path / "old.bin").write_bytes(data)
    assert "flown by ArduCopter 3.7.0-dev, which was not measured" in run("compare old.bin").out


def test_parameters_of_the_command_line_go_before_those_of_the_log(run: Run) -> None:
    own = json.loads(run(f"compare {LOGS / 'sitl-ardupilot.bin'} --json").out)
    comparison = json.loads(run(f"compare {LOGS / 'sitl-ardupilot.bin'} --json --param LAND_SPEED=25").out)
    assert own["parameters"] == {}
    assert comparison["parameters"] == {"LAND_SPEED": 25.0}
    assert comparison["estimated_s"] > own["estimated_s"] + 10


def test_another_mission_than_the_log_s_is_remarked(run: Run, px4_mission: Path) -> None:
    output = run(f"compare {px4_mission} {LOGS / 'sitl-ardupilot.tlog'}").out
    assert "another mission was flown: number of items: 5 in the log, not 7" in output
    comparison = json.loads(run(f"compare {px4_mission} {LOGS / 'sitl-ardupilot.tlog'} --json").out)
    assert sum("number of items: 5 in the log, not 7" in words for words in comparison["remarks"]) == 1


def test_remarks_of_each_flight_are_among_those_of_the_log(run: Run, tmp_path: Path) -> None:
    mission = read_flights(LOGS / "sitl-ardupilot.tlog").flights[0].mission
    assert mission is not None
    write_mission(mission, tmp_path / "other.plan")
    comparison = json.loads(run(f"compare other.plan {LOGS / 'twice-ardupilot.bin'} --json").out)
    for flight in comparison["flights"]:
        assert flight["remarks"]
        for words in flight["remarks"]:
            assert f"flight {flight['flight']}: {words}" in comparison["remarks"]


def test_a_flight_that_began_in_the_middle_is_remarked(run: Run) -> None:
    assert "note: it began at item 6" in run(f"compare {LOGS / 'again-px4.tlog'} {OF_117}").out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("{px4}", "sitl.waypoints: expected a log whose name ends in .tlog, .bin or .ulg"),
        ("{logs}/sitl-px4.ulg --autopilot ardupilot", "expected a log of ardupilot, not of px4"),
        ("{plan} {logs}/sitl-px4.ulg", "sitl.plan: expected a mission for px4"),
        ("{px4} {logs}/sitl-px4.ulg more", "more: expected a mission and a log at most"),
        ("{logs}/twice-ardupilot.bin --flight 3", "--flight 3: expected a number up to 2"),
    ],
)
def test_incompatible_inputs_are_bad_input(
    run: Run, px4_mission: Path, tmp_path: Path, words: str, expected: str
) -> None:
    plan = tmp_path / "sitl.plan"
    mission = read_flights(LOGS / "sitl-ardupilot.tlog").flights[0].mission
    assert mission is not None
    write_mission(mission, plan)
    ended = run(f"compare {words.format(px4=px4_mission, plan=plan, logs=LOGS)}")
    assert ended.code == 2
    assert expected in " ".join(ended.err.split())
    assert "Traceback" not in ended.err


def test_a_log_of_several_vehicles_lists_them_and_compares_one(run: Run, tmp_path: Path) -> None:
    path = write_several(tmp_path / "two.tlog", LOGS / "sitl-ardupilot.tlog", {7: LOGS / "twice-ardupilot.tlog"})
    whole = json.loads(run(f"compare {path} --json").out)
    assert whole["flown_s"] == pytest.approx(68.08, abs=0.3)
    assert sum("not read 7 (ArduPilot multicopter)" in remark for remark in whole["remarks"]) == 1
    of_system_7 = json.loads(run(f"compare {path} --system 7 --json").out)
    assert [round(flight["flown_s"]) for flight in of_system_7["flights"]] == [54, 55]
    learned = run(f"learn {path} --system 7 --out {tmp_path}/v.toml")
    assert "not read 1 (ArduPilot multicopter)" in learned.out + learned.err
    wrong = run(f"compare {path} --system 9")
    assert (wrong.code, "expected system 9, but it holds 1 (ArduPilot multicopter), 7" in wrong.err) == (2, True)
