import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Mission, change_speed, takeoff, waypoint
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.wind import CALM, Wind
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 488.0)


def flown(path: Points, autopilot: Autopilot, speed: float, wind: Wind = CALM) -> float:
    """From the first corner to the last [s]."""
    latitude, longitude, altitude = LocalFrame(HOME).to_geodetic(np.column_stack([path, np.full(len(path), 30.0)]))
    places = [Geodetic(*map(float, place)) for place in zip(latitude, longitude, altitude, strict=True)]
    items = (takeoff(places[0], 30.0), change_speed(speed), *(waypoint(place, 30.0) for place in places))
    done = Forecast(Mission(HOME, items, autopilot), wind=wind).predicted(noise_free=True).done
    return float(done[-1] - done[2])


@pytest.mark.parametrize("autopilot", registered(), ids=str)
@pytest.mark.parametrize(("speed", "spacing"), [(3.0, 3.0), (5.0, 20.0), (8.0, 40.0)])
def test_a_survey_takes_about_what_its_forecast_says(autopilot: Autopilot, speed: float, spacing: float) -> None:
    path = np.array([(x, spacing * k) for k in range(6) for x in ((0.0, 150.0) if k % 2 == 0 else (150.0, 0.0))])
    times = LegTimes.of(Mission(HOME, (), autopilot), speed)
    start_and_stop = 2.0 * speed  # legs are counted between corners at speed
    took = flown(path, autopilot, speed)
    assert times.seconds(path) == pytest.approx(took, rel=0.08, abs=start_and_stop)
    assert times.seconds(path) > len(path) // 2 * 150.0 / speed


@pytest.mark.parametrize("autopilot", registered(), ids=str)
def test_a_sharper_corner_costs_more_and_none_nothing(autopilot: Autopilot) -> None:
    times = LegTimes.of(Mission(HOME, (), autopilot), 8.0)
    legs = [
        np.array([[0.0, 0.0], [300.0, 0.0], [300.0 + 300.0 * c, 300.0 * s]]) for c, s in ((1, 0), (0.7, 0.7), (0, 1))
    ]
    straight, bent, right = (times.seconds(path) - 300.0 / 8.0 * 2 for path in legs)
    assert straight == pytest.approx(0.0, abs=1e-9)
    assert 0.0 < bent < right


def test_against_the_wind_it_takes_longer() -> None:
    against, along = np.array([[0.0, 0.0], [-900.0, 0.0]]), np.array([[-900.0, 0.0], [0.0, 0.0]])
    mission = Mission(HOME, (), registered()[1])
    times = LegTimes.of(mission, 14.0, wind=Wind(5.0, from_deg=270.0))
    assert times.seconds(against) > 1.05 * times.seconds(along)
    with refuses("unreachable", "survey", "10"):
        LegTimes.of(mission, 14.0, wind=Wind(10.0, from_deg=270.0))
