from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.forecast.conformance import ConformanceMonitor
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission
from ipoa_mission.scenario import Scenario
from tests.checks.test_airspace import flight, seen, world
from tests.refused import refuses


def past_the_hall(scenario: Scenario, east: float, north: float) -> Mission:
    """Return a flight past the hall's south wall at 3 m, its home moved [m]."""
    mission = flight(scenario, (0.0, 12.0, 20.0), (100.0, 12.0, 20.0))
    return replace(mission, home=scenario.frame.geodetic(np.array([east, north, 0.0])))


@pytest.mark.parametrize(("east", "north"), [(0.0, 0.0), (0.05, 0.0), (-0.7, -0.7), (0.0, 28.0), (0.0, -28.0)])
def test_moving_home_makes_no_clearance_of_the_cruise_better(east: float, north: float) -> None:
    scenario = world()
    in_place = Forecast(past_the_hall(scenario, 0.0, 0.0), scenario).guarantee.clearance
    assert in_place is not None
    mission = past_the_hall(scenario, east, north)
    moved = Forecast(mission, scenario)
    if np.hypot(east, north) <= 0.1:
        assert moved.guarantee.clearance is not None
        assert moved.guarantee.clearance.guaranteed <= in_place.guaranteed + 0.1
        assert "error home-differs 0" not in seen(mission, scenario)
        return
    assert moved.guarantee_if_known is None
    with refuses("home-differs", "home"):
        _ = moved.guarantee
    assert "error home-differs 0" in seen(mission, scenario)
    assert str(moved.another_home) in moved.estimate.remarks


def test_a_flight_is_compared_in_the_frame_of_its_home() -> None:
    scenario = world()
    mission = past_the_hall(scenario, 0.0, 28.0)
    begins = ConformanceMonitor(Forecast(mission, scenario)).local(mission.home, 0.0)
    assert begins == pytest.approx(np.zeros(3), abs=1e-6)
