from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import Forecast, Mission, read_scenario
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, Grade
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.enlarged_airspace import EnlargedAirspace
from ipoa_mission.mission.items import return_to_launch, takeoff, waypoint
from ipoa_mission.vehicles.px4_multicopter.flight_model import Px4Model
from ipoa_mission.world.obstacles import Prism

SITL = Path(__file__).parents[2] / "missions" / "sitl.toml"
REQUIRED = 2.5  # [m]


def beside_wall(first_east: float) -> Forecast:
    """Forecast a flight to the east, 2.56 m beside a wall of 80 m that begins at `first_east`; the start is at 0."""
    south = REQUIRED + 0.06
    corners = ((first_east, south), (140.0, south), (140.0, south + 5.0), (first_east, south + 5.0))
    scenario = read_scenario(SITL)
    goal = scenario.goal.model_copy(update={"east": 150.0, "north": 0.0, "up": 15.0})
    scenario = scenario.model_copy(update={"goal": goal})
    walled = scenario.with_airspace(replace(scenario.airspace, obstacles=(Prism("wall", corners, (), 0.0, 80.0),)))
    home, end = (walled.frame.geodetic(np.array([east, 0.0, 0.0])) for east in (0.0, 150.0))
    items = (takeoff(home, 15.0), waypoint(end, 15.0, 0.1, 2.0), return_to_launch())
    return Forecast(Mission(walled.frame.home, items, parameters={"RTL_RETURN_ALT": 30.0}), walled)


@pytest.mark.parametrize("contingency", [Contingency.RTL, Contingency.HOLD])
def test_a_tight_start_leaves_the_bound_of_other_seconds(
    contingency: Contingency, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wall that is near to the start was enlarged by 0.05 m along the whole flight."""
    monkeypatch.setattr(Px4Model, "excess_deviation", lambda *_: None)
    for first_east in (30.0, -10.0):
        rows = Contingencies(beside_wall(first_east)).rows(contingency, timed=False)
        row = next(row for row in rows if row.from_s <= 40.0 < row.to_s)
        assert row.grade is not Grade.CLEAR
        assert row.least_m == pytest.approx(1.08, abs=0.02)


def test_near_a_tight_place_its_own_room_counts() -> None:
    forecast = beside_wall(-10.0)
    airspace = EnlargedAirspace.of(forecast.world)
    (tight,) = airspace.tight
    assert tight.name == "start"
    inside, outside = np.array([[0.0, 0.0, 15.0], [4.0, 0.0, 15.0]]), np.array([[20.0, 0.0, 15.0], [50.0, 0.0, 15.0]])
    assert airspace.obstacle_clearance(inside).distance == pytest.approx(REQUIRED + 0.01)
    bound = 2.56 - airspace.obstacle_clearance(outside).distance
    assert bound > 1.0
    through = np.vstack([inside[:1], outside[1:]])
    distance, number = airspace.leg_clearance(through[0], through[1], within=10.0)
    assert (distance, number) == (pytest.approx(2.56 - bound), 0)
    assert airspace.obstacle_clearance(through).distance == pytest.approx(distance)
    near = airspace.at_tight_place(np.vstack([inside[:1], outside[:1]]), np.vstack([inside[1:], outside[1:]]))
    assert near.tolist() == [True, False]


def test_without_a_tight_place_one_airspace_counts() -> None:
    paths = ContingencyPaths(Forecast(beside_wall(-10.0).mission, read_scenario(SITL)))
    assert paths.enlarged.tight == ()
    assert paths.enlarged.whole is paths.enlarged.left
