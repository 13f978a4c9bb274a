import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.errors import Unsafe
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission, land, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.landing_ground import landing_on
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.routing.repairs import slow_landings
from ipoa_mission.scenario import Scenario
from ipoa_mission.simulator.fly import fly_built_in
from tests.checks.test_ground import ARDUPILOT, PX4, slope
from tests.examples import some
from tests.quick_search import search_quickly
from tests.refused import refuses

HOME = Geodetic(47.0, 8.0, 500.0)
NO_RANGE_FINDER = {"SIH_DISTSNSR_OVR": 20000.0}


@pytest.fixture(autouse=True)
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    search_quickly(monkeypatch.setattr)


def landing_scenario(height: float, autopilot: Autopilot, parameters: Parameters | None = None) -> Scenario:
    """The slope with a landing at its goal, on a vehicle with these parameters."""
    scenario = slope(height, autopilot)
    vehicle = scenario.vehicle.model_copy(update={"parameters": dict(parameters or {})})
    route = scenario.route.model_copy(update={"ending": "land"})
    return scenario.model_copy(update={"vehicle": vehicle, "route": route})


def slowed(height: float, autopilot: Autopilot, parameters: Parameters | None = None) -> dict[str, float]:
    scenario = landing_scenario(height, autopilot, parameters)
    goal = scenario.frame.geodetic(np.array([200.0, 0.0, 0.0]))
    items = (takeoff(scenario.frame.home, 50.0), waypoint(goal, 200.0), land(goal))
    mission = Mission(scenario.frame.home, items, autopilot, parameters=scenario.vehicle.autopilot_parameters())
    return dict(slow_landings(mission, scenario).parameters)


def flight_to_high_ground(autopilot: Autopilot) -> Flight:
    return plan_flight(landing_scenario(12.0, autopilot))


def sink_at_last(mission: Mission) -> float:
    """Return the descent rate of the last two meters, without a range finder [m/s]."""
    if mission.autopilot is PX4:
        mission = mission.with_parameters(NO_RANGE_FINDER)
    path = fly_built_in(mission).path
    above = [(sample.time_s, sample.height - 12.0) for sample in path[len(path) // 2 :]]
    begin = next(time for time, height in above if height < 2.0)
    end = next(time for time, height in above if height < 0.5)
    return 1.5 / (end - begin)


@pytest.mark.parametrize(
    ("autopilot", "wanted", "slow"),
    some(1, [(ARDUPILOT, {"LAND_ALT_LOW": 2200.0}, 0.5), (PX4, {"MPC_LAND_ALT1": 22.0, "MPC_LAND_ALT2": 17.0}, 0.7)]),
)
def test_a_planned_landing_on_high_ground_is_slow(
    autopilot: Autopilot, wanted: dict[str, float], slow: float, tmp_path: Path
) -> None:
    flight = flight_to_high_ground(autopilot)
    assert dict(flight.mission.parameters) == wanted
    (remark,) = [words for words in flight.remarks if "above home" in words]
    assert "at east 200.0, north 0.0 the ground is 12.0 m above home" in remark
    assert all(f"{name} = {value:g}" in remark for name, value in wanted.items())
    flight.write(tmp_path)
    about = json.loads((tmp_path / "slope.json").read_text())
    assert about["parameters"] == wanted
    assert remark in about["remarks"]
    assert dict(read_mission(tmp_path / "slope.plan").parameters) == wanted
    assert sink_at_last(flight.mission) == pytest.approx(slow, rel=0.25)
    without = replace(flight.mission, parameters={})
    assert flight.estimate.total_s > estimate(without).total_s + 5.0
    assert sink_at_last(without) > 2 * slow * 0.75


@pytest.mark.parametrize(
    ("autopilot", "height", "parameters", "wanted"),
    [
        (ARDUPILOT, 7.0, {}, {}),  # a slow stretch of 3 m is left
        (ARDUPILOT, 8.5, {}, {"LAND_ALT_LOW": 1900.0}),  # 1.5 m are too few: heights are off by 2
        (ARDUPILOT, -40.0, {}, {}),
        (ARDUPILOT, 12.0, {"LAND_ALT_LOW": 500.0}, {"LAND_ALT_LOW": 500.0}),  # the scenario's own, told by the check
        (ARDUPILOT, 12.0, {"LAND_ALT_LOW_M": 5.0}, {"LAND_ALT_LOW_M": 5.0}),
        (ARDUPILOT, 12.0, {"RNGFND1_TYPE": 1.0}, {"RNGFND1_TYPE": 1.0}),
        (ARDUPILOT, 12.0, {"WP_SPD_DN": 3.0}, {"WP_SPD_DN": 3.0, "LAND_ALT_LOW": 2200.0}),
        (ARDUPILOT, 95.0, {}, {"LAND_ALT_LOW": 10000.0}),  # as much as its firmware documents
        (PX4, 3.0, {}, {}),
        (PX4, 4.0, {}, {"MPC_LAND_ALT1": 14.0, "MPC_LAND_ALT2": 9.0}),
        (PX4, 12.0, {"MPC_LAND_ALT1": 11.0}, {"MPC_LAND_ALT1": 11.0}),
        (PX4, 114.0, {}, {"MPC_LAND_ALT1": 122.0, "MPC_LAND_ALT2": 119.0}),
    ],
)
def test_parameters_are_raised_where_the_landing_needs_it(
    autopilot: Autopilot, height: float, parameters: dict[str, float], wanted: dict[str, float]
) -> None:
    assert slowed(height, autopilot, parameters) == wanted


@pytest.mark.parametrize(("autopilot", "most"), [(ARDUPILOT, 100), (PX4, 122)])
def test_ground_above_what_the_parameter_reaches_is_refused(autopilot: Autopilot, most: int) -> None:
    with refuses("fast-touchdown", "", "130.0 m", f"{most} m", "1.5", kind=Unsafe) as refused:
        slowed(130.0, autopilot)
    assert "vehicle.descent_speed" in str(refused.value.hint)
    speeds = {ARDUPILOT: {"WPNAV_SPEED_DN": 50.0}, PX4: {"MPC_Z_V_AUTO_DN": 0.7}}[autopilot]
    assert slowed(130.0, autopilot, speeds) == speeds  # as slow all the way down


def test_rally_points_count_too() -> None:
    scenario = slope(12.0, ARDUPILOT)
    goal = scenario.frame.geodetic(np.array([200.0, 0.0, 0.0]))
    items = (takeoff(scenario.frame.home, 50.0), waypoint(goal, 50.0), return_to_launch())
    mission = Mission(scenario.frame.home, items, ARDUPILOT)
    assert dict(slow_landings(mission, scenario).parameters) == {}
    rallied = replace(mission, rally=(Geodetic(goal.latitude_deg, goal.longitude_deg, 30.0),))
    assert dict(slow_landings(rallied, scenario).parameters) == {"LAND_ALT_LOW": 2200.0}


@pytest.mark.parametrize(
    ("parameters", "altitude", "flown_s"), [({}, 0.0, 26.25), ({"LAND_ALT_LOW": 2200.0}, 0.0, 40.6), ({}, 12.0, 40.6)]
)
def test_arducopters_land_counts_from_its_own_altitude(
    parameters: dict[str, float], altitude: float, flown_s: float
) -> None:
    """ArduCopter 4.7.0-dev from 45 m to ground 12 m above home; touched down at 1.50, 0.50, 0.50 m/s."""
    there = LocalFrame(HOME).geodetic(np.array([0.0, 60.0, 0.0]))
    items = (takeoff(HOME, 20.0), waypoint(there, 45.0), replace(land(there), altitude=altitude))
    mission = landing_on(Mission(HOME, items, ARDUPILOT, parameters=parameters), 12.0)
    assert estimate(mission).items[-1].duration_s == pytest.approx(flown_s, rel=0.035)


def test_the_check_counts_from_the_lower_of_home_and_the_landing_item() -> None:
    scenario = slope(12.0, ARDUPILOT)
    goal = scenario.frame.geodetic(np.array([200.0, 0.0, 0.0]))
    for altitude, wanted in ((12.0, 2200.0), (-8.0, 3000.0)):  # before 4.7 the altitude did not count
        items = (takeoff(scenario.frame.home, 50.0), waypoint(goal, 50.0), replace(land(goal), altitude=altitude))
        mission = Mission(scenario.frame.home, items, ARDUPILOT)
        assert slow_landings(mission, scenario).parameters["LAND_ALT_LOW"] == wanted


def test_a_descent_that_is_slower_than_landing_is_no_fast_touchdown() -> None:
    stretch = ARDUPILOT.slow_stretch({"LAND_SPEED_HIGH": 30.0})
    assert stretch is not None
    assert stretch.touchdown(12.0) == 0.5
