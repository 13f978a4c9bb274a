from pathlib import Path

import pytest

from ipoa_mission.checks.check import check
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.scenario import Scenario, parse_scenario, read_scenario
from ipoa_mission.wind import Wind
from tests.refused import refuses

MISSIONS = Path(__file__).parents[2] / "missions"
PLACES = """
home = { latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }
start = { east = 0.0, north = 0.0, up = 15.0 }
goal = { east = 90.0, north = 0.0, up = 15.0 }
"""


def too_strong(wind: Wind) -> bool:
    forecast = Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(MISSIONS / "sitl.toml"), wind)
    findings = [finding for finding in check(forecast) if finding.code == "wind-too-strong"]
    assert all(finding.severity is Severity.ERROR for finding in findings)
    return bool(findings)


def test_a_wind_too_strong_by_itself_or_with_its_spread_is_an_error() -> None:
    assert too_strong(Wind(25.0, 45.0))
    assert not too_strong(Wind(3.0, 45.0))
    assert too_strong(Wind(3.0, 45.0, spread=22.0))
    assert too_strong(Wind.of_profile([30.0, 60.0], [1.0, 25.0], [270.0, 270.0], spread=20.0))


def read(text: str) -> Scenario:
    return parse_scenario(PLACES + text, Path("wind.toml"))


def test_a_profile_is_read_and_stays_itself_in_another_scenario() -> None:
    scenario = read("wind = { heights = [10, 100], speeds = [3, 8], directions = [270, 300], spread = 1.5 }")
    air = scenario.wind.air()
    assert (air.speed_at(10.0), air.speed_at(100.0), air.spread) == pytest.approx((3.0, 8.0, 1.5))
    again = read("").in_wind(air).wind.air()
    assert again.velocity(55.0) == pytest.approx(air.velocity(55.0))
    assert again.strongest == pytest.approx(9.5)


@pytest.mark.parametrize(
    ("wind", "words"),
    [
        ("heights = [10, 100], speeds = [3], directions = [270, 270]", ("bad-input", "wind.toml: wind")),
        ("heights = [10], speeds = [3], directions = [270]", ("bad-input", "wind.toml: wind")),
        ("heights = [100, 10], speeds = [3, 4], directions = [270, 270]", ("bad-input", "wind.toml: wind")),
        ("speed = 4, heights = [10, 100], speeds = [3, 4], directions = [270, 270]", ("bad-input", "wind.toml: wind")),
        ("speeds = [3, 4]", ("bad-input", "wind.toml: wind")),
    ],
)
def test_a_profile_that_makes_no_sense_is_an_error(wind: str, words: tuple[str, ...]) -> None:
    with refuses(*words):
        read(f"wind = {{ {wind} }}")
