import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.simulator.fly import fly_built_in
from tests.cli.conftest import Planned, Run
from tests.examples import some
from tests.refused import refuses

REPOSITORY = Path(__file__).parents[2]
SCENARIOS = sorted(path.stem for path in (REPOSITORY / "missions").glob("*.toml"))


def test_fly_plans_writes_uploads_flies_and_compares(run: Run, missions: Path) -> None:
    ended = run(f"fly {missions / 'sitl.toml'} --out out --seed 3 --report")
    assert ended.code == 0, ended.err
    assert "least clearance" in ended.out
    words = ended.out.splitlines()[-2]
    assert ended.out.splitlines()[-1] == "written: out/sitl.html, out/sitl.tlog"
    assert words.startswith("estimated ")
    assert "flown" in words
    assert re.search(r"; QGroundControl would have said \d+ s$", words)
    assert ended.out.count("QGroundControl would") == 1
    assert "QGroundControl would say" in Path("out/sitl.html").read_text(encoding="utf-8")
    assert "QGroundControl 4.4 loses the take-off" in ended.out
    assert {path.name for path in Path("out").iterdir()} == {
        f"sitl.{suffix}" for suffix in ("plan", "waypoints", "json", "params", "tlog", "html")
    }


@pytest.mark.long
@pytest.mark.parametrize("name", SCENARIOS)
def test_the_shipped_files_are_what_is_written_today(run: Run, name: str) -> None:
    assert run(f"plan {REPOSITORY / 'missions' / name}.toml --out out").code == 0
    for path in Path("out").iterdir():
        assert path.read_bytes() == (REPOSITORY / "missions" / path.name).read_bytes(), path.name


def test_fly_tells_machines_when_each_item_was_done(run: Run, planned: Planned) -> None:
    mission = planned("sitl")[1] / "sitl.plan"
    result = json.loads(run(f"fly {mission} --out out --autopilot ardupilot --json").out)
    assert result["completed"]
    assert 1 < result["items"][-1]["seq"] <= len(read_mission(mission).items)
    assert result["flown_s"] > result["estimate"]["qgroundcontrol_s"]
    assert "no landing" in result["estimate"]["qgroundcontrol_counts"]
    assert result["written"] == ["out/sitl.tlog"]


def test_a_mission_file_flies_without_its_scenario(run: Run, planned: Planned) -> None:
    _, folder = planned("sitl")
    ended = run(f"fly {folder}/sitl.plan --out flown")
    assert ended.code == 0, ended.err
    assert [path.name for path in Path("flown").iterdir()] == ["sitl.tlog"]


@pytest.mark.parametrize("autopilot", registered())
def test_a_refused_item_is_named_by_its_number_for_both_autopilots(planned: Planned, autopilot: Autopilot) -> None:
    mission = read_mission(planned("sitl")[1] / "sitl.plan", autopilot)
    wrong = Item(177, 2, (99.0, 1.0, 0.0, 0.0))  # a jump to nowhere
    if autopilot is Autopilot.PX4:
        wrong = Item(5003, 3, (20.0, 0.0, 0.0, 0.0), 47.0, 8.0)  # of a fence
    items = (*mission.items[:2], wrong, *mission.items[3:])
    with refuses("mission-refused", "", "item 3 ", "ERROR"):
        fly_built_in(replace(mission, items=items))


@pytest.mark.parametrize("name", some(2, SCENARIOS))
def test_both_formats_hold_the_same_mission_and_it_passes_the_checks(run: Run, missions: Path, name: str) -> None:
    if name == "oldtown":
        pytest.importorskip("rasterio")
    plan = read_mission(missions / f"{name}.plan")
    lines = read_mission(missions / f"{name}.waypoints", plan.autopilot)
    assert [_essence(item) for item in lines.items] == [_essence(item) for item in plan.items]
    ended = run(f"check {missions / name}.plan --scenario {missions / name}.toml")
    assert ended.code == 0, ended.out


def test_a_goal_inside_a_building_is_refused_and_nothing_is_written(run: Run, missions: Path) -> None:
    text = (missions / "sitl.toml").read_text(encoding="utf-8")
    Path("inside.toml").write_text(text.replace("east = 120.0\nnorth = 90.0", "east = 45.0\nnorth = 30.0"))
    ended = run("plan inside.toml --out out")
    assert ended.code == 1
    assert "mast" in ended.err
    assert not Path("out").exists()


def test_a_scenario_that_is_wrong_is_told_by_place(run: Run, missions: Path) -> None:
    text = (missions / "sitl.toml").read_text(encoding="utf-8")
    Path("wrong.toml").write_text(text.replace("radius = 6.0", "radius = -6.0"))
    ended = run("fly wrong.toml")
    assert ended.code == 2
    assert "wrong.toml: obstacles[0].radius: expected a number greater than 0, not -6.0" in ended.err
    assert "Traceback" not in ended.err


def test_an_unknown_optimizer_is_bad_input(run: Run, missions: Path) -> None:
    ended = run(f"plan {missions / 'sitl.toml'} --optimizer ipao")
    assert ended.code == 2
    assert "expected ipoa, poa, dbo, hho, mpoa or ssa, not 'ipao' hint: did you mean ipoa?" in " ".join(
        ended.err.split()
    )


def _essence(item: Item) -> tuple[float, ...]:
    return (item.command, item.frame, item.latitude_deg, item.longitude_deg, item.altitude, *item.params[:3])


def test_compare_holds_the_log_of_a_flight_against_the_estimate(run: Run, planned: Planned) -> None:
    mission = planned("sitl")[1] / "sitl.plan"
    flown = json.loads(run(f"fly {mission} --out out --json").out)
    comparison = json.loads(run(f"compare {mission} out/sitl.tlog --json").out)
    assert comparison["flown_s"] == pytest.approx(flown["flown_s"], abs=0.5)
    assert len(comparison["legs"]) >= 4


def test_the_output_names_the_wind_that_is_given(run: Run) -> None:
    sitl = Path(__file__).parents[2] / "missions" / "sitl.toml"
    plain, windy = run(f"plan {sitl}").out, run(f"plan {sitl} --wind 6@270 --out windy").out
    assert "wind" not in plain
    assert "wind 6 m/s from 270 deg" in windy
    assert json.loads(Path("windy/sitl.json").read_text())["wind"] == {
        "from_deg": 270.0,
        "speed_m_s": 6.0,
        "spread_m_s": 0.0,
    }
    assert "wind 6 m/s from 270 deg" in run(f"check windy/sitl.plan --scenario {sitl} --wind 6@270").out
