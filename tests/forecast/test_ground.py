"""LAND on ground that is not as high as home, as real autopilots flew it.

Home was 40 m over, at, and 12 m under the ground (DO_SET_HOME); LAND from 25 m over home, 60 m from the take-off.
ArduCopter 4.7.0-dev has no range finder; PX4 1.17 flew with SIH's own and without one (SIH_DISTSNSR_OVR 20000).
"""

from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.mission.items import Mission, land, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.landing_ground import landing_on
from ipoa_mission.simulator.fly import fly_built_in
from tests.examples import some
from tests.recorded_flights import FLOWN_ON

HOME = Geodetic(47.397742, 8.545594, 488.0)
BLIND = {"SIH_DISTSNSR_OVR": 20_000.0}
#: Autopilot, parameters, ground over home [m], flown LAND until disarming [s], tolerance [s].
FLOWN = [
    (Autopilot.ARDUPILOT, {}, -40.0, (115.1,), 0.9),
    (Autopilot.ARDUPILOT, {}, 0.0, (35.2,), 0.9),
    (Autopilot.ARDUPILOT, {}, 12.0, (12.8,), 0.9),
    (Autopilot.PX4, {}, -40.0, (57.7, 53.8), 5.0),
    (Autopilot.PX4, {}, 0.0, (26.8, 28.4), 3.0),
    (Autopilot.PX4, {}, 12.0, (18.7, 19.6), 3.0),
    (Autopilot.PX4, BLIND, -40.0, (88.4, 89.3, 85.4), 4.0),
    (Autopilot.PX4, BLIND, 0.0, (29.6,), 7.0),
    (Autopilot.PX4, BLIND, 12.0, (13.2,), 6.0),
]


def mission(autopilot: Autopilot, ground: float, parameters: dict[str, float]) -> Mission:
    there = LocalFrame(HOME).geodetic(np.array([0.0, 60.0, 0.0]))
    items = (takeoff(HOME, 20.0), waypoint(there, 25.0), land(there))
    version = FLOWN_ON[autopilot]
    return landing_on(Mission(HOME, items, autopilot, parameters=parameters, firmware_version=version), ground)


@pytest.mark.parametrize(("autopilot", "parameters", "ground", "flown", "near"), some(4, FLOWN))
def test_a_landing_takes_as_long_as_the_ground_asks_for(
    autopilot: Autopilot, parameters: dict[str, float], ground: float, flown: tuple[float, ...], near: float
) -> None:
    asked = mission(autopilot, ground, parameters)
    predicted = estimate(asked)
    here = [fly_built_in(asked, seed=seed) for seed in range(len(flown))]  # each differs by 2 s
    landings = [flight.item_reached_s[2] - flight.item_reached_s[1] for flight in here]
    assert predicted.items[2].duration_s == pytest.approx(np.mean(flown), abs=near)
    assert np.mean(landings) == pytest.approx(np.mean(flown), abs=near)
    assert predicted.track.points[-1, 2] == pytest.approx(ground, abs=1.0)
    assert [flight.path[-1].height for flight in here] == pytest.approx([ground] * len(here), abs=1.0)


def test_a_range_finder_lets_arducopter_slow_down_over_the_ground() -> None:
    high, deep = (mission(Autopilot.ARDUPILOT, ground, {"RNGFND1_TYPE": 1.0}) for ground in (12.0, -40.0))
    level = estimate(mission(Autopilot.ARDUPILOT, 0.0, {})).items[2].duration_s
    assert estimate(deep).items[2].duration_s == pytest.approx(level + 40.0 / 1.5, abs=0.5)
    assert estimate(high).items[2].duration_s == pytest.approx(level - 12.0 / 1.5, abs=0.5)


@pytest.mark.parametrize("autopilot", registered())
def test_a_return_ends_at_home_and_a_take_off_begins_where_it_landed(autopilot: Autopilot) -> None:
    contingency = mission(autopilot, -40.0, {})
    home = replace(contingency, items=(*contingency.items[:2], return_to_launch()))
    level = replace(home, landing_ground=None)
    assert estimate(home).total_s == estimate(level).total_s
    there = contingency.items[1]
    again = replace(contingency, items=(*contingency.items, contingency.items[0], there, contingency.items[2]))
    twice = estimate(again)
    assert twice.items[3].duration_s > twice.items[0].duration_s + 40.0 / 3.5  # it climbs from the bottom
    assert twice.track.points[-1, 2] == pytest.approx(-40.0, abs=1.0)
