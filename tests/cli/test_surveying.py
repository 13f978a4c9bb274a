import json
import subprocess
import sys
from contextlib import AbstractContextManager
from io import StringIO
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.cli import linking
from ipoa_mission.cli.groups import LinkOptions
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.vehicle import Vehicle
from tests.cli.conftest import Run, Serve
from tests.logs.several import write_several

MISSIONS = Path(__file__).parents[2] / "missions"
SCENARIO = """
home = { latitude_deg = 47.3977, longitude_deg = 8.5456, altitude_amsl = 488 }
[survey]
polygon = [[20, 10], [120, 10], [120, 60], [20, 60]]
camera = "Sony A6000 16mm"
gsd_cm = 2.0
[vehicle]
autopilot = "ardupilot"
cruise_speed = 8.0
airframe = { mass_kg = 2.0, rotor_diameter = 0.3 }
"""
CORNERS = [[8.546, 47.398], [8.547, 47.398], [8.547, 47.3985], [8.546, 47.3985], [8.546, 47.398]]
AREA = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [CORNERS]}}


def test_a_survey_is_planned_checked_shown_and_timed(run: Run, tmp_path: Path) -> None:
    (tmp_path / "field.toml").write_text(SCENARIO)
    ended = run(f"plan {tmp_path}/field.toml --out {tmp_path}/out")
    assert (ended.code, ended.err) == (0, "")
    assert "of the visible part of" in ended.out
    as_json = json.loads(run(f"plan {tmp_path}/field.toml --out {tmp_path}/out --json").out)["survey"]
    assert as_json["covered_share"] > 0.999
    assert as_json["outside_m"] == 0.0
    assert as_json["photos"] > 5
    (flight,) = as_json["flights"]
    assert flight["file"] == "field.plan"
    assert flight["energy_wh"] > 0
    plan = f"{tmp_path}/out/field.plan"
    assert run(f"check {plan} --scenario {tmp_path}/field.toml").code == 0
    assert run(f"show {plan}").code == 0
    estimate = json.loads(run(f"estimate {plan} --scenario {tmp_path}/field.toml --json").out)
    assert estimate["total_s"] == flight["time_s"] or abs(estimate["total_s"] - flight["time_s"]) < 0.01


def test_an_area_is_enough(run: Run, tmp_path: Path) -> None:
    (tmp_path / "area.geojson").write_text(json.dumps(AREA))
    ended = run(f"plan --survey {tmp_path}/area.geojson --autopilot ardupilot --out {tmp_path}/out --json")
    assert (ended.code, ended.err) == (0, "")
    assert json.loads(ended.out)["survey"]["lines"] > 1
    assert (tmp_path / "out" / "area.plan").is_file()


def test_an_area_goes_before_the_goal_of_a_scenario(run: Run, tmp_path: Path) -> None:
    (tmp_path / "area.geojson").write_text(json.dumps(AREA))
    (tmp_path / "field.toml").write_text(SCENARIO)
    ended = run(f"plan {tmp_path}/field.toml --survey {tmp_path}/area.geojson --out {tmp_path}/out --json")
    assert ended.code == 0
    assert json.loads(ended.out)["survey"]["photos"] > 0


def test_faulty_survey_is_bad_input(run: Run, tmp_path: Path) -> None:
    (tmp_path / "area.geojson").write_text(json.dumps(AREA))
    (tmp_path / "field.toml").write_text(SCENARIO.replace('camera = "Sony A6000 16mm"', 'camera = "box"'))
    for command, words in (
        ("plan", "expected a scenario, or an area"),
        (f"plan {tmp_path}/field.toml --height 30", "--height: needs --survey"),
        (f"plan {MISSIONS}/sitl.toml --flown a.tlog", "--flown: expected a survey"),
        (f"plan {tmp_path}/field.toml", "survey.camera: expected the name of a known camera"),
        (f"plan --survey {tmp_path}/no.geojson", "no.geojson"),
        (f"plan --survey {tmp_path}/area.geojson --height 0", "survey.height_above_ground: expected a number greater"),
        (f"plan --survey {tmp_path}/area.geojson --gsd 2", "survey: gsd_cm: needs camera"),
    ):
        ended = run(f"{command} --out {tmp_path}/out" if command != "plan" else command)
        assert ended.code == 2, ended
        assert words in ended.err


def test_its_flights_are_flown_one_after_the_other(run: Run, tmp_path: Path) -> None:
    (tmp_path / "field.toml").write_text(SCENARIO.replace("gsd_cm = 2.0", "gsd_cm = 2.0\nflights = 2"))
    flying = run(f"fly {tmp_path}/field.toml --out {tmp_path}/out --json")
    assert flying.code == 0
    flown = json.loads(flying.out)["flown"]
    assert [flight["file"] for flight in flown] == ["field-1.plan", "field-2.plan"]
    assert all(flight["completed"] for flight in flown)
    assert (tmp_path / "out" / "field-2.tlog").is_file()
    rest = run(f"plan {tmp_path}/field.toml --out {tmp_path}/out --flown {tmp_path}/out/field-1.tlog --json")
    assert rest.code == 0
    left = json.loads(rest.out)["survey"]
    assert [flight["file"] for flight in left["flights"]] == ["field-rest.plan"]
    assert left["lines"] == flown_lines(tmp_path, 2)
    assert "of lines were flown before" in str(json.loads(rest.out)["remarks"])
    ended = run(f"plan {tmp_path}/field.toml --flown {MISSIONS}/logs/campus-arducopter.tlog")
    assert (ended.code, "campus-arducopter.tlog: no flight in it follows" in ended.err) == (2, True)
    both = f"--flown {MISSIONS}/logs/campus-arducopter.tlog --flown {tmp_path}/out/field-1.tlog"
    beside = json.loads(run(f"plan {tmp_path}/field.toml --out {tmp_path}/beside {both} --json").out)
    assert beside["survey"]["lines"] == left["lines"]
    assert sum("arducopter.tlog: no flight in it follows" in words for words in beside["remarks"]) == 1
    field, campus = tmp_path / "out" / "field-1.tlog", MISSIONS / "logs" / "campus-arducopter.tlog"
    several = write_several(tmp_path / "several.tlog", campus, {7: field})
    chosen = run(f"plan {tmp_path}/field.toml --out {tmp_path}/chosen --flown {several} --system 7 --json")
    assert json.loads(chosen.out)["survey"]["lines"] == left["lines"]
    assert sum("not read 1 (ArduPilot multicopter)" in words for words in json.loads(chosen.out)["remarks"]) == 1
    assert run(f"plan {tmp_path}/field.toml --flown {several}").code == 2
    assert "--system: needs --flown" in run(f"plan {tmp_path}/field.toml --system 7").err
    done = run(f"plan {tmp_path}/field.toml --flown {tmp_path}/out/field-1.tlog --flown {tmp_path}/out/field-2.tlog")
    assert (done.code, "no line is left to fly" in done.err) == (2, True)


def flown_lines(folder: Path, flight: int) -> int:
    flights = json.loads((folder / "out" / "field.json").read_text())["survey"]["flights"]
    return int(flights[flight - 1]["lines"])


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def test_next_flight_begins_when_the_battery_is_changed(
    run: Run, autopilot: Serve, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = SCENARIO.replace("120", "40").replace("gsd_cm = 2.0", "gsd_cm = 0.5\nflights = 3")
    (tmp_path / "field.toml").write_text(small)
    fly = f"fly {tmp_path}/field.toml --out {tmp_path}/out --json --link"
    refused = run(f"{fly} udpin:127.0.0.1:14999")
    assert (refused.code, "one by one" in refused.err) == (2, True)
    assert run(f"{fly} udpin:127.0.0.1:14999 --log all.tlog").code == 2
    assert not (tmp_path / "out").exists()
    monkeypatch.setattr(sys, "stdin", Terminal("y\nn\n"))
    systems: list[int | None] = []

    def connect_to(link: str, options: LinkOptions, log: Path | None) -> AbstractContextManager[Vehicle]:
        systems.append(options.system)
        return linking.connect_to(link, options, log)

    monkeypatch.setattr("ipoa_mission.cli.flying.connect_to", connect_to)
    with autopilot(Geodetic(47.3977, 8.5456, 488.0), Autopilot.ARDUPILOT) as link:
        ended = run(f"{fly} {link.removesuffix(' --system 1')}")
    assert systems == [None, 1]  # nobody else's vehicle is armed for the second flight
    outcome = json.loads(ended.out)
    assert [flight["file"] for flight in outcome["flown"]] == ["field-1.plan", "field-2.plan"]
    assert all(flight["completed"] for flight in outcome["flown"])
    assert "field-1 has landed. Fly field-2" in ended.err
    assert (ended.code, outcome["error"]) == (1, "field-3 and later flights were not flown")
    assert (tmp_path / "out" / "field-2.tlog").is_file()


def test_an_error_names_the_area_as_typed_and_a_line_needs_a_width(run: Run, tmp_path: Path) -> None:
    line = {"type": "LineString", "coordinates": [[8.0, 47.0], [8.002, 47.0]]}
    (tmp_path / "river.geojson").write_text(json.dumps({"type": "Feature", "properties": {}, "geometry": line}))
    output = run("plan --survey river.geojson").err
    assert output.startswith("error: --survey: river.geojson: ") or output.startswith("error: river.geojson: ")
    assert "hint: --width M" in output
    assert str(tmp_path) not in run("plan --survey nowhere.geojson").err
    (tmp_path / "missions.toml").touch()
    assert run("plan missions.toml --width 30").err.startswith("error: --width: needs --survey")
    ended = run("plan --survey river.geojson --width 30 --json")
    assert (ended.code, json.loads(ended.out)["survey"]["lines"]) == (0, 2)


def test_closed_pipe_is_no_error(tmp_path: Path) -> None:
    words = f"{sys.executable} -m ipoa_mission schema | head -n 1; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", words], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.splitlines()[-1] == "0"
    assert done.stderr == ""
