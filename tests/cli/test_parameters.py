import json
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission import Autopilot, BadInput, estimate, fly_built_in, read_mission, write_mission
from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.autopilot.known_parameters import expect_known, expect_own, firmware_of, translated
from ipoa_mission.logs.flight_log import read_flights
from tests.cli.conftest import Run
from tests.refused import refuses

LOGS = Path(__file__).parents[1] / "logs"


@pytest.fixture
def mission(missions: Path) -> Path:
    return missions / "sitl.plan"


@pytest.mark.parametrize(
    "words",
    [
        "estimate {mission}",
        "show {mission}",
        "check {mission}",
        "fly {mission}",
        "plan {missions}/sitl.toml",
        "fly {missions}/sitl.toml",
        "mock",
    ],
)
def test_every_verb_names_the_parameter_of_the_right_firmware(
    run: Run, mission: Path, missions: Path, words: str
) -> None:
    ended = run(words.format(mission=mission, missions=missions) + " --param WP_SPD=5")
    assert ended.code == 2
    assert ended.out == ""
    assert ended.err == (
        "error: WP_SPD: expected a parameter of px4, not of ardupilot\nhint: px4 has MPC_XY_CRUISE for that\n"
    )
    assert [*Path().rglob("*.plan")] == []


def test_a_name_that_neither_has_is_told_with_the_nearest(run: Run, mission: Path) -> None:
    assert "hint: did you mean MPC_XY_CRUISE?" in run(f"estimate {mission} --param MPC_XY_CRUIS=5").err
    assert "hint: --param-file takes any parameter" in run(f"estimate {mission} --param QWXZ=5").err
    Path("all.params").write_text("QWXZ 5\n")


@pytest.mark.parametrize(
    "words",
    [
        "estimate {m}",
        "show {m}",
        "check {m}",
        "fly {hop}",
        "plan {s} --out o --force",
        "compare {m} {logs}/sitl-px4.tlog",
    ],
)
def test_remarks_of_a_parameter_file_are_in_the_json(run: Run, mission: Path, hop: Path, words: str) -> None:
    Path("all.params").write_text("QWXZ 5\n")
    command = words.format(m=mission, hop=hop, s=mission.with_suffix(".toml"), logs=LOGS)
    ended = run(f"{command} --param-file all.params --json")
    remarks = [words for words in json.loads(ended.out)["remarks"] if "QWXZ" in words]
    assert (ended.code, remarks) == (0, ['all.params: not read: parameters that no model uses: line 1 ("QWXZ")'])
    assert f"note: {remarks[0]}" in run(f"{command} --param-file all.params").out


def test_a_file_of_the_other_firmware_is_named(run: Run, mission: Path) -> None:
    write_mission(read_mission(mission), "x.plan")
    Path("x.params").write_text("WPNAV_ACCEL,100\n")
    assert run("estimate x.plan").err.startswith("error: x.params: WPNAV_ACCEL: expected a parameter of px4")
    assert run("plan x.toml").code == 2


def test_the_parameters_beside_a_waypoints_file_say_whose_it_is(missions: Path, tmp_path: Path) -> None:
    path = tmp_path / "x.waypoints"
    write_mission(replace(read_mission(missions / "campus.plan"), parameters={}), path)
    assert read_mission(path).autopilot is Autopilot.PX4
    (tmp_path / "x.params").write_text("WPNAV_ACCEL,100\n")
    assert read_mission(path).autopilot is Autopilot.ARDUPILOT


def test_a_scenario_names_the_place(run: Run, missions: Path) -> None:
    text = (missions / "sitl.toml").read_text()
    Path("other.toml").write_text(text.replace('"px4"', '"px4"\nparameters = { RTL_ALT = 3000.0 }'))
    assert run("plan other.toml").err.startswith(
        "error: other.toml: vehicle.parameters: RTL_ALT: expected a parameter of px4, not of ardupilot; "
        "px4 has RTL_RETURN_ALT for that\n"
    )


def test_parameters_are_translated_for_another_autopilot_or_left_out(run: Run, missions: Path) -> None:
    """By the parameter references: ArduCopter counts centimeters and milliseconds, PX4 SI units."""
    text = (missions / "sitl.toml").read_text().replace('"px4"', '"ardupilot"')
    own = "parameters = { RTL_ALT_M = 65.0, RTL_LOIT_TIME = 3000.0, WPNAV_JERK = 2.0 }"
    Path("x.toml").write_text(text.replace('"ardupilot"', f'"ardupilot"\n{own}'))
    planned = run("plan x.toml --autopilot px4 --seed 7")
    assert planned.code == 0
    assert "px4 has RTL_RETURN_ALT = 65 for RTL_ALT_M = 65, RTL_LAND_DELAY = 3 for RTL_LOIT_TIME = 3000" in planned.out
    assert "left out, of ardupilot only: WPNAV_JERK" in planned.out
    values = dict(line.split()[2:4] for line in Path("x.params").read_text().splitlines()[2:])
    assert (float(values["RTL_RETURN_ALT"]), float(values["RTL_LAND_DELAY"])) == (65.0, 3.0)
    assert "WPNAV_JERK" not in values
    for words in ("check", "estimate"):
        ended = run(f"{words} x.plan --scenario x.toml")
        assert ended.code == 0
        assert "left out, of ardupilot only: WPNAV_JERK" in ended.out


def test_new_names_of_parameters_tell_their_firmware() -> None:
    assert firmware_of(["WP_SPD", "BATT_MONITOR"]) is Autopilot.ARDUPILOT


def test_a_switch_is_no_quantity_to_translate() -> None:
    parameters = translated({"RTL_LAND_DELAY": -1.0, "RTL_RETURN_ALT": 40.0}, Autopilot.PX4, Autopilot.ARDUPILOT)[0]
    assert parameters == {"RTL_ALT": 4000.0}  # -1: PX4 never lands


def test_parameters_of_the_other_firmware_are_ignored_and_the_check_runs(run: Run, mission: Path) -> None:
    write_mission(read_mission(mission).with_parameters({"RTL_RETURN_ALT": 40.0}), "x.plan")
    checked = run("check x.plan --autopilot ardupilot")
    assert checked.code == 0
    assert "x.params: expected parameters of ardupilot, not of px4: they are ignored [file-parameters]" in checked.out


def test_the_api_refuses_what_no_model_knows(mission: Path) -> None:
    flown = read_mission(mission)
    for job in (estimate, fly_built_in):
        for name, code in (("NONSENSE", "unknown-parameter"), ("WPNAV_SPEED", "bad-input")):
            with refuses(code, name, kind=BadInput):
                job(flown, {name: 1.0})
    assert estimate(flown, {"MIS_TAKEOFF_ALT": 3.0}).total_s == estimate(flown).total_s


@pytest.mark.parametrize("log", sorted(LOGS.glob("*.bin")) + sorted(LOGS.glob("*.ulg")), ids=lambda path: path.name)
def test_parameters_of_real_logs_are_their_own(log: Path) -> None:
    flown = read_flights(log)
    for flight in flown.flights:
        assert len(flight.parameters) > 20
        expect_own(flight.parameters, flown.autopilot)
        assert firmware_of(flight.parameters) is flown.autopilot
        with pytest.raises(BadInput):
            expect_known(flight.parameters, next(each for each in registered() if each is not flown.autopilot))
