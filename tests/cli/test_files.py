import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ipoa_mission import read_mission, write_export
from tests.cli.conftest import Run, verbs
from tests.refused import refuses

RECORDED = Path(__file__).parent.parent / "mission" / "files" / "hold-px4.waypoints"

ZONE = {
    "type": "Feature",
    "properties": {"identifier": "Z1", "type": "PROHIBITED"},
    "geometry": {
        "type": "Polygon",
        "coordinates": [[[121.9, 39.2], [121.91, 39.2], [121.91, 39.21], [121.9, 39.2]]],
        "layer": {"upper": 9, "upperReference": "WGS84", "uom": "m"},
    },
}


@pytest.fixture
def mission(tmp_path: Path) -> str:
    return str(shutil.copy(RECORDED, tmp_path / "hold.waypoints"))


def test_every_verb_explains_itself_with_an_example(run: Run) -> None:
    names = set(verbs())
    assert {"plan", "check", "estimate", "upload", "download", "fly", "mock", "schema"} <= names
    for name in names:
        help_text = run(f"{name} --help")
        assert help_text.code == 0
        assert f"ipoa-mission {name}" in help_text.out.split("Example:")[1]


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; sys.argv = ['ipoa-mission', '--help']\n"
        "from ipoa_mission.cli.app import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(sorted({'numpy', 'scipy', 'numba', 'pyproj', 'pydantic', 'pymavlink', 'shapely'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.splitlines()[-1] == "[]"


def test_estimate_for_machines_numbers_items_as_in_the_file(run: Run, mission: str) -> None:
    result = json.loads(run(f"estimate {mission} --autopilot px4 --json").out)
    assert [item["seq"] for item in result["items"]] == list(range(1, 18))
    assert result["total_s"] == result["items"][-1]["done_s"] > result["qgroundcontrol_s"] > 0


def test_a_parameter_changes_the_estimate(run: Run, mission: str) -> None:
    slow, usual = (
        json.loads(run(f"estimate {mission} --autopilot ardupilot --json {option}").out)["total_s"]
        for option in ("--param WPNAV_SPEED_UP=50", "")
    )
    assert slow > usual + 20  # 35 m at 0.5 instead of 2.5 m/s


def test_an_unknown_parameter_is_refused_with_the_likely_one(run: Run, mission: str) -> None:
    ended = run(f"estimate {mission} --param WPNAV_ACCELL=500 --autopilot ardupilot")
    assert ended.code == 2
    assert (
        "--param WPNAV_ACCELL: expected a parameter that the models know\nhint: did you mean WPNAV_ACCEL?" in ended.err
    )
    for words in ("WPNAV_ACCEL=500 --autopilot ardupilot", "WP_ACC=5 --autopilot ardupilot", "MPC_TILTMAX_AIR=40"):
        assert run(f"estimate {mission} --param {words}").err == ""


def test_wind_comes_from_where_it_is_said_to_and_costs_time(run: Run, mission: str) -> None:
    calm, blown = (
        json.loads(run(f"estimate {mission} --autopilot ardupilot --json {option}").out)
        for option in ("", "--wind 7@270")
    )
    assert calm["total_s"] != blown["total_s"]
    assert calm["route"]["seconds"] > 0.0 < blown["route"]["seconds"]
    for wrong in ("6", "6@", "@270", "-6@270", "six@270", "1_0@270", "\uff16@270", "nan@0"):
        ended = run(f"estimate {mission} --wind={wrong}")
        assert (ended.code, ended.out) == (2, "")
        assert f"--wind {wrong}: expected a speed [m/s] and the direction it comes from" in ended.err


def test_the_table_of_an_estimate_fits_a_hundred_columns(
    run: Run, mission: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    lines = run(f"estimate {mission} --autopilot ardupilot").out.splitlines()
    assert max(map(len, lines)) <= 100


@pytest.mark.parametrize("value", ["fast", "1_0", "\uff11"])
def test_a_parameter_that_is_no_number_is_bad_input(run: Run, mission: str, value: str) -> None:
    ended = run(f"estimate {mission} --param WPNAV_SPEED={value}")
    assert ended.code == 2
    assert f"--param WPNAV_SPEED={value}: expected NAME=VALUE with a number" in ended.err


def test_a_file_that_is_not_there_is_bad_input_without_a_traceback(run: Run) -> None:
    for verb in ("check", "estimate", "show"):
        ended = run(f"{verb} nothing.plan")
        assert (ended.code, ended.out) == (2, "")
        assert "error: nothing.plan: cannot be read: No such file or directory" in ended.err
        assert "Traceback" not in ended.err


def test_a_name_with_a_nul_character_is_bad_input(mission: str) -> None:
    with refuses("unreadable", "b.plan", "NUL"):
        read_mission("a\0b.plan")
    with refuses("unwritable", "b.kml", "NUL"):
        write_export(read_mission(mission), "a\0b.kml")


def test_check_passes_a_mission_that_flew(run: Run, mission: str) -> None:
    ended = run(f"check {mission} --autopilot px4 --firmware-version 1.17")
    assert ended.code == 0
    assert "0 errors" in ended.out


def test_check_fails_a_mission_that_would_crash(run: Run, mission: str) -> None:
    path = Path(mission)
    path.write_text(path.read_text().replace("39.10110843", "0.00000000").replace("121.82017930", "0.00000000"))
    ended = run(f"check {mission} --json")
    assert ended.code == 1
    result = json.loads(ended.out)
    assert not result["ok"]
    assert 4 in {finding["seq"] for finding in result["findings"] if finding["severity"] == "error"}


def test_show_prints_each_item_with_its_leg(run: Run, mission: str) -> None:
    rows = json.loads(run(f"show {mission} --json").out)["items"]
    assert rows[3]["seq"] == 3
    assert rows[5]["length"] == pytest.approx(19.7, abs=0.1)
    assert "NAV_TAKEOFF" in run(f"show {mission}").out


def test_show_prints_the_notes_that_estimate_prints(run: Run, mission: str, tmp_path: Path) -> None:
    (tmp_path / "zones.json").write_text(json.dumps({"type": "FeatureCollection", "features": [ZONE]}))
    home = "home = { latitude_deg = 39.103, longitude_deg = 121.821, altitude_amsl = 20.0 }\n"
    ends = "start = { east = 0, north = 0, up = 10 }\ngoal = { east = 9, north = 0, up = 10 }\n"
    maps = "maps = [{ kind = 'no_fly', file = 'zones.json' }]"
    (tmp_path / "w.toml").write_text(home + ends + maps)
    for words in (f"{mission}", f"{mission} --scenario {tmp_path}/w.toml"):
        shown, estimated = (run(f"{verb} {words}").out.splitlines() for verb in ("show", "estimate"))
        notes = [line for line in shown if line.startswith("note: ")]
        assert notes == [line for line in estimated if line.startswith("note: ")]
    assert any("not read: geoid under the upper limit, taken as -107 m" in note for note in notes)
    for verb in ("show", "estimate"):
        result = json.loads(run(f"{verb} {words} --json").out)
        assert result["remarks"] == [note.removeprefix("note: ") for note in notes]
        assert [thing["example"] for thing in result["unread"]] == ["9 m WGS84"]


def test_export_says_for_which_autopilot_it_read_a_file(run: Run, mission: str, tmp_path: Path) -> None:
    (note,) = [line for line in run(f"show {mission}").out.splitlines() if line.startswith("note: read for ")]
    assert note in run(f"export {mission} {tmp_path}/a.kml").out.splitlines()
    result = json.loads(run(f"export {mission} {tmp_path}/a.plan --json").out)
    assert note.removeprefix("note: ") in result["remarks"]
    assert "read for" not in run(f"export {tmp_path}/a.plan {tmp_path}/b.kml").out


@pytest.mark.parametrize("suffix", ["kml", "geojson", "csv", "gpx", "plan"])
def test_export_writes_what_the_suffix_says(run: Run, mission: str, suffix: str) -> None:
    assert run(f"export {mission} out.{suffix}").code == 0
    assert Path(f"out.{suffix}").stat().st_size > 500


def test_schema_is_a_json_schema_of_the_scenario(run: Run) -> None:
    schema = json.loads(run("schema").out)
    assert schema["required"] == ["home"]
    assert schema["anyOf"] == [{"required": ["start", "goal"]}, {"required": ["survey"]}]


def test_new_writes_a_scenario_and_never_over_one(run: Run) -> None:
    words = "new first.toml --home 47.3977 8.5456 488"
    assert run(words).code == 0
    ended = run(words)
    assert ended.code == 2
    assert "--force" in ended.err


def test_a_waypoints_file_is_not_taken_for_an_autopilot_in_silence(run: Run, tmp_path: Path) -> None:
    plain = tmp_path / "plain.waypoints"
    rows = ["0\t1\t0\t16\t0\t0\t0\t0\t47.06\t9.71\t612\t1", "1\t0\t3\t22\t0\t0\t0\t0\t47.06\t9.71\t20\t1"]
    rows += ["2\t0\t3\t16\t0\t0\t0\t0\t47.061\t9.71\t20\t1", "3\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1"]
    plain.write_text("\n".join(["QGC WPL 110", *rows]) + "\n")
    for verb in ("check", "estimate", "show"):
        assert "the file does not name its autopilot; --autopilot px4|ardupilot decides" in run(f"{verb} {plain}").out
    assert "nothing says for which" not in run(f"check {plain} --autopilot px4").out
    assert "for ardupilot 4.6" in run(f"check {plain} --firmware-version 4.6").out
    assert "for px4 1.16" in run(f"check {plain} --firmware-version 1.16").out
    spline = tmp_path / "spline.waypoints"
    spline.write_text(plain.read_text().replace("\t3\t16\t", "\t3\t82\t"))
    of_spline = run(f"check {spline}")
    why = "read for ardupilot: item 2 (NAV_SPLINE_WAYPOINT): PX4 does not take it"
    assert (of_spline.code, why in of_spline.out) == (0, True)
    ended = run(f"check {RECORDED.parents[3] / 'missions' / 'sitl.plan'} --firmware-version 4.6")
    assert (ended.code, "--autopilot ardupilot" in ended.err) == (2, True)


def test_check_takes_files_and_folders_with_one_exit_code(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "ci"
    (folder / "deep").mkdir(parents=True)
    packed = RECORDED.parents[3] / "missions"
    shutil.copy(packed / "sitl.plan", folder / "good.plan")
    shutil.copy(packed / "campus.plan", folder / "deep" / "fine.plan")
    good = run("check ci")
    assert (good.code, good.out.splitlines()[-1]) == (0, "2 files: 0 errors, 0 warnings")
    shutil.copy(RECORDED.parents[2] / "data" / "odd" / "fixed_wing.plan", folder / "plane.plan")
    wrong = run("check ci/good.plan ci --json")
    result = json.loads(wrong.out)
    assert (wrong.code, result["ok"]) == (1, False)
    assert [file["file"] for file in result["files"]] == ["ci/good.plan", "ci/deep/fine.plan", "ci/plane.plan"]
    (folder / "broken.plan").write_text("")
    unreadable = run("check ci")
    assert (unreadable.code, "ci/broken.plan: not checked" in unreadable.out) == (2, True)
    found = {(file["file"], each["code"]) for file in result["files"] for each in file["findings"]}
    assert found == {("ci/plane.plan", "other-vehicle")}
    (tmp_path / "none").mkdir()
    assert (run("check none").code, run("check ci/broken.plan").code) == (2, 2)


def test_a_planes_mission_fails_unless_it_is_to_be_judged_anyway(run: Run) -> None:
    plane = RECORDED.parents[2] / "data" / "odd" / "fixed_wing.plan"
    assert run(f"check {plane}").code == 1
    assert run(f"check {plane} --anyway").code == 0
    assert "1 error, 0 warnings" in run(f"check {plane}").out
    assert run(f"fly {plane}").code != 0
