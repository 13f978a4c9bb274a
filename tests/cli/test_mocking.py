from pathlib import Path

import pytest

from ipoa_mission import Autopilot, Geodetic, read_mission, read_scenario
from ipoa_mission.cli.mocking import ZURICH, MockOptions, built_in_autopilot
from ipoa_mission.ground import FLAT_GROUND
from ipoa_mission.mission.landing_ground import landing_height
from tests.refused import refuses

MISSIONS = Path(__file__).parents[2] / "missions"


def test_a_mock_stands_where_the_scenario_takes_off_over_its_ground(tmp_path: Path) -> None:
    text = (MISSIONS / "campus.toml").read_text(encoding="utf-8") + "\n[wind]\nspeed = 3.0\nfrom_deg = 270.0\n"
    (tmp_path / "campus.toml").write_text(text)
    here = built_in_autopilot(MockOptions(scenario=tmp_path / "campus.toml"), {"LAND_SPEED": 40.0})
    world = read_scenario(MISSIONS / "campus.toml")
    assert here.flight.autopilot is Autopilot.ARDUPILOT
    assert here.flight.home == world.home.geodetic()
    wind, ground = here.flight.conditions.wind, here.flight.conditions.ground
    assert (wind.speed, wind.from_deg) == (3.0, 270.0)
    assert here.table.values.items() >= {**world.vehicle.parameters, "LAND_SPEED": 40.0}.items()
    east, north, _ = world.goal_point
    assert ground.at(east, north) == pytest.approx(landing_height(read_mission(MISSIONS / "campus.plan")), abs=0.2)


def test_another_autopilot_there_has_none_of_the_parameters() -> None:
    here = built_in_autopilot(MockOptions(Autopilot.PX4, MISSIONS / "campus.toml"), {})
    assert here.flight.autopilot is Autopilot.PX4
    assert here.table.values == built_in_autopilot(MockOptions(Autopilot.PX4), {}).table.values


def test_mock_without_a_scenario_is_in_zurich_on_level_ground() -> None:
    here = built_in_autopilot(MockOptions(), {}).flight
    assert (here.autopilot, here.home, here.conditions.ground) == (Autopilot.PX4, Geodetic(*ZURICH), FLAT_GROUND)
    assert built_in_autopilot(MockOptions(home=(1.0, 2.0, 3.0)), {}).flight.home == Geodetic(1.0, 2.0, 3.0)


def test_contradictory_options_are_bad_input() -> None:
    with refuses("option-conflict", "--home"):
        built_in_autopilot(MockOptions(scenario=MISSIONS / "campus.toml", home=(1.0, 2.0, 3.0)), {})
    with refuses("bad-input", "--home"):
        built_in_autopilot(MockOptions(home=(95.0, 2.0, 3.0)), {})
