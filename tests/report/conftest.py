from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.mission.items import Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.planning.planner import Plan
from ipoa_mission.planning.problem import curve_cost
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.planning.spline import Spline
from ipoa_mission.report.drawn_flight import item_legs
from ipoa_mission.scenario import Scenario, parse_scenario
from tools import REPOSITORY

Flight = tuple[Scenario, Mission, Estimate]
Bowed = Callable[[str], Flight]
Foreseen = Callable[[str], Forecast]
Planned = Callable[[str], tuple[Forecast, Plan]]


@pytest.fixture(scope="session")
def bowed(forecast: Foreseen) -> Bowed:
    def flight(name: str) -> Flight:
        predicted = forecast(name)
        assert predicted.scenario is not None
        return predicted.scenario, predicted.mission_as_read, predicted.estimate

    return flight


@pytest.fixture(scope="session")
def forecast() -> Foreseen:
    """Nine waypoints on an arc from start to goal, west of the straight line, over the campus's roofs."""

    @cache
    def fly(name: str) -> Forecast:
        text = (REPOSITORY / "missions" / name).read_text(encoding="utf-8")
        bounds = ("up = [-10.0, 32.0]", "up = [-10.0, 45.0]")
        scenario = parse_scenario(text.replace(*bounds), REPOSITORY / "missions" / name)
        frame, home = scenario.frame, scenario.frame.home
        a, b = scenario.start_point, scenario.goal_point
        share = np.linspace(0, 1, 9)[:, None]
        aside = 0.3 * np.array([a[1] - b[1], b[0] - a[0], 46.0])
        places = [frame.geodetic(point) for point in a + share * (b - a) + np.sin(np.pi * share) * aside]
        heights = [place.altitude - home.altitude for place in places]
        usual = scenario.vehicle.autopilot.waypoint_defaults()
        legs = [waypoint(place, height, *usual) for place, height in zip(places, heights, strict=True)]
        items = (takeoff(home, heights[0]), change_speed(scenario.vehicle.cruise_speed), *legs, land(places[-1]))
        mission = Mission(home, items, scenario.vehicle.autopilot, scenario.vehicle.cruise_speed)
        return Forecast(mission, scenario)

    return fly


@pytest.fixture(scope="session")
def planned(forecast: Foreseen) -> Planned:
    """Add a plan: a curve along the arc."""

    @cache
    def plan(name: str) -> tuple[Forecast, Plan]:
        flown = forecast(name)
        assert flown.scenario is not None
        places = [leg.place for leg in item_legs(flown) if leg.item.command in {*WAYPOINTS, Command.NAV_TAKEOFF}]
        curve = Spline(np.array(places))
        history = np.array([9e4, 900.0, 500.0, 420.0, 401.5])
        cost, proof = curve_cost(curve, flown.scenario), prove_curve(curve, flown.scenario)
        return flown, Plan(curve, cost, proof, "ipoa", 7, np.arange(1, 6) * 60, history)

    return plan
