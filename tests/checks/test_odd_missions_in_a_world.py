from contextlib import suppress
from itertools import product
from pathlib import Path

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.checks.check import check
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, takeoff, waypoint
from ipoa_mission.scenario import read_scenario
from tests.report_pages import page_of

SCENARIO = read_scenario(Path(__file__).parents[2] / "missions" / "sitl.toml")
HOME = SCENARIO.home.geodetic()
ITEMS = {
    "speed": change_speed(5.0),
    "takeoff": takeoff(HOME, 10.0),
    "waypoint": waypoint(HOME, 10.0),
    "return": return_to_launch(),
    "jump": Item(Command.DO_JUMP, Frame.MISSION, (1.0, 1.0, 0.0, 0.0)),
    "delay": Item(Command.NAV_DELAY, Frame.MISSION, (3.0, 0.0, 0.0, 0.0)),
}


@pytest.mark.parametrize("autopilot", registered(), ids=str)
def test_each_is_judged(autopilot: Autopilot) -> None:
    for names in [*product(ITEMS, repeat=1), *product(ITEMS, repeat=2)]:
        forecast = Forecast(Mission(HOME, tuple(ITEMS[name] for name in names), autopilot), SCENARIO)
        assert all(finding.message for finding in check(forecast))


@pytest.mark.parametrize("name", ITEMS)
def test_each_alone_is_drawn_or_it_is_said_why_not(name: str) -> None:
    forecast = Forecast(Mission(HOME, (ITEMS[name],), Autopilot.ARDUPILOT), SCENARIO)
    with suppress(MissionError):
        assert "From above" in page_of(forecast)
