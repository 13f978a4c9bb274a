"""Contingencies that may meet another vehicle's flight, against their predicted flights from each second on."""

from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import Contingency, Forecast, Mission, MissionError, contingency_paths
from ipoa_mission.fleet.contingency_conflicts import contingency_conflicts, contingency_points, open_air
from ipoa_mission.fleet.fleet import STEP_S, FleetVehicle, timed_flight
from ipoa_mission.fleet.repairs import TimetableSlot
from tests.fleet.crossings import FRAME, eastward, northward

SEPARATION = 10.0
MISSIONS = {"east": eastward(), "north": northward()}


def slot(name: str, departs_s: float) -> TimetableSlot:
    forecast = Forecast(MISSIONS[name])
    vehicle = FleetVehicle(Path(name), forecast, timed_flight(name, forecast, FRAME))
    return TimetableSlot(vehicle, departs_s)


def least_distance(mission: Mission, contingency: Contingency, second: float, other: TimetableSlot) -> float:
    """Return the least distance to the other's flight, which departs `other.departs_s` later, after an order [m]."""
    forecast = open_air(mission)
    track = forecast.predicted_with(contingency, second).track.local().without_repeated_times()
    seconds = np.arange(second, track.times[-1], STEP_S)
    places = FRAME.to_local(*forecast.frame.to_geodetic(track.at(seconds)))
    flight = other.vehicle.flight
    met = np.rint((seconds - other.departs_s) / STEP_S).astype(int)
    flown = (met >= 0) & (met < len(flight.places))
    away = places[flown] - flight.places[met[flown]]
    return float(np.linalg.norm(away, axis=1).min(initial=np.inf))


@pytest.mark.parametrize(
    ("name", "other", "later_s", "contingency"),
    [
        ("east", "north", 8.0, Contingency.RTL),
        ("east", "north", 8.0, Contingency.LAND),
        ("north", "east", -4.0, Contingency.RTL),
        ("north", "east", -4.0, Contingency.LAND),
        ("north", "east", 20.0, Contingency.RTL),
    ],
)
def test_each_order_after_which_both_meet_is_warned_of(
    name: str, other: str, later_s: float, contingency: Contingency
) -> None:
    own = slot(name, max(0.0, -later_s))
    met = slot(other, max(0.0, later_s))
    found, _ = contingency_conflicts([own, met], FRAME, SEPARATION)
    warned = [each for each in found if each.pair == (name, other) and each.contingency == contingency]
    relative = TimetableSlot(met.vehicle, later_s)
    orders = np.arange(20.0, 44.0).tolist()
    near = [order for order in orders if least_distance(MISSIONS[name], contingency, order, relative) < SEPARATION]
    assert near
    for order in near:
        assert any(each.from_s - 1.0 <= order + own.departs_s <= each.to_s + 1.0 for each in warned)


def test_all_paths_of_one_moment_in_each_half_second_count() -> None:
    paths = [np.array([[0.0, 0.0, 20.0], [east, 0.0, 20.0]]) for east in (10.0, 20.0)]
    orders = [(second, path) for second in (30.1, 30.3, 30.4, 30.5, 30.9, 31.0) for path in paths]
    points = contingency_points(open_air(MISSIONS["east"]), Contingency.HOLD, orders, FRAME)
    assert np.unique(points.order_s).tolist() == [30.1, 30.5, 31.0]
    farthest = [points.places[points.order_s == second, 0].max() for second in (30.1, 30.5, 31.0)]
    assert farthest == pytest.approx([20.0] * 3, abs=0.1)


def test_hold_lasts_from_its_order_on_and_a_landing_remains() -> None:
    forecast = open_air(MISSIONS["east"])
    paths = contingency_paths(forecast)
    points = {}
    for contingency, orders in paths.items():
        assert not isinstance(orders, str)
        points[contingency] = contingency_points(forecast, contingency, orders, FRAME)
    hold = points[Contingency.HOLD]
    assert (hold.earliest == hold.order_s).all()
    assert np.isinf(hold.latest).all()
    land = points[Contingency.LAND]
    on_ground = land.places[:, 2] < 0.1
    assert on_ground.any()
    assert np.isinf(land.latest[on_ground]).all()
    assert np.isfinite(land.latest[~on_ground]).all()
    assert np.isfinite(points[Contingency.RTL].latest).all()
    with pytest.raises(MissionError, match="the duration of hold is not modeled"):
        forecast.predicted_with(Contingency.HOLD, 20.0)
