from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingency_samples import ReturnLeg
from ipoa_mission.forecast.contingency.shortfalls import Shortfall
from ipoa_mission.routing.obstacle_growth import ObstacleGrowth, initial_growth
from ipoa_mission.scenario import Scenario

POLE = {"kind": "cylinder", "name": "pole", "radius": 5.0, "height": 60.0}
PATH = np.column_stack([np.linspace(0.0, 100.0, 201), np.zeros(201), np.full(201, 20.0)])


@pytest.fixture
def two_poles() -> Scenario:
    """Two obstacles of one name, the first 1 m from the path, the second 4 m."""
    return Scenario.model_validate(
        {
            "home": {"latitude_deg": 47.0, "longitude_deg": 8.0},
            "start": {"east": 0.0, "north": 0.0, "up": 20.0},
            "goal": {"east": 100.0, "north": 0.0, "up": 20.0},
            "safety_distance": 2.0,
            "vehicle": {"autopilot": "px4", "radius": 0.5},
            "obstacles": [POLE | {"east": 20.0, "north": 6.0}, POLE | {"east": 80.0, "north": -9.0}],
        }
    )


def grown(scenario: Scenario, *short: Shortfall, broken: tuple[Any, ...] = ()) -> ObstacleGrowth:
    curve = SimpleNamespace(length=100.0, sample=lambda _: PATH)
    attempt: Any = SimpleNamespace(
        guarantee=SimpleNamespace(broken=broken), plan=SimpleNamespace(curve=curve), short=short
    )
    return initial_growth(scenario).more(attempt, scenario)


def test_the_obstacle_that_is_too_near_grows_and_none_of_the_same_name(two_poles: Scenario) -> None:
    beside = Shortfall(Contingency.RTL, 9.0, "pole", 0, 2.0, ReturnLeg.RETURNS)
    kept = SimpleNamespace(limit="obstacles", to="pole", slack=-2.0, in_cruise=True)
    for growth in (grown(two_poles, beside).growth, grown(two_poles, broken=(kept,)).growth):
        assert growth[0] > 0.0
        assert growth[1] == 0.0


def test_the_volume_below_an_overhang_grows_at_this_obstacle(two_poles: Scenario) -> None:
    above = Shortfall(Contingency.RTL, 9.0, "pole", 0, 2.0, ReturnLeg.CLIMBS, overhead=True)
    assert grown(two_poles, above).below_overhangs.tolist() == [0.0, -1.0]
