from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.checks.check import check_mission
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission, land, return_to_launch, takeoff
from ipoa_mission.report.table import mission_table
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.simulator.fly import board, conditions_for, fly_aboard
from tests.examples import vehicles
from tests.px4_waypoints import waypoint

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT


def slope(height: float, autopilot: Autopilot, at_home: float = 0.0) -> Scenario:
    """Level round home, `height` above it round the goal, 200 m east."""
    row = [at_home, at_home, at_home, height, height]
    return parse_scenario(
        f"""
        home = {{ latitude_deg = 47.0, longitude_deg = 8.0, altitude_amsl = 500.0 }}
        start = {{ east = 0, north = 0, up = 50 }}
        goal = {{ east = 200, north = 0, up = 50 }}
        vehicle.autopilot = "{autopilot}"
        bounds = {{ up = [-80.0, 100.0] }}
        terrain = {{ kind = "grid", east = -100, north = -100, spacing = 90, heights = {[row] * 4} }}
        """,
        Path("slope.toml"),
    )


def warnings_of(
    scenario: Scenario, *, to_goal: bool = True, parameters: dict[str, float] | None = None
) -> list[tuple[str, str | None]]:
    home, goal = scenario.frame.home, scenario.frame.geodetic(np.array([200.0, 0.0, 0.0]))
    end = land(goal) if to_goal else return_to_launch()
    mission = Mission(home, (takeoff(home, 50.0), waypoint(goal, 50.0), end), scenario.vehicle.autopilot)
    findings = check_mission(mission.with_parameters(parameters or {}), scenario)
    assert not any(finding.severity is Severity.ERROR for finding in findings), findings
    return [(finding.message, finding.hint) for finding in findings if "ground" in finding.message]


@pytest.mark.parametrize(
    ("autopilot", "height", "speed", "slow", "remedy"),
    [
        (ARDUPILOT, 12.0, "1.5", "0.5", "LAND_ALT_LOW = 2200"),
        (PX4, 12.0, "1.5", "0.7", "MPC_LAND_ALT1 = 22 and MPC_LAND_ALT2 = 17"),
        (PX4, 7.5, "1.1", "0.7", "MPC_LAND_ALT1 = 18 and MPC_LAND_ALT2 = 13"),  # half way between 5 and 10 m
    ],
)
def test_touchdown_on_higher_ground_has_the_speed_of_the_descent(
    autopilot: Autopilot, height: float, speed: str, slow: str, remedy: str
) -> None:
    ((message, hint),) = warnings_of(slope(height, autopilot))
    assert message == (
        f"item 3 (NAV_LAND): at east 200.0, north 0.0 the ground is {height:.1f} m above home: without a rangefinder "
        f"the vehicle touches down at up to {speed} m/s, not at {slow}"
    )
    assert hint is not None
    assert hint.startswith(remedy)


@pytest.mark.parametrize(("autopilot", "height"), [(ARDUPILOT, 9.0), (PX4, 4.0), (PX4, 0.0), (ARDUPILOT, -4.0)])
def test_landing_that_slows_down_in_time_has_no_finding(autopilot: Autopilot, height: float) -> None:
    assert warnings_of(slope(height, autopilot)) == []


@pytest.mark.parametrize(("autopilot", "words"), [(ARDUPILOT, "50 m are flown at 0.5"), (PX4, "45 m are flown at 0.7")])
def test_landing_on_lower_ground_is_long(autopilot: Autopilot, words: str) -> None:
    ((message, _),) = warnings_of(slope(-40.0, autopilot))
    assert "the ground is 40.0 m below home: without a rangefinder the last " + words in message


def test_the_way_home_ends_on_the_ground_at_home() -> None:
    assert warnings_of(slope(12.0, PX4), to_goal=False) == []


def test_ground_at_home_off_homes_altitude_shifts_the_whole_flight() -> None:
    ((message, hint), *_) = warnings_of(slope(-3.0, PX4, at_home=-3.0))
    assert "3.0 m below home's altitude" in message
    assert "flies 3.0 m lower than planned" in message
    assert hint == "set home.altitude_amsl = 497.0"


@pytest.mark.parametrize("remedy", [{"LAND_ALT_LOW": 2200.0}, {"LAND_ALT_LOW_M": 22.0}])
def test_the_remedy_is_one(remedy: dict[str, float]) -> None:
    assert warnings_of(slope(12.0, ARDUPILOT), parameters=remedy) == []
    assert warnings_of(slope(12.0, PX4), parameters={"MPC_LAND_ALT1": 22.0, "MPC_LAND_ALT2": 17.0}) == []


def test_a_range_finder_slows_arducopter_down_in_time() -> None:
    assert warnings_of(slope(12.0, ARDUPILOT), parameters={"RNGFND1_TYPE": 1.0}) == []
    assert warnings_of(slope(-40.0, ARDUPILOT), parameters={"RNGFND1_TYPE": 1.0}) == []


@pytest.mark.parametrize("autopilot", vehicles(Autopilot.ARDUPILOT))
def test_landings_below_at_and_above_home_take_their_own_times(autopilot: Autopilot) -> None:
    totals = []
    for height in (-40.0, 0.0, 12.0):
        scenario = slope(height, autopilot)
        goal = scenario.frame.geodetic(np.array([200.0, 0.0, 0.0]))
        mission = Mission(
            scenario.frame.home, (takeoff(scenario.frame.home, 50.0), waypoint(goal, 50.0), land(goal)), autopilot
        )
        flown = Forecast(mission, scenario)
        landing = flown.estimate.items[-1].duration_s
        with board(flown.mission, conditions_for(flown.mission, flown.wind, flown.ground)) as vehicle:
            here = fly_aboard(vehicle, flown.mission)
        assert here.item_reached_s[2] - here.item_reached_s[1] == pytest.approx(landing, rel=0.1)
        assert here.path[-1].height == pytest.approx(height, abs=1.0)
        row = mission_table(mission, scenario)[-1]
        assert (row.height, row.height_above_ground) == pytest.approx((height, 0.0), abs=0.05)
        totals.append(flown.estimate.total_s)
    assert totals[0] > totals[1] + 20.0 > totals[2] + 25.0
