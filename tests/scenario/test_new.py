"""A first scenario can be read, and has the given home and maps."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.errors import BadInput
from ipoa_mission.scenario import parse_scenario
from ipoa_mission.scenario.scenario_file import new_scenario
from tests.refused import refuses

TARGET = Path("trip.toml")
HOME = (47.0, 8.0, 488.0)


@given(st.floats(-85, 85), st.floats(-179, 179), st.floats(-400, 4000))
def test_home_is_the_given_one(latitude: float, longitude: float, altitude: float) -> None:
    text, remarks = new_scenario(TARGET, (latitude, longitude, altitude))
    scenario = parse_scenario(text, TARGET)
    home = scenario.home
    assert (home.latitude_deg, home.longitude_deg, home.altitude_amsl) == (latitude, longitude, altitude)
    assert scenario.start_point == pytest.approx([0, 0, 20])
    assert scenario.goal_point == pytest.approx([0, 100, 20], abs=1.0)
    assert scenario.safety.returns == "planned"
    assert remarks == ("the goal is 100 m north of home: correct it",)


def test_commented_keys_can_be_read_too() -> None:
    lines = new_scenario(TARGET, HOME).text.splitlines()
    kept = [line.removeprefix("# ") if i > 1 else line for i, line in enumerate(lines)]
    text = "\n".join(kept).replace('kind = "buildings"', 'kind = "buildings" # ').replace("[[maps]]", "[[unread]]")
    without_maps = text[: text.index("[[unread]]")] + text[text.index("[[obstacles]]") :]
    scenario = parse_scenario(without_maps, TARGET)
    assert scenario.vehicle.battery is not None
    assert scenario.profile == "rescue"
    assert len(scenario.airspace.obstacles) == 1


def test_comments_are_in_one_column() -> None:
    lines = [line for line in new_scenario(TARGET, HOME).text.splitlines() if " # " in line.removeprefix("# ")]
    assert {line.index(" # ") for line in lines} == {32}


def test_home_is_required_without_a_map() -> None:
    with refuses("missing", "trip.toml", "--home LAT LON ALT", kind=BadInput):
        new_scenario(TARGET)


@pytest.mark.parametrize("home", [(91.0, 8.0, 0.0), (47.0, 181.0, 0.0), (47.0, 8.0, float("nan"))])
def test_a_home_off_the_earth_is_refused(home: tuple[float, float, float]) -> None:
    with pytest.raises(BadInput) as refused:
        new_scenario(TARGET, home)
    assert "trip.toml: home." in str(refused.value)


def test_a_map_suggests_home_and_goal(missions: Path, tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    target = tmp_path / "town.toml"
    text, remarks = new_scenario(target, None, missions / "oldtown.geojson", missions / "oldtown.tif")
    scenario = parse_scenario(text, target)
    airspace = scenario.airspace
    assert len(airspace.obstacles) > 60
    for end in (scenario.start_point, scenario.goal_point):
        assert airspace.obstacle_distance(np.array([[*end[:2], airspace.ground(end[None, :2])[0] + 1]]))[0] > 11
    assert np.linalg.norm(scenario.goal_point - scenario.start_point) > 200
    assert airspace.ground(np.zeros((1, 2)))[0] == pytest.approx(0, abs=1.0)
    assert remarks == ()


def test_every_height_of_the_template_is_a_key_of_maps(missions: Path, tmp_path: Path) -> None:
    target = tmp_path / "town.toml"
    text, remarks = new_scenario(target, None, missions / "oldtown.geojson")
    (altitude,) = remarks
    assert altitude.startswith("home.altitude_amsl is 0 m: correct it")
    for key in ("default", "line", "aerialway", "point"):
        assert f"\n# {key}_height" in text
        text = text.replace(f"\n# {key}_height", f"\n{key}_height")
    assert parse_scenario(text, target).maps[0].wood_height == 35.0  # type: ignore[union-attr]


def test_home_in_the_north_has_its_goal_in_the_south(missions: Path, tmp_path: Path) -> None:
    text, _ = new_scenario(tmp_path / "a.toml", (46.4432, 9.8441, 1720.0), missions / "oldtown.geojson")
    assert parse_scenario(text, tmp_path / "a.toml").goal_point[1] < -200


def test_an_altitude_that_is_not_the_models_is_refused(missions: Path, tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    target, model = tmp_path / "valley.toml", missions / "oldtown.tif"
    home = parse_scenario(new_scenario(target, (46.44, 9.84, 1719.6), elevation=model).text, target).home
    assert home.altitude_amsl == 1719.6
    with refuses("home-not-on-ground", "valley.toml: home.altitude_amsl", "1719.6", kind=BadInput):
        new_scenario(target, (46.44, 9.84, 7.0), elevation=model)


def test_a_map_without_features_suggests_nothing(tmp_path: Path) -> None:
    path = tmp_path / "empty.geojson"
    path.write_text('{"type": "FeatureCollection", "features": []}')
    with refuses("nothing-there", "empty.geojson"):
        new_scenario(TARGET, None, path)
