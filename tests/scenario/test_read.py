import json
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from ipoa_mission.errors import BadInput
from ipoa_mission.scenario import Scenario, parse_scenario, read_scenario
from ipoa_mission.scenario.obstacles import ObstacleSection
from ipoa_mission.scenario.place_sections import Place
from tests.refused import refuses

HERE = Path("here.toml")
SECTIONS = get_args(get_args(ObstacleSection)[0])
OBSTACLE_KINDS = [kind for section in SECTIONS for kind in get_args(section.model_fields["kind"].annotation)]
SMALLEST = """
home = { latitude_deg = 47.0, longitude_deg = 8.0 }
start = { east = 0, north = 0, up = 10 }
goal = { east = 100, north = 0, up = 10 }
"""

BROKEN = {
    "home = 3": "home: expected a table, not 3",
    "home = { latitude_deg = 91, longitude_deg = 8 }": "home.latitude_deg: expected a number of at most 90, not 91",
    "home = { longitude_deg = 8 }": "home.latitude_deg: expected, but not there",
    "start = { east = 0, up = 3 }": "start: expected either east and north, or latitude_deg and longitude_deg",
    "start = { east = 0, north = 0 }": "start: expected either up, or altitude_amsl, or height_above_ground",
    "goal = {latitude_deg = 46, longitude_deg = 8, up = 9}": "goal: expected a place within 100 km of home, not 111 km",
    "goal = {latitude_deg = 8, longitude_deg = 47, up = 9}": (
        "goal: expected a place within 100 km of home, not 5687 km: latitude and longitude may be swapped, "
        "in home or in goal"
    ),
    "vehicle = { cruise_speed = 800 }": (
        "vehicle: cruise_speed: expected at most 40 m/s, unless MPC_XY_VEL_MAX allows more, not 800: "
        "is it in cm/s? 8 m/s"
    ),
    "vehicle = { autopilot = 'ardupilot', climb_speed = 250 }": (
        "vehicle: climb_speed: expected at most 40 m/s, unless WPNAV_SPEED allows more, not 250: is it in cm/s? 2.5 m/s"
    ),
    "goal = { east = 0, nort = 0, up = 1 }": "goal.nort: unknown key; did you mean north?",
    "ignore = ['battery-reserve']": "ignore: unknown key; ignore belongs in [safety]",
    "survey = { line_spacin = 3 }": "survey.line_spacin: unknown key; did you mean line_spacing?",
    "safety_distance = -1": "safety_distance: expected a number of at least 0, not -1",
    "safety_distance = inf": "safety_distance: expected a finite number, not inf",
    "goal = { east = true, north = 0, up = 1 }": "goal.east: expected a number, not true",
    "wind = { speed = 3, from_deg = '1_0' }": "wind.from_deg: expected a number, not '1_0'",
    "vehicle = { parameters = { MPC_Z_P = '5' } }": "vehicle.parameters.MPC_Z_P: expected a number, not '5'",
    "fence = [{ polygon = [[true, 0], [9, 0], [9, 9]] }]": "fence[0].polygon[0][0]: expected a number, not true",
    "time = 2026": "time: expected a time with its offset, such as 2026-11-22T10:00:00Z, not '2026'",
    "safety_distance = 'far'": "safety_distance: expected a number, not 'far'",
    "name = 'a:b'": "name: expected a valid file name, not 'a:b'",
    "obstacles = [{ kind = 'sphere', east = 0, north = 0, radius = -3 }]": (
        "obstacles[0].radius: expected a number greater than 0, not -3"
    ),
    "obstacles = [{ kind = 'pyramid' }]": (
        f"obstacles[0].kind: expected {', '.join(map(repr, OBSTACLE_KINDS))}, not 'pyramid'"
    ),
    "obstacles = [{ radius = 3 }]": "obstacles[0].kind: expected, but not there",
    "obstacles = [{ kind = 'prism', height = 3, footprint = [[0, 0], [1, 0]] }]": (
        "obstacles[0].footprint: expected at least 3 entries, not 2"
    ),
    "obstacles = [{ kind = 'box', east = 0, north = 0, width = 1, depth = 1, heigth = 1, height = 1 }]": (
        "obstacles[0].heigth: unknown key; did you mean height?"
    ),
    "safety = { confidence = 99 }": "safety.confidence: expected a number of at most 0.999, not 99, or 'nominal'",
    "safety = { confidence = 'high' }": "safety.confidence: expected a number, not 'high', or 'nominal'",
    "wind = { speed = 5, exponent = 0.2 }": (
        "wind: expected a gradient_height above 0 with the exponent, which has no effect without one"
    ),
    "bounds = { east = [3, 1] }": "bounds.east: expected [least, greatest], not [3, 1]",
    "cost = { omega = [0.5, 0.5, 0.5] }": "cost: omega: expected three weights that sum to 1, not to 1.5",
    "vehicle = { autopilot = 'betaflight' }": "vehicle.autopilot: expected 'px4' or 'ardupilot', not 'betaflight'",
    "terrain = { kind = 'grid', east = 0, north = 0, spacing = 1 }": "terrain: expected either heights, or file",
    "terrain = { kind = 'grid', east = 0, north = 0, spacing = 1, file = 'no.csv' }": (
        "terrain.file: expected a file of heights, but there is no file no.csv"
    ),
    "planning = { control_points = 2.5 }": "planning.control_points: expected a whole number, not 2.5",
}


@pytest.mark.parametrize(("line", "words"), BROKEN.items(), ids=BROKEN.values())
def test_faults_are_named_with_their_place(line: str, words: str) -> None:
    key = line.split(" ")[0]
    text = line + "\n" + "\n".join(row for row in SMALLEST.splitlines() if not row.startswith(key))
    with pytest.raises(BadInput) as caught:
        parse_scenario(text, HERE)
    assert str(caught.value) == f"here.toml: {words}"


@pytest.mark.parametrize("parameter", ["WPNAV_SPEED = 4500", "WP_SPD = 45"])
def test_a_faster_vehicle_says_so_by_its_own_parameter(parameter: str) -> None:
    own = f"vehicle = {{ autopilot = 'ardupilot', cruise_speed = 44, parameters = {{ {parameter} }} }}"
    assert parse_scenario(f"{SMALLEST}\n{own}", HERE).vehicle.cruise_speed == 44


def test_a_parameter_that_no_model_uses_is_a_remark() -> None:
    own = "vehicle = { parameters = { MPC_XY_CRUIZE = 4, Q = 1, MPC_XY_CRUISE = 4, SYS_AUTOSTART = 4001 } }"
    assert parse_scenario(f"{SMALLEST}\n{own}", HERE).remarks == (
        "vehicle.parameters.MPC_XY_CRUIZE: no model uses it; did you mean MPC_XY_CRUISE?",
        "vehicle.parameters.Q: no model uses it",
    )


def test_all_mistakes_are_told_at_once() -> None:
    with pytest.raises(BadInput) as caught:
        parse_scenario("", HERE)
    assert str(caught.value).splitlines() == [
        f"here.toml: {key}: expected, but not there" for key in ("home", "start", "goal")
    ]


def test_a_file_that_is_no_toml_names_the_line() -> None:
    with refuses("wrong-format", "here.toml", "line 2"):
        parse_scenario("a = 1\nb = = 2\n", HERE)


def test_a_file_that_is_not_there_is_bad_input(tmp_path: Path) -> None:
    with refuses("unreadable", "nothing.toml"):
        read_scenario(tmp_path / "nothing.toml")


def test_the_smallest_scenario_is_home_start_and_goal() -> None:
    scenario = parse_scenario(SMALLEST, HERE)
    assert scenario.name == "here"
    np.testing.assert_allclose(scenario.goal_point, [100, 0, 10])
    assert scenario.airspace.clearance(np.array([[50.0, 0.0, 10.0]]))[0] == pytest.approx(10)


def test_a_geodetic_start_is_the_same_place_as_its_local_twin() -> None:
    pymap3d = pytest.importorskip("pymap3d")
    latitude, longitude, altitude = pymap3d.enu2geodetic(80.0, -60.0, 25.0, 47.0, 8.0, 0.0)
    text = SMALLEST.replace(
        "start = { east = 0, north = 0, up = 10 }",
        f"start = {{ latitude_deg = {latitude}, longitude_deg = {longitude}, altitude_amsl = {altitude} }}",
    )
    np.testing.assert_allclose(parse_scenario(text, HERE).start_point, [80, -60, 25], atol=1e-3)


def test_obstacles_without_a_base_begin_at_the_ground() -> None:
    text = (
        SMALLEST
        + """
    terrain = { kind = "grid", east = -100, north = -100, spacing = 200, heights = [[0, 20], [0, 20]] }
    obstacles = [
      { kind = "cylinder", east = 0, north = 0, radius = 10, height = 5 },
      { kind = "box", east = 0, north = 0, width = 20, depth = 40, height = 5, heading_deg = 90 },
      { kind = "prism", footprint = [[-10, -10], [10, -10], [10, 10]], height = 5 },
      { kind = "sphere", east = 0, north = 0, radius = 2 },
      { kind = "sphere", east = 0, north = 0, radius = 2, up = 50 },
    ]
    """
    )
    cylinder, box, prism, ball, balloon = (body.bounds[:, 2] for body in parse_scenario(text, HERE).airspace.obstacles)
    assert cylinder == pytest.approx((9, 16))  # ground rises 1 m in 10 m eastwards
    assert box == pytest.approx((8, 17))  # turned by 90 degrees: 40 m east
    assert prism == pytest.approx((9, 16))
    assert ball == pytest.approx((10, 14))
    assert balloon.tolist() == [48, 52]


def test_a_box_turns_clockwise_from_north() -> None:
    text = SMALLEST + "obstacles = [{kind='box', east=0, north=0, width=2, depth=20, height=5, heading_deg=45}]"
    (box,) = parse_scenario(text, HERE).airspace.obstacles
    north_east, north_west = np.array([[6.0, 6.0, 1.0]]), np.array([[-6.0, 6.0, 1.0]])
    assert box.distance(north_east)[0] < 0 < box.distance(north_west)[0]


def test_speeds_become_the_autopilots_own_parameters() -> None:
    text = SMALLEST + "vehicle = { autopilot = 'ardupilot', climb_speed = 3, parameters = { WPNAV_ACCEL = 300 } }"
    assert parse_scenario(text, HERE).vehicle.autopilot_parameters() == {"WPNAV_SPEED_UP": 300, "WPNAV_ACCEL": 300}


def test_the_schema_accepts_what_the_reader_accepts(missions: Path) -> None:
    import tomllib

    validator = Draft202012Validator(Scenario.model_json_schema())
    for path in sorted(missions.glob("*.toml")):
        read_scenario(path)
        validator.validate(json.loads(json.dumps(tomllib.loads(path.read_text(encoding="utf-8")))))


def test_a_copy_with_another_start_forgets_what_followed_from_the_old_one(missions: Path) -> None:
    scenario = read_scenario(missions / "sitl.toml")
    assert scenario.airspace.obstacles
    assert scenario.start_point[2] != 33.0
    moved = scenario.model_copy(update={"obstacles": (), "start": Place(east=1.0, north=2.0, up=33.0)})
    assert moved.start_point.tolist() == [1.0, 2.0, 33.0]
    assert moved.airspace.obstacles == ()
    assert scenario.start_point[2] != 33.0


NONSENSE = {
    "a = " + "[" * 50_000 + "]" * 50_000: "endlessly nested brackets",
    "a = " + "{b=" * 50_000 + "1" + "}" * 50_000: "endlessly nested brackets",
    "a = " + "9" * 6_000: "not one of thousands of digits",
    "[vehicle]\nparameters.WPNAV_SPEED = 1e300": "vehicle.parameters.WPNAV_SPEED: expected a number of at most 3.4e+38",
}


@pytest.mark.parametrize(("text", "expected"), NONSENSE.items(), ids=[text[:12] for text in NONSENSE])
def test_nonsense_without_end_is_an_error_at_once(text: str, expected: str) -> None:
    with pytest.raises(BadInput) as error:
        parse_scenario(text, Path("a.toml"))
    assert expected in str(error.value)


def test_strings_that_never_end_are_read_once() -> None:
    with pytest.raises(BadInput):
        parse_scenario('\\"""' * 200_000, Path("a.toml"))


def test_flat_ground_over_kilometers_follows_the_earth() -> None:
    text = SMALLEST.replace(
        "goal = { east = 100, north = 0, up = 10 }", "goal = {east = 3000, north = 0, height_above_ground = 10}"
    )
    scenario = parse_scenario(text, HERE)
    assert scenario.frame.geodetic(scenario.goal_point).altitude == pytest.approx(
        scenario.home.altitude_amsl + 10, abs=0.01
    )
    assert scenario.goal_point[2] == pytest.approx(10 - 3000**2 / 2 / 6.37e6, abs=0.01)


@pytest.mark.parametrize(("east", "side"), [(-200, None), (-140, "130.0 east"), (0, "50.0 west")])
def test_a_grid_smaller_than_the_flight_is_refused(east: int, side: str | None) -> None:
    """Bounds from 50 m west to 150 m east; a grid counts to half its spacing beyond its edge."""
    text = SMALLEST + f"terrain = {{ kind = 'grid', east = {east}, north = -200, spacing = 80, heights = {{}} }}"
    rows = 6 if side is None else 3
    text = text.replace("{}", str([[0.0] * rows] * 6))
    if side is None:
        parse_scenario(text, HERE)
        return
    with refuses("not-covered", "terrain", *side.split()):
        parse_scenario(text, HERE)


def test_true_is_no_number_and_a_slip_is_told_with_what_it_may_have_been(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "missions" / "sitl.toml").read_text()
    path = tmp_path / "x.toml"
    path.write_text(
        text.replace("cruise_speed = 8.0", "cruise_speed = true\nspeed = 8.0")
        + '[[obstacles]]\nkind = "prism"\nfootprint = [[10, 10], [20, 20], [20, 10], [10, 20]]\nheight = 5\n'
    )
    with pytest.raises(BadInput) as refused:
        read_scenario(path)
    lines = str(refused.value).splitlines()
    assert f"{path}: vehicle.cruise_speed: expected a number, not true" in lines
    assert f"{path}: vehicle.speed: unknown key; did you mean cruise_speed, climb_speed or descent_speed?" in lines
    assert any(".footprint: expected a ring that does not cross itself" in line for line in lines)
    path.write_text(text.replace("east = 120.0", "east = 1e308"))
    with refuses("bad-input", "x.toml", "1e", "305") as far:
        read_scenario(path)
    assert far.value.hint is None


def test_a_decimal_comma_is_named() -> None:
    with refuses("wrong-format", "here.toml: line 2", "47.06", "47,06"):
        parse_scenario("[home]\nlatitude_deg = 47,06  # as at home\n", HERE)
