import json
from functools import cache
from pathlib import Path

import pytest

from ipoa_mission import plan_flight
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import write_mission
from ipoa_mission.scenario import parse_scenario
from tests.cli.conftest import Run, Serve

SCENARIO = """home = { latitude_deg = 47.0, longitude_deg = 8.0, altitude_amsl = 500.0 }
start = { east = 0, north = 0, up = 20 }
goal = { east = 60, north = 0, up = 20 }
[[maps]]
kind = "no_fly"
file = "zones.geojson"
"""
ERROR = 'error: zones.geojson: not read: without a geometry: features[0] ("R1") [not-read]'
IGNORE = 'if it limits no flight: --ignore not-read, or [safety] ignore = ["not-read"]'
VERBS = ("plan one.toml", *(f"{verb} kept.plan --scenario one.toml" for verb in ("check", "show", "estimate")))


@pytest.fixture
def folder(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario with a zone without a geometry, and a mission."""
    monkeypatch.chdir(tmp_path)
    corners = [[8.02, 47.0], [8.03, 47.0], [8.03, 47.01], [8.02, 47.0]]
    far = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [corners]}}
    nowhere = {"type": "Feature", "properties": {"name": "R1"}, "geometry": None}
    Path("zones.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [nowhere, far]}))
    Path("one.toml").write_text(SCENARIO)
    write_mission(planned(), Path("kept.plan"))
    return tmp_path


@cache
def planned() -> Mission:
    text, _, _ = SCENARIO.partition("[[maps]]")
    return plan_flight(parse_scenario(text, Path("one.toml"))).mission


@pytest.mark.parametrize("words", [*VERBS, "fly one.toml"])
def test_every_verb_refuses_what_may_limit_the_flight(run: Run, folder: Path, words: str) -> None:
    for form in ("", " --json"):
        ended = run(words + form)
        assert ended.code == 1
        assert "not-read" in ended.out + ended.err
        assert IGNORE in ended.out.replace("\\", "") + ended.err
    assert not (folder / "one.plan").exists()
    assert "R1" in ended.out + ended.err


@pytest.mark.parametrize("words", VERBS)
def test_ignore_names_it_and_it_is_listed_all_the_same(run: Run, folder: Path, words: str) -> None:
    ended = run(
        f"{words} --ignore not-read --json --force" if words.startswith("plan") else f"{words} --ignore not-read --json"
    )
    assert ended.code == 0
    result = json.loads(ended.out)
    assert [(thing["file"], thing["example"], thing["may_limit"]) for thing in result["unread"]] == [
        ("zones.geojson", "R1", True)
    ]
    assert any("without a geometry" in remark for remark in result["remarks"])


def test_ignore_refuses_a_code_of_a_crash_and_one_that_is_none(run: Run, folder: Path) -> None:
    for code, words in (("home-place", "a crash may follow"), ("not-red", "did you mean not-read?")):
        for verb in VERBS:
            ended = run(f"{verb} --ignore {code}")
            assert ended.code == 2
            assert words in ended.err


def test_a_key_of_a_plan_that_is_ignored_is_uploaded_and_flown(run: Run, autopilot: Serve, tmp_path: Path) -> None:
    """A fence spelled otherwise may limit the flight; who flies it all the same names the code."""
    plan = json.loads((Path(__file__).parents[2] / "missions/sitl.plan").read_text(encoding="utf-8"))
    plan["geofence"] = plan.pop("geoFence")
    Path("odd.plan").write_text(json.dumps(plan), encoding="utf-8")
    with autopilot() as link:
        refused = run(f"upload odd.plan --link {link}")
        assert (refused.code, "[not-read]" in refused.err) == (1, True)
        assert run(f"upload odd.plan --link {link} --ignore not-red").code == 2
        sent = json.loads(run(f"upload odd.plan --link {link} --ignore not-read --json").out)
        assert any("geofence" in remark for remark in sent["remarks"])
    assert run("fly odd.plan").code == 1
    assert any(
        "geofence" in remark for remark in json.loads(run("fly odd.plan --ignore not-read --json").out)["remarks"]
    )
