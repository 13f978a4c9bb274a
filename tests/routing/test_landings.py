from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import check_mission, plan_flight
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.flight.flight import Flight
from ipoa_mission.forecast.contingency.contingencies import Contingencies
from ipoa_mission.scenario import Scenario, parse_scenario
from tests.examples import some, vehicles
from tests.quick_search import search_quickly
from tests.refused import refuses

LANDS = {"px4": "COM_LOW_BAT_ACT = 3", "ardupilot": "BATT_FS_CRT_ACT = 1, BATT_CRT_VOLT = 10.2"}
RETURNS = {"px4": "COM_LOW_BAT_ACT = 1", "ardupilot": "BATT_FS_CRT_ACT = 2, BATT_CRT_VOLT = 10.2"}


@pytest.fixture(autouse=True)
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    search_quickly(monkeypatch.setattr)


def over_a_roof(autopilot: Autopilot, parameters: str, wide: float = 40.0, returns: str = "planned") -> Scenario:
    """A low roof, `wide` [m], across the straight way."""
    text = f"""
    safety_distance = 2.0
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 15.0 }}
    goal = {{ east = 95.0, north = 0.0, up = 15.0 }}
    bounds = {{ east = [-50.0, 150.0], north = [-80.0, 80.0], up = [-5.0, 60.0] }}
    vehicle = {{ radius = 0.5, autopilot = "{autopilot}", parameters = {{ {parameters} }} }}
    route = {{ ending = "land" }}
    safety = {{ returns = "{returns}" }}
    [[obstacles]]
    kind = "box"
    name = "roof"
    east = 50.0
    north = 0.0
    width = 30.0
    depth = {wide}
    height = 8.0
    """
    return parse_scenario(text, Path("roof.toml"))


def least_of_landings(flight: Flight) -> float:
    """Return the least clearance of landings from many seconds, every few centimeters."""
    paths = Contingencies(flight.forecast).paths
    samples = paths.at(Contingency.LAND, np.linspace(*paths.in_air, 60))
    legs = [np.linspace(a, b, 200) for path in samples.paths[:, 0] for a, b in pairwise(path)]
    return float(flight.scenario.airspace.obstacle_distance(np.vstack(legs)).min())


def codes(flight: Flight, scenario: Scenario) -> list[str]:
    return [finding.code for finding in check_mission(flight.mission, scenario)]


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_vehicle_that_lands_by_choice_flies_round_obstacles_below(autopilot: Autopilot) -> None:
    asked = over_a_roof(autopilot, LANDS[str(autopilot)])
    landing, returning = (plan_flight(w, seed=0) for w in (asked, over_a_roof(autopilot, RETURNS[str(autopilot)])))
    assert least_of_landings(landing) >= asked.limits.obstacle_distance > least_of_landings(returning)
    assert "land-too-near" not in codes(landing, asked)
    assert not any("LAND in place may" in remark for remark in landing.remarks)
    assert any("LAND in place may" in remark for remark in returning.remarks)


@pytest.mark.parametrize(
    ("autopilot", "says"), some(1, [("px4", "COM_LOW_BAT_ACT = 1"), ("ardupilot", "BATT_FS_CRT_ACT = 2")])
)
def test_a_refusal_without_a_detour_names_the_failsafe_and_its_alternative(autopilot: str, says: str) -> None:
    kind = next(family for family in registered() if str(family) == autopilot)
    with refuses("no-path", "", "LAND", "battery", "roof") as refused:
        plan_flight(over_a_roof(kind, LANDS[autopilot], wide=160.0), seed=0)
    assert f"or set {says} in the vehicle" in str(refused.value.hint)
    assert plan_flight(over_a_roof(kind, RETURNS[autopilot], wide=160.0), seed=0).proof.is_proved


def test_a_warning_names_the_failsafe_and_the_value_that_returns_instead() -> None:
    asked = over_a_roof(Autopilot.ARDUPILOT, LANDS["ardupilot"], returns="warn")
    flight = plan_flight(asked, seed=0)
    findings = [finding for finding in check_mission(flight.mission, asked) if finding.code == "land-too-near"]
    assert len(findings) == 1
    assert "by critical battery (BATT_FS_CRT_ACT = 1), would descend" in findings[0].message
    assert str(findings[0].hint).startswith("set BATT_FS_CRT_ACT = 2 in the vehicle")


def test_landing_for_lack_of_a_return_is_no_choice() -> None:
    """By its defaults ArduCopter lands only where its position is lost."""
    asked = over_a_roof(Autopilot.ARDUPILOT, "", returns="warn")
    assert "land-too-near" not in codes(plan_flight(asked, seed=0), asked)
