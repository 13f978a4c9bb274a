"""Other people's files, by the findings about them (`findings.md` beside the samples)."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check, check_mission
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.logs.flight_log import read_flights
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission, read_mission_file
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.scenario_file import read_scenario
from tests.cli.conftest import Run
from tests.refused import refuses

BEFORE_SPLIT = Version(1, 17)  # PX4 that stops at waypoints which 1.18 may pass

MAVSDK = "mavlink+MAVSDK/cpp/src/mavsdk/plugins/mission_raw/test_plans/qgroundcontrol_sample"
QGC = "DonLakeFlyer+qgroundcontrol/test"
PX4_TESTS = "giahuy-ftel+PX4-Autopilot-v1.17.0/test/mavsdk_tests"


def errors(mission: Mission) -> list[str]:
    return [finding.code for finding in check_mission(mission) if finding.severity is Severity.ERROR]


def scenario(folder: Path, home: tuple[float, float], goal: tuple[float, float], tail: str) -> Scenario:
    text = f"home = {{ latitude_deg = {home[0]}, longitude_deg = {home[1]} }}\n"
    text += f"start = {{ east = 0, north = 0, up = 4 }}\ngoal = {{ east = {goal[0]}, north = {goal[1]}, up = 4 }}\n"
    (folder / "world.toml").write_text(text + tail, encoding="utf-8")
    return read_scenario(folder / "world.toml")


def test_a_buildings_without_height_stand_in_the_way(samples: Path, tmp_path: Path) -> None:
    """Overture's Utrecht: 15 of 3,754 buildings have a height."""
    path = samples / "bertt+overture" / "buildings.geojson"
    longitude, latitude = json.loads(path.read_text())["features"][0]["geometry"]["coordinates"][0][0]
    tail = f"maps = [{{ kind = 'buildings', file = {json.dumps(str(path))} }}]\n[bounds]\nmargin = 20000"
    world = scenario(tmp_path, (latitude, longitude - 0.001), (5, 0), tail)
    assert len(world.airspace.obstacles) >= 3754
    assert any("without a height, given 20 m" in remark for remark in world.remarks)


def test_c_the_plans_that_climbed_obliquely_have_a_time(samples: Path) -> None:
    mission = read_mission(samples / "skhatiri+UAV-Testing-Competition/snippets/case_studies/mission2.plan")
    assert estimate(mission).total_s < 300
    assert not errors(replace(mission, firmware_version=BEFORE_SPLIT))


def test_d_a_log_of_flights_by_hand_has_a_row_for_each(samples: Path, run: Run) -> None:
    """Armed seven times; it rose five times, never in AUTO."""
    path = samples / "dronekit+dronekit-python/examples/flight_replay/flight.tlog"
    log = read_flights(path)
    assert [flight.in_mission for flight in log.flights] == [False] * 5
    ended = run(f"compare '{path}'")
    assert ended.code == 1
    assert ended.out.count("not in a mission") == 5
    assert "nothing in it was flown in ArduPilot's mission mode" in ended.err


def test_e_px4_1_12_is_compared_and_said_to_be_older(samples: Path, run: Run) -> None:
    """42.1 s flown."""
    folder = samples / "skhatiri+Aerialist/samples/flights"
    comparison = json.loads(run(f"compare '{folder / 'mission1.plan'}' '{folder / 'mission1.ulg'}' --json").out)
    assert comparison["flown_s"] == pytest.approx(42.1, abs=0.5)
    assert "flown by PX4 1.12.3, which was not measured" in comparison["model"]


@pytest.mark.parametrize("name", ["FW_mission_1", "VTOL_mission_1"])
def test_f_what_is_no_multicopter_has_no_time(samples: Path, run: Run, name: str) -> None:
    folder = samples / "giahuy-ftel+PX4-Autopilot-v1.17.0/integrationtests/python_src/px4_it/mavros/missions"
    ended = run(f"estimate '{folder / name}.plan'")
    assert ended.code == 1
    assert "only multicopters have a time model" in ended.err
    assert run(f"show '{folder / name}.plan'").code == 0


def test_g_show_prints_a_jump_without_end(samples: Path, run: Run) -> None:
    ended = run(f"show '{samples / QGC / 'MissionManager/MissionPlanner.waypoints.txt'}' --autopilot ardupilot")
    assert ended.code == 0
    assert "no time: " in ended.out


def test_h_a_name_with_a_blank_is_a_name(tmp_path: Path) -> None:
    (tmp_path / "mein Übungsplatz.toml").write_text(
        "home = { latitude_deg = 47, longitude_deg = 8 }\nstart = { east = 0, north = 0, up = 5 }\n"
        "goal = { east = 9, north = 0, up = 5 }"
    )
    assert read_scenario(tmp_path / "mein Übungsplatz.toml").name == "mein Übungsplatz"


#: Accepted files, the autopilot if unnamed, and the code (or the file's words) of a warning.
TAKEN = [
    (f"{MAVSDK}_with_structured_scan.plan", None, "2 rounds are laid out as QGroundControl does"),
    ("mavlink+MAVSDK-Python/examples/example-mission.plan", None, "home has no altitude: taken as 0 m AMSL"),
    (f"{MAVSDK}_with_digicam_control.plan", None, "home-unknown"),
    (f"{MAVSDK}_with_survey_wrong_version.plan", None, "takeoff-missing"),
    (f"{QGC}/MissionManager/SectionTest.plan", None, "ends-in-the-air"),
    ("uci-uav-forge+uavf/tools/offlineMissions/TestArcMission.waypoints", Autopilot.ARDUPILOT, "file-home"),
    (f"{PX4_TESTS}/vtol_mission_with_land_start.plan", None, "QGroundControl flies 15 m, other software params[6]"),
]


@pytest.mark.parametrize(("name", "autopilot", "word"), TAKEN)
def test_items_that_the_firmware_takes_are_read_with_a_warning(
    samples: Path, name: str, autopilot: Autopilot | None, word: str
) -> None:
    file = read_mission_file(samples / name, autopilot)
    assert file.mission.items
    findings = check(Forecast(file.mission), read=file.findings)
    assert any(word == finding.code or (finding.code == "file" and word in finding.message) for finding in findings)


def test_a_plan_that_says_two_heights_of_an_item_is_no_mission_to_send(samples: Path) -> None:
    with refuses("file", "vtol_mission_with_land_start.plan", "15 m", "params[6]", kind=BadInput):
        read_mission(samples / f"{PX4_TESTS}/vtol_mission_with_land_start.plan")


#: Still refused, as by the firmware or every other reader.
REFUSED = [
    (f"{MAVSDK}_without_mission.plan", 'expected "mission", but there is none'),
    (f"{MAVSDK}_wrong_mission_version.plan", "mission.version: expected 2, not 7"),
    (f"{MAVSDK}_wrong_overall_version.plan", "version: expected 1, not 42"),
    ("nxxvaa+fence_test/mission.waypoints", "expected a polygon of 5 vertices, but the list ends before"),
]


@pytest.mark.parametrize(("name", "expected"), REFUSED)
def test_content_that_the_format_refuses_is_refused_in_words(samples: Path, run: Run, name: str, expected: str) -> None:
    ended = run(f"check '{samples / name}' --autopilot ardupilot")
    assert ended.code == 2
    assert expected in " ".join(ended.err.split())
    assert "Traceback" not in ended.err


def test_a_plan_outside_its_own_fence_is_an_error(samples: Path) -> None:
    mission = read_mission(samples / "mavlink+mavros/mavros/test/mavros_py/testdata/simple.plan")
    assert "outside-fence" in errors(mission)


@pytest.mark.parametrize("name", ["sample_appended_multiple", "sample_log_small"])
def test_a_log_without_a_place_on_the_earth_says_so(samples: Path, run: Run, name: str) -> None:
    ended = run(f"compare '{samples / 'PX4+pyulog/test' / name}.ulg'")
    assert ended.code == 2
    assert "expected positions on the Earth, but PX4's local positions have no reference" in " ".join(ended.err.split())


def test_a_shapefile_whose_coordinates_are_none_of_its_system_says_so(samples: Path, tmp_path: Path, run: Run) -> None:
    """Its .prj says degrees on WGS 84; its coordinates are meters."""
    path = samples / QGC / "Utilities/Geo/polygon.shp"
    (tmp_path / "w.toml").write_text(
        "home = { latitude_deg = 47, longitude_deg = 8 }\nstart = { east = 0, north = 0, up = 5 }\n"
        f"goal = {{ east = 9, north = 0, up = 5 }}\nmaps = [{{ kind = 'no_fly', file = {json.dumps(str(path))} }}]"
    )
    ended = run("plan w.toml")
    assert ended.code == 2
    assert "expected longitude and latitude in degrees, not 479820" in " ".join(ended.err.split())
    assert "a Shapefile in its .prj" in " ".join(ended.err.split())


def test_a_kml_of_another_place_says_where_it_is(samples: Path, tmp_path: Path, run: Run) -> None:
    path = samples / QGC / "MissionManager/PolygonGood.kml"
    (tmp_path / "w.toml").write_text(
        "home = { latitude_deg = -5, longitude_deg = 8 }\nstart = { east = 0, north = 0, up = 5 }\n"
        f"goal = {{ east = 9, north = 0, up = 5 }}\nmaps = [{{ kind = 'no_fly', file = {json.dumps(str(path))} }}]"
    )
    message = " ".join(run("plan w.toml").err.split())
    assert "expected places within 100 km of home (-5.0000, 8.0000), not only from " in message
    assert "hint: check that it is the map of this place" in message


def test_several_flight_areas_will_do(samples: Path, tmp_path: Path) -> None:
    path = samples / "Fields2Cover+Fields2Cover/data/test_2_cell.json"
    longitude, latitude = json.loads(path.read_text())["features"][0]["geometry"]["coordinates"][0][0][:2]
    tail = f"maps = [{{ kind = 'flight_area', file = {json.dumps(str(path))} }}]"
    world = scenario(tmp_path, (latitude, longitude), (1, 1), tail)
    assert world.airspace.bounds.footprint is not None
    assert any("an area that does not touch the one around home" in remark for remark in world.remarks)


def test_b_arducopters_own_missions_pass() -> None:
    """ArduPilot's sources at ARDUPILOT_HOME: all that ArduCopter's tests fly.

    One has no take-off. One flies in Japan with a home in Australia: ArduCopter 4.7.0-dev sets out for Japan.
    """
    home = Path(os.environ.get("ARDUPILOT_HOME", "nowhere"))
    folder = home / "Tools" / "autotest" / "ArduCopter_Tests"
    if not folder.is_dir():
        pytest.skip("no sources of ArduPilot at ARDUPILOT_HOME")
    missions = [path for path in sorted(folder.rglob("*.txt")) if path.read_text().startswith("QGC WPL")]
    failed = {path.name: messages for path in missions if (messages := errors(read_mission(path, Autopilot.ARDUPILOT)))}
    assert len(missions) > 25
    assert failed.keys() == {"terrain_wp.txt"}, failed
    assert "expected the take-off first" in failed["terrain_wp.txt"][0]


def test_the_take_offs_of_px4_are_where_they_are(samples: Path) -> None:
    folder = samples / "giahuy-ftel+PX4-Autopilot-v1.17.0/integrationtests/python_src/px4_it/mavros/missions"
    mission = read_mission(folder / "MC_mission_box.plan")
    assert mission.items[0].command == Command.NAV_TAKEOFF
    assert not errors(replace(mission, firmware_version=BEFORE_SPLIT))
