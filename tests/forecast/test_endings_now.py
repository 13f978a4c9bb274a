"""What RTL and LAND would do at one second of a flight, for where the vehicle is then."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.cli.real_flight import ToldEndings
from ipoa_mission.forecast.endings import Endings
from ipoa_mission.forecast.endings_now import EndingsNow
from ipoa_mission.link.telemetry import Position
from ipoa_mission.vehicles.ending import Ending

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def forecast() -> Forecast:
    return Forecast(read_mission(MISSIONS / "sitl.plan"), read_scenario(MISSIONS / "sitl.toml"))


@pytest.mark.parametrize("late", [-5.0, 0.0, 5.0])
@pytest.mark.parametrize("share", [0.1, 0.45, 0.9])
def test_it_is_told_for_where_the_vehicle_is_though_it_is_late(forecast: Forecast, late: float, share: float) -> None:
    endings, now = Endings(forecast), EndingsNow(forecast)
    begin, end = endings.in_air
    time = begin + share * (end - begin)
    place = endings.stops().at(np.array([time]))[0][0]
    told = {row.ending: (row, seconds) for row, seconds in now.at(place, time + late)}
    assert set(told) == {Ending.RTL, Ending.LAND}
    for ending, (row, seconds) in told.items():
        assert row.from_s - 0.3 <= time <= row.to_s + 0.3
        lasts = endings.lasts(ending, time)
        assert lasts is not None
        assert seconds == pytest.approx(sum(lasts) / 2, rel=0.25, abs=3.0)


def test_the_command_line_tells_it_beside_what_is_done(forecast: Forecast) -> None:
    endings, told = Endings(forecast), list[str]()
    time = sum(endings.in_air) / 2
    there = forecast.frame.geodetic(endings.stops().at(np.array([time]))[0][0])
    record = SimpleNamespace(path=[SimpleNamespace(time_s=time)])
    vehicle: Any = SimpleNamespace(record=lambda: record, state=SimpleNamespace(in_air=True))
    teller = ToldEndings(forecast, vehicle, lambda _, words: told.append(words))
    teller.show(0.5, "item 3 of 6")
    at = (there.latitude_deg, there.longitude_deg, there.altitude, 20.0)
    for later in (0.0, 0.4, 1.2):  # by the vehicle's clock
        teller.hear(Position(time + later, *at))
    assert told[0] == "item 3 of 6"
    assert len(told) == 3
    assert all(words.startswith("item 3 of 6  now: rtl ") and "; land " in words for words in told[1:])
