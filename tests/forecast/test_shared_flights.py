"""Flights that continue others with the same first items."""

from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission import Forecast, Geodetic, Mission, Wind
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.forecast.timing.flight_model import FlightModel, Prediction
from ipoa_mission.mission.items import Item, change_speed, land, return_to_launch, spline_waypoint, takeoff, waypoint

HOME = Geodetic(46.9232, 10.5127, 1050.0)
LAST = 9  # waypoint


def place(n: int, east_m: float = 0.0) -> Geodetic:
    """Return a place of a zigzag."""
    east = 4e-4 * (n % 2) + 1e-5 * east_m
    return replace(HOME, latitude_deg=HOME.latitude_deg + 2e-4 * n, longitude_deg=HOME.longitude_deg + east)


def missions(mission: Mission) -> list[Mission]:
    """Return the mission, and others with an item changed, removed or added, a new end, or a parameter."""
    items = mission.items
    replaced = list[tuple[Item, ...]]()
    for n in range(1, LAST + 1):
        before, after = items[: n + 1], items[n + 2 :]
        replaced += [(*before, waypoint(place(n, 2.0), 12.0), *after), (*before, *after)]
        replaced += [(*before, change_speed(2.5), items[n + 1], *after), before + items[n + 1 : n + 2]]
        if mission.autopilot.guidance.flies_splines:
            replaced.append((*before, spline_waypoint(place(n), 12.0), *after))
    replaced += [(*items[:-1], land(place(LAST))), items[:-1]]
    others = [replace(mission, items=changed) for changed in replaced]
    height = mission.autopilot.parameter_table.by_meaning["return height"]
    higher = mission.with_parameters({height.name: 20.0 / height.unit})
    return [mission, *others, replace(mission, rally=(place(3),)), higher]


def expect_equal(one: Prediction, other: Prediction) -> None:
    for name in ("done", "low", "high"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("times", "points", "speeds"):
        assert getattr(one.track, name).tobytes() == getattr(other.track, name).tobytes()
    assert one.reasons == other.reasons
    assert one.remarks == other.remarks
    assert one.missed == other.missed


@pytest.mark.parametrize("autopilot", registered(), ids=str)
@pytest.mark.parametrize("wind", [Wind(0.0, 0.0), Wind(3.0, 250.0)], ids=["calm", "wind"])
def test_a_continued_flight_is_the_same_as_one_from_the_start(autopilot: Autopilot, wind: Wind) -> None:
    items = [takeoff(HOME, 12.0), change_speed(5.0), *(waypoint(place(n), 12.0) for n in range(1, LAST + 1))]
    mission = Mission(HOME, (*items, return_to_launch()), autopilot=autopilot)
    model = type(autopilot.part(FlightModel))
    continuing = model()
    for changed in [*missions(mission), mission]:
        forecast = Forecast(changed, wind=wind)
        for noise_free in (True, False):
            given = forecast.itinerary, forecast.wind, noise_free
            expect_equal(continuing.predicted(*given), model().predicted(*given))
