from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.checks.check import check_mission
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, land, takeoff
from ipoa_mission.report.exports import forecast_text
from ipoa_mission.report.table import mission_table
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.scenario_file import parse_scenario
from tests.finding_codes import codes_of
from tests.px4_waypoints import waypoint
from tests.refused import refuses

HERE, THERE = Geodetic(47.4, 8.5, 400.0), Geodetic(46.923284, 80.512554, 1155.6)
NEAR = Geodetic(47.4009, 8.5, 400.0)
MISSION = Mission(HERE, (takeoff(HERE, 20.0), waypoint(NEAR, 20.0), land(NEAR)))
DOORS: list[Callable[[Mission, Scenario], Any]] = [
    mission_table,
    lambda mission, world: Forecast(mission, world).mission,
    lambda mission, world: forecast_text(Forecast(mission, world), ".kml", "m"),
    lambda mission, world: forecast_text(Forecast(mission, world), ".csv", "m"),
]


def world(place: Geodetic, more: str = "") -> Scenario:
    text = f"""
    home = {{ latitude_deg = {place.latitude_deg}, longitude_deg = {place.longitude_deg}, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 20.0 }}
    goal = {{ east = 0.0, north = 100.0, up = 20.0 }}
    {more}
    """
    return parse_scenario(text, Path("w.toml"))


@pytest.mark.parametrize("door", DOORS)
def test_no_door_takes_the_scenario_of_another_place(door: Callable[[Mission, Scenario], Any]) -> None:
    assert door(MISSION, world(HERE))
    with refuses("too-far", "home"):
        door(MISSION, world(THERE))


def test_check_says_it_once_and_what_else_is_wrong_with_the_mission() -> None:
    wrong = replace(MISSION, items=(*MISSION.items[:2], Item(4711, 3), MISSION.items[2]))
    errors = [code for code in codes_of(check_mission(wrong, world(THERE))) if code.startswith("error")]
    assert errors == ["error another-place 0", "error command-not-taken 3"]


def test_one_check_says_all_though_a_position_or_a_command_is_wrong() -> None:
    walls = "obstacles = [{ kind = 'box', east = 0.0, north = 50.0, width = 9.0, depth = 3.0, height = 90.0 }]"
    away = replace(takeoff(HERE, 20.0), latitude_deg=0.0, longitude_deg=0.0)  # PX4 would fly to 0, 0
    back = replace(waypoint(HERE, 20.0), command=82)  # a spline waypoint, which PX4 does not take
    mission = replace(MISSION, items=(away, waypoint(NEAR, 20.0), back))
    assert set(codes_of(check_mission(mission, world(HERE, walls)))) >= {
        "error position-missing 1",
        "error leg-too-near 2",
        "error command-not-taken 3",
        "error leg-too-near 3",
    }


def test_legs_to_and_from_a_place_that_makes_no_sense_are_not_judged() -> None:
    walls = "obstacles = [{ kind = 'box', east = 0.0, north = 50.0, width = 9.0, depth = 3.0, height = 90.0 }]"
    mad = replace(waypoint(NEAR, 20.0), latitude_deg=95.0)
    items = (takeoff(HERE, 20.0), mad, waypoint(NEAR, 20.0), waypoint(HERE, 20.0), land(HERE))
    findings = check_mission(replace(MISSION, items=items), world(HERE, walls))
    assert [f.seq for f in findings if f.severity is Severity.ERROR] == [2, 4]


def test_a_rover_s_mission_is_called_one_and_is_asked_for_no_take_off() -> None:
    findings = check_mission(replace(MISSION, items=MISSION.items[1:2], vehicle_type=10))
    assert codes_of(findings) == ["error no-aircraft", "warning ends-in-the-air 1"]
    assert "for a rover, " in findings[0].message
