from pathlib import Path

import numpy as np
import pytest
from shapely import LineString, box

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.checks.check import check_mission
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.forecast.itinerary.flown_legs import flown_legs
from ipoa_mission.mission.items import Mission
from ipoa_mission.routing.build import build_mission
from ipoa_mission.routing.repairs import raise_way_home_remarks
from ipoa_mission.routing.resample import NoRoute, Route
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.simulator.fly import fly_built_in
from tests.refused import refuses

ROUND_THE_HALL = ((0.0, 0.0, 20.0), (0.0, -40.0, 20.0), (100.0, -40.0, 20.0), (100.0, 0.0, 20.0))
HALL = box(40, -10, 60, 10)


def world(autopilot: Autopilot, height: float, highest: float = 120.0, ending: str = "rtl") -> Scenario:
    text = f"""
    safety_distance = 2.0
    home = {{ latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }}
    start = {{ east = 0.0, north = 0.0, up = 20.0 }}
    goal = {{ east = 100.0, north = 0.0, up = 20.0 }}
    bounds = {{ east = [-50.0, 150.0], north = [-50.0, 50.0], up = [-5.0, {highest}] }}
    vehicle = {{ radius = 0.5, autopilot = "{autopilot}" }}
    route = {{ ending = "{ending}" }}
    planning = {{ max_climb_angle_deg = 30.0 }}
    [[obstacles]]
    kind = "box"
    name = "hall"
    east = 50.0
    north = 0.0
    width = 20.0
    depth = 20.0
    height = {height}
    """
    return parse_scenario(text, Path("world.toml"))


def mission(scenario: Scenario) -> Mission:
    return build_mission(Route(np.array(ROUND_THE_HALL)), scenario)


def height_over_the_hall(flown: Mission, scenario: Scenario) -> float:
    """Return the height of the way home over the hall, without the package's clearances."""
    ways = [leg for leg in flown_legs(flown, scenario.frame) if leg.stage is FlightStage.RETURN]
    assert all(LineString(way.points[:, :2]).intersects(HALL) for way in ways)
    return float(min(way.points[-1, 2] for way in ways))


def test_a_copter_stops_at_the_end_of_a_curve_before_it_climbs_to_return() -> None:
    """Else the curve would dip before the goal, and rise there."""
    scenario = world(Autopilot.ARDUPILOT, 18.0)
    raised = build_mission(Route(np.array(ROUND_THE_HALL), spline=True, brakes_on_curve=True), scenario)
    assert [(item.command, round(item.altitude)) for item in raised.items[-3:]] == [(82, 20), (16, 25), (20, 0)]
    flight = fly_built_in(raised)
    place = np.array(
        [(sample.time_s, sample.latitude_deg, sample.longitude_deg, sample.height) for sample in flight.path]
    )
    goal = scenario.frame.geodetic(np.array([100.0, 0.0, 20.0]))
    before = place[(place[:, 0] > flight.item_reached_s[1]) & (place[:, 0] < flight.item_reached_s[4])]
    assert np.abs(before[:, 3] - 20.0).max() < 0.2
    beyond = (place[place[:, 0] < flight.item_reached_s[5], 1] - goal.latitude_deg) * 111_200
    assert beyond.max() < 1.0


@pytest.mark.parametrize(
    ("autopilot", "height", "climbs_to"),
    [
        (Autopilot.ARDUPILOT, 12.0, None),  # at 20 m already; RTL_ALT is 15 m
        (Autopilot.ARDUPILOT, 18.0, 25.0),
        (Autopilot.ARDUPILOT, 40.0, 45.0),
        (Autopilot.PX4, 12.0, None),  # RTL_RETURN_ALT is 30 m
        (Autopilot.PX4, 40.0, 50.0),
        (Autopilot.PX4, 58.0, 65.0),
        (Autopilot.PX4, 70.0, 80.0),
    ],
)
def test_climb_over_the_goal_clears_the_way_home(autopilot: Autopilot, height: float, climbs_to: float | None) -> None:
    scenario = world(autopilot, height)
    flown = mission(scenario)
    last, end = flown.items[-2:]
    assert end.command == Command.NAV_RETURN_TO_LAUNCH
    assert last.altitude == pytest.approx(20.0 if climbs_to is None else climbs_to, abs=0.01)
    assert height_over_the_hall(flown, scenario) >= height + 2.5
    findings = check_mission(flown, scenario)  # RTL before the climb may differ
    assert [finding.code for finding in findings] == ["return-too-near"] * (climbs_to is not None)
    assert len(list(raise_way_home_remarks(flown))) == (climbs_to is not None)


def test_climb_stays_in_the_bounds_and_the_check_names_a_remedy() -> None:
    scenario = world(Autopilot.ARDUPILOT, 40.0, highest=42.0)
    flown = mission(scenario)
    assert flown.items[-2].altitude == pytest.approx(20.0, abs=0.01)
    (finding,) = check_mission(flown, scenario)
    assert finding.code == "leg-too-near"
    assert "10.00 m inside hall" in finding.message
    assert finding.hint is not None
    assert finding.hint.startswith("plan the way home too")


def test_a_mission_that_lands_at_its_goal_does_not_climb() -> None:
    flown = mission(world(Autopilot.ARDUPILOT, 40.0, ending="land"))
    assert flown.items[-1].command == Command.NAV_LAND
    assert flown.items[-2].altitude == pytest.approx(20.0, abs=0.01)


def test_goal_above_its_via_point_is_no_climb_for_the_way_home() -> None:
    text = """
    home = { latitude_deg = 47.4, longitude_deg = 8.5, altitude_amsl = 400.0 }
    start = { east = 0.0, north = 0.0, up = 10.0 }
    via = [{ east = 60.0, north = 0.0, up = 10.0 }]
    goal = { east = 60.0, north = 0.0, up = 25.0 }
    vehicle = { autopilot = "px4" }
    """
    flight = plan_flight(parse_scenario(text, Path("above.toml")))
    before, last, _ = flight.mission.items[-3:]
    assert (before.latitude_deg, before.longitude_deg) == (last.latitude_deg, last.longitude_deg)
    assert before.altitude < last.altitude
    assert not [remark for remark in flight.remarks if "climbs to" in remark]


def test_a_start_behind_something_is_refused_with_what_helps() -> None:
    scenario = world(Autopilot.PX4, 40.0)
    with refuses("start-not-reached", "start", "10.00", kind=NoRoute) as refused:
        build_mission(Route(np.array([(70.0, 0.0, 20.0), (100.0, 0.0, 20.0)])), scenario)
    assert refused.value.hint is not None
    assert "via" in refused.value.hint
