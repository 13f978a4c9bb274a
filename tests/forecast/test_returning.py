from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.returning import ReturnOrder
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.report.exports import lines_of
from ipoa_mission.report.table import mission_table

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)
ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4


def place(east: float, north: float, up: float) -> Geodetic:
    there = FRAME.geodetic(np.array([east, north, 0.0]))
    return Geodetic(there.latitude_deg, there.longitude_deg, up)


def mission(autopilot: Autopilot, *rally: Geodetic) -> Mission:
    items = (takeoff(HOME, 15.0), waypoint(place(150.0, 0.0, 0.0), 15.0), return_to_launch())
    return Mission(HOME, items, autopilot, rally=rally)


@pytest.mark.parametrize(
    ("autopilot", "parameters", "here", "rally", "goal"),
    [
        (ARDUPILOT, {}, (150.0, 0.0), [(130.0, 0.0), (160.0, 0.0)], 1),
        (ARDUPILOT, {}, (40.0, 0.0), [(130.0, 0.0)], None),  # home is nearer
        (ARDUPILOT, {"RALLY_INCL_HOME": 0.0}, (40.0, 0.0), [(130.0, 0.0)], 0),
        (ARDUPILOT, {}, (1000.0, 0.0), [(600.0, 0.0)], None),  # beyond 0.3 km
        (ARDUPILOT, {"RALLY_LIMIT_KM": 0.0}, (1000.0, 0.0), [(600.0, 0.0)], 0),
        (PX4, {}, (150.0, 0.0), [(130.0, 0.0), (160.0, 0.0)], 1),
        (PX4, {}, (1000.0, 0.0), [(600.0, 0.0)], 0),
        (PX4, {}, (30.0, 0.0), [(9.0, 0.0)], None),  # one at home is none
        (PX4, {}, (20.0, 0.0), [(39.0, 0.0)], None),  # nearer by less than 2 m
        (PX4, {"RTL_TYPE": 1.0}, (20.0, 0.0), [(300.0, 0.0)], 0),
    ],
)
def test_each_autopilot_returns_by_its_own_rule(
    autopilot: Autopilot,
    parameters: dict[str, float],
    here: tuple[float, float],
    rally: list[tuple[float, float]],
    goal: int | None,
) -> None:
    assert autopilot.return_route(parameters, ReturnOrder((*here, 15.0), [(*at, 10.0) for at in rally])).rally == goal


def test_the_height_of_a_rally_point_counts() -> None:
    assert ARDUPILOT.return_height(ARDUPILOT.complete({"RTL_ALT": 1500.0}), 10.0, 100.0, 25.0) == 25.0
    assert PX4.return_height(PX4.complete({}), 10.0, 100.0, 25.0) == 55.0
    assert PX4.return_height(PX4.complete({}), 10.0, 100.0) == 30.0


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4])
def test_a_return_to_a_rally_point_is_timed_and_drawn_as_it_is_flown(autopilot: Autopilot) -> None:
    """ArduCopter 4.7 with the rally point: 136.1 s where home would have taken 145.8."""
    beside, at_home = mission(autopilot, place(150.0, 30.0, 10.0)), mission(autopilot)
    ended = estimate(beside).track.points[-1]
    assert np.hypot(ended[0] - 150.0, ended[1] - 30.0) < 2.5
    assert estimate(beside).total_s < estimate(at_home).total_s - 5.0
    drawn = lines_of(Forecast(beside))[-1].points[-1]
    assert np.hypot(*(FRAME.local(Geodetic(drawn[1], drawn[0], 488.0))[:2] - [150.0, 30.0])) < 0.01
    length, homeward = mission_table(beside)[-1].length, mission_table(at_home)[-1].length
    assert length is not None
    assert homeward is not None
    assert length < homeward - 50.0


def test_parameters_decide_in_the_estimate_too() -> None:
    there = mission(ARDUPILOT, place(150.0, 400.0, 10.0))
    assert np.hypot(*estimate(there).track.points[-1, :2]) < 2.5
    far = replace(there, parameters={"RALLY_LIMIT_KM": 0.0, "RALLY_INCL_HOME": 0.0})
    assert np.hypot(*(estimate(far).track.points[-1, :2] - [150.0, 400.0])) < 2.5
