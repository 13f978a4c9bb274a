"""Flights to report on: a bowed path over a scenario of the repository, estimated."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.mission.items import Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.timing.estimate import Estimate, estimate

Flight = tuple[Scenario, Mission, Estimate]


@pytest.fixture
def bowed(missions: Path) -> Callable[[str], Flight]:
    """A mission of nine waypoints on an arc from start to goal, west of the straight line."""

    def fly(name: str) -> Flight:
        scenario = read_scenario(missions / name)
        frame, home = scenario.frame, scenario.frame.home
        a, b = scenario.start_point, scenario.goal_point
        share = np.linspace(0, 1, 9)[:, None]
        aside = 0.3 * np.array([a[1] - b[1], b[0] - a[0], 46.0])
        places = [frame.geodetic(point) for point in a + share * (b - a) + np.sin(np.pi * share) * aside]
        heights = [place.altitude - home.altitude for place in places]
        legs = [waypoint(place, height) for place, height in zip(places, heights, strict=True)]
        items = (takeoff(home, heights[0]), change_speed(scenario.vehicle.cruise_speed), *legs, land(places[-1]))
        mission = Mission(home, items, scenario.vehicle.autopilot, scenario.vehicle.cruise_speed)
        return scenario, mission, estimate(mission, scenario.vehicle.autopilot_parameters())

    return fly
