"""Whole flights of ArduCopter 4.8.0-dev (531699d652, its simulator, calm air) that ended in RTL or LAND.

Both begin with a leg of centimeters of 0 to 2.6 s. The margins come from 87 flights, these among them.
"""

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, takeoff, waypoint

Places = list[tuple[float, float, float]]
VINES, HURDLES = Geodetic(49.8, 9.93, 200.0), Geodetic(47.397742, 8.545594, 488.0)
BY_RTL: Places = [(49.8003598, 9.9310255, 36.387), (49.8007092, 9.9320228, 48.342), (49.8011687, 9.9333336, 46.606)]
NO_LEG: Places = [
    (47.3977271, 8.5465267, 16.449),
    (47.3978088, 8.5470292, 8.001),
    (47.3977663, 8.5477207, 20.155),
    (47.3976845, 8.5484242, 10.677),
]
A_LEG: Places = [(47.397466, 8.5465288, 10.0), (47.3974532, 8.5472731, 10.001), (47.3979243, 8.5480594, 9.003)]


@pytest.mark.parametrize(
    ("home", "height", "speed", "places", "lands", "flown"),
    [
        (VINES, 14.0, 7.0, BY_RTL, False, 146.55),
        (HURDLES, 12.0, 12.9227645, NO_LEG, True, 69.35),
        (HURDLES, 13.19, 7.1297326, A_LEG, True, 69.02),
    ],
)
def test_the_interval_holds_the_landing(
    home: Geodetic, height: float, speed: float, places: Places, lands: bool, flown: float
) -> None:
    ways = [waypoint(Geodetic(latitude, longitude, 0.0), up) for latitude, longitude, up in places]
    down = Item(Command.NAV_LAND, Frame.GLOBAL_RELATIVE_ALT, (0.0,) * 4, *places[-1][:2], 0.0)
    contingency = down if lands else return_to_launch()
    items = (takeoff(home, height), change_speed(speed), *ways, contingency)
    last = Forecast(
        Forecast(Mission(home, items, Autopilot.ARDUPILOT)).on(Version(4, 8)).mission_as_read
    ).estimate.items[-1]
    assert last.low_s <= flown <= last.high_s
    assert np.isclose(last.high_s - last.low_s, 2.6, atol=1.0), "no wider than the spread of the landings"
