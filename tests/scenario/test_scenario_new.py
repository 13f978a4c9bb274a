from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.errors import BadInput
from ipoa_mission.scenario import parse_scenario
from ipoa_mission.scenario.new import QUESTIONS, new_scenario, suggest_answers
from ipoa_mission.scenario.profiles import PROFILES
from tests.refused import refuses

TARGET = Path("trip.toml")
ENDS = {"home": "47.0, 8.0", "goal": "47.002, 8.003"}


def test_home_and_goal_are_answers_enough() -> None:
    scenario = parse_scenario(new_scenario(ENDS, TARGET), TARGET)
    assert scenario.name == "trip"
    assert (scenario.home.latitude_deg, scenario.home.longitude_deg) == (47.0, 8.0)
    assert scenario.start_point == pytest.approx([0, 0, 20])
    # A degree at 47 N: 111,174 m of latitude, 76,058 m of longitude.
    assert scenario.goal_point == pytest.approx([228.2, 222.3, 20], abs=0.3)


@given(
    st.floats(-85, 85),
    st.floats(-179, 179),
    st.sampled_from(["px4", "ardupilot"]),
    st.sampled_from([*PROFILES, "none"]),
    st.sampled_from(["rtl", "land"]),
    st.integers(1, 30),
)
def test_every_answer_is_heeded(
    latitude: float, longitude: float, autopilot: str, profile: str, ending: str, speed: int
) -> None:
    answers = {
        "home": f"{latitude:.7f}, {longitude:.7f}",
        "goal": f"{latitude + 0.001:.7f} {longitude:.7f}",
        "altitude": "-3.5",
        "height": "33",
        "autopilot": autopilot,
        "cruise_speed": str(speed),
        "safety_distance": "4.5",
        "ending": ending,
        "profile": profile,
    }
    assert answers.keys() == {question.key for question in QUESTIONS}
    scenario = parse_scenario(new_scenario(answers, TARGET), TARGET)
    assert scenario.home.latitude_deg == pytest.approx(latitude, abs=1e-7)
    assert scenario.home.longitude_deg == pytest.approx(longitude, abs=1e-7)
    assert scenario.home.altitude_amsl == -3.5
    assert scenario.vehicle.autopilot.name == autopilot
    assert scenario.vehicle.cruise_speed == speed
    assert scenario.profile == (None if profile == "none" else profile)
    assert scenario.route.ending == ending
    assert scenario.safety_distance == 4.5
    assert scenario.goal.height_above_ground == 33


def test_what_is_commented_out_can_be_read_too() -> None:
    lines = new_scenario(ENDS, TARGET).splitlines()
    kept = [line.removeprefix("# ") if i > 1 else line for i, line in enumerate(lines)]
    text = "\n".join(kept).replace('kind = "buildings"', 'kind = "buildings" # ').replace("[[maps]]", "[[unread]]")
    without_maps = text[: text.index("[[unread]]")] + text[text.index("[[obstacles]]") :]
    scenario = parse_scenario(without_maps, TARGET)
    assert scenario.vehicle.battery is not None
    assert scenario.profile == "rescue"
    assert len(scenario.airspace.obstacles) == 1


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        ({"home": "here"}, "home: expected latitude, longitude in degrees, such as 47.3977, 8.5456, not 'here'"),
        ({"home": "91, 8"}, "home: expected latitude, longitude in degrees, such as 47.3977, 8.5456, not '91, 8'"),
        ({"goal": "47"}, "goal: expected latitude, longitude in degrees, such as 47.3977, 8.5456, not '47'"),
        ({"height": "0"}, "height: expected a number greater than 0, not 0"),
        ({"altitude": "1e3"}, "altitude: expected a number, not '1e3'"),
        (
            {"cruise_speed": "800"},
            "cruise_speed: expected at most 40 m/s, unless MPC_XY_VEL_MAX allows more, not 800: is it in cm/s? 8 m/s",
        ),
        ({"autopilot": "inav"}, "autopilot: expected px4, ardupilot, not 'inav'"),
        ({"speed": "3"}, "speed: expected one of " + ", ".join(question.key for question in QUESTIONS)),
    ],
)
def test_answers_that_will_not_do_are_refused(answers: dict[str, str], words: str) -> None:
    with pytest.raises(BadInput) as told:
        new_scenario(ENDS | answers, TARGET)
    assert str(told.value) == words


@pytest.mark.parametrize("profile", PROFILES)
def test_a_profiles_safety_distance_holds_unless_another_was_answered(profile: str) -> None:
    def distance(answers: dict[str, str]) -> float:
        text = new_scenario(ENDS | {"profile": profile} | answers, TARGET)
        return parse_scenario(text, TARGET).safety_distance

    assert distance({}) == PROFILES[profile].get("safety_distance", 2.0)
    assert distance({"safety_distance": "6"}) == 6.0


def test_comments_stand_in_one_column() -> None:
    lines = [line for line in new_scenario(ENDS, TARGET).splitlines() if "  # " in line]
    assert {line.index(" # ") for line in lines} == {32}


def test_a_question_without_default_must_be_answered() -> None:
    with refuses("missing", "goal", kind=BadInput):
        new_scenario({"home": "47, 8"}, TARGET)


def test_maps_answer_for_themselves(missions: Path, tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    buildings, elevation = missions / "oldtown.geojson", missions / "oldtown.tif"
    answers = suggest_answers(buildings)
    target = tmp_path / "town.toml"
    text = new_scenario(answers, target, buildings, elevation)
    scenario = parse_scenario(text, target)
    airspace = scenario.airspace
    assert len(airspace.obstacles) > 60
    for end in (scenario.start_point, scenario.goal_point):
        assert airspace.obstacle_distance(np.array([[*end[:2], airspace.ground(end[None, :2])[0] + 1]]))[0] > 11
    assert np.linalg.norm(scenario.goal_point - scenario.start_point) > 200
    assert airspace.ground(np.zeros((1, 2)))[0] == pytest.approx(0, abs=1.0)


def test_an_elevation_model_answers_for_the_altitude(missions: Path, tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    answers = {"home": "46.44, 9.84", "goal": "46.4415, 9.842"}
    text = new_scenario(answers, tmp_path / "valley.toml", elevation=missions / "oldtown.tif")
    assert parse_scenario(text, tmp_path / "valley.toml").home.altitude_amsl == pytest.approx(1719.6, abs=0.11)
    with refuses("home-not-on-ground", "valley.toml: home.altitude_amsl", "1719.6", kind=BadInput):
        new_scenario(answers | {"altitude": "7"}, tmp_path / "valley.toml", elevation=missions / "oldtown.tif")


def test_a_map_without_features_suggests_nothing(tmp_path: Path) -> None:
    path = tmp_path / "empty.geojson"
    path.write_text('{"type": "FeatureCollection", "features": []}')
    with refuses("nothing-there", "empty.geojson"):
        suggest_answers(path)
