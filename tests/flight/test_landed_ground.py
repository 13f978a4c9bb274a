import json
from pathlib import Path

import ipoa_mission as api
from ipoa_mission.flight.post_flight import landed_elsewhere
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import land, takeoff, waypoint
from ipoa_mission.mission.landing_ground import known_ground, landing_height, landing_on
from ipoa_mission.mission.mission_io import LANDING_GROUND_KEY, digest
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.mission.waypoints_file import waypoints_text
from tests.refused import refuses

HOME = Geodetic(47.397742, 8.545594, 488.0)
GOAL = Geodetic(47.398642, 8.545594, 488.0)
MISSION = api.Mission(HOME, (takeoff(HOME, 20.0), waypoint(GOAL, 20.0), land(GOAL)), api.Autopilot.ARDUPILOT)


def test_a_file_is_read_over_the_ground_that_was_written_beside_it(tmp_path: Path) -> None:
    uphill = landing_on(MISSION, 8.5)
    assert landing_height(MISSION) is None
    text, path, about = waypoints_text(uphill), tmp_path / "hill.waypoints", tmp_path / "hill.json"
    path.write_text(text, encoding="utf-8")
    assert landing_height(api.read_mission(path, MISSION.autopilot)) is None
    about.write_text(json.dumps({LANDING_GROUND_KEY: 8.5, "sha256": {path.name: digest(text)}}), encoding="utf-8")
    again = api.read_mission(path, MISSION.autopilot)
    assert landing_height(again) == 8.5
    assert known_ground(again).at(0.0, 0.0) == 0.0
    assert api.estimate(again).total_s == api.estimate(uphill).total_s < api.estimate(MISSION).total_s - 3.0
    about.write_text("[" * 100_000, encoding="utf-8")
    assert landing_height(api.read_mission(path, MISSION.autopilot)) is None
    path.write_text(text + "\n", encoding="utf-8")  # changed by somebody
    assert landing_height(api.read_mission(path, MISSION.autopilot)) is None


def test_a_plan_takes_the_ground_along_wherever_it_is_copied(tmp_path: Path) -> None:
    uphill, path = landing_on(MISSION, 12.0), tmp_path / "elsewhere.plan"
    path.write_text(plan_text(uphill), encoding="utf-8")
    again = api.read_mission(path)
    assert landing_height(again) == 12.0
    assert plan_text(again) == plan_text(uphill)
    assert "landingGround" not in json.loads(plan_text(MISSION))
    (fast,) = api.check_mission(again)  # its NAME.params may have stayed where it was
    assert (fast.code, fast.seq) == ("fast-touchdown", 3)
    assert api.check_mission(again.with_parameters({"LAND_ALT_LOW": 2200.0})) == ()
    document = json.loads(path.read_text(encoding="utf-8"))
    document["mission"]["items"][-1]["params"][4] += 0.0001  # moved: its ground is unknown
    path.write_text(json.dumps(document), encoding="utf-8")
    assert landing_height(api.read_mission(path)) is None


def test_a_plan_whose_ground_is_no_number_says_where(tmp_path: Path) -> None:
    path = tmp_path / "odd.plan"
    document = json.loads(plan_text(landing_on(MISSION, 8.5)))
    document["landingGround"]["aboveHome"] = "high"
    path.write_text(json.dumps(document), encoding="utf-8")
    with refuses("bad-input", "odd.plan: landingGround.aboveHome"):
        api.read_mission(path)


def test_a_flight_over_level_ground_says_what_was_to_be_expected_there() -> None:
    level = api.fly_built_in(MISSION)
    uphill = landing_on(MISSION, 8.5)
    assert landed_elsewhere(api.Forecast(uphill), api.fly_built_in(uphill)) == ()
    (words,) = landed_elsewhere(api.Forecast(uphill), level)
    assert words.startswith("it landed 0.0 m above home, but the ground there is 8.5 m higher; ")
    assert f"{api.estimate(MISSION).total_s:.1f} s" in words
