"""Probabilities of a loss of separation, against sampled flights."""

from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission.fleet.encounters import TIME_SPREADS, Encounters, PlannedDeparture, encounters
from ipoa_mission.fleet.fleet import STEP_S, TimedFlight
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.geometry import Points

SEPARATION = 10.0
FIXED = Quantiles((0.0, 1e-6, 2e-6), (1.0, 1e-4, 1e-8))
EXACT = DeviationLaw(FIXED, FIXED, FIXED, FIXED, FIXED, None, 1.0, 1.0, 1e6, 1e6, (0.0, 0.0, 0.0), "", 0.0)


def flight(name: str, corners: Points, speed: float = 5.0, deviation_s: float = 1.0) -> TimedFlight:
    """Return a flight at constant speed between corners (n, 3), 5 s on its pad before and after."""
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    times = np.concatenate([[0.0], 5.0 + np.concatenate([[0.0], np.cumsum(lengths / speed)])])
    times = np.append(times, times[-1] + 5.0)
    seconds = np.arange(0.0, times[-1] + STEP_S, STEP_S)
    along = np.concatenate([corners[:1], corners, corners[-1:]])
    places = np.column_stack([np.interp(seconds, times, axis) for axis in along.T])
    moving = np.flatnonzero(np.linalg.norm(np.diff(places, axis=0), axis=1) > 0)
    deviations = np.full(len(seconds), deviation_s)
    return TimedFlight(name, places, int(moving[0]), int(moving[-1]) + 1, deviations, EXACT)


def over(east: float, north: float = 0.0, up: float = 20.0) -> list[float]:
    return [east, north, up]


EASTWARD = flight("east", np.array([over(-60, 0, 0), over(-60), over(60), over(60, 0, 0)]))
NORTHWARD = flight("north", np.array([over(0, -60, 0), over(0, -60), over(0, 60), over(0, 60, 0)]), speed=8.0)


def sampled(a: TimedFlight, b: TimedFlight, delay: float, seed: int = 0) -> float:
    """Return the share of flights, moved in time by random deviations, that lose separation."""
    chance = np.random.default_rng(seed)
    offsets = delay + np.sqrt(2.0) * chance.standard_normal(2000)
    shares, widths = zip(*TIME_SPREADS, strict=True)
    for each in (a, b):
        of_each = chance.choice(widths, size=2000, p=shares)
        offsets += each.time_deviations[0] * of_each * chance.standard_normal(2000)
    fine = np.arange(-20.0, 120.0, 0.05)
    of_a, of_b = (np.arange(len(each.places)) * STEP_S for each in (a, b))
    lost = 0
    for offset in offsets:
        place_a = np.column_stack([np.interp(fine, of_a, axis) for axis in a.places.T])
        place_b = np.column_stack([np.interp(fine - offset, of_b, axis) for axis in b.places.T])
        lost += bool(np.linalg.norm(place_a - place_b, axis=1).min() < SEPARATION)
    return lost / len(offsets)


@pytest.mark.parametrize("delay", [0.0, 4.0, 8.0, 9.5, 12.0, 16.0])
def test_probability_is_the_share_of_sampled_flights(delay: float) -> None:
    met = Encounters(SEPARATION)
    planned = PlannedDeparture(EASTWARD, 0.0), PlannedDeparture(NORTHWARD, delay)
    predicted = met.probabilities(*planned, np.zeros(1))[0]
    assert predicted == pytest.approx(sampled(EASTWARD, NORTHWARD, delay), abs=0.03)
    assert met.probabilities(*planned[::-1], np.zeros(1))[0] == pytest.approx(predicted)


def test_conflict_has_the_place_and_time_of_the_closest_approach() -> None:
    met = Encounters(SEPARATION)
    second_over_origin = 5.0 + 20.0 / 5.0 + 60.0 / 5.0
    delay = second_over_origin - (5.0 + 20.0 / 8.0 + 60.0 / 8.0)
    conflict = met.conflicts([PlannedDeparture(EASTWARD, 100.0), PlannedDeparture(NORTHWARD, 100.0 + delay)])[0]
    assert conflict.pair == ("east", "north")
    assert conflict.place == pytest.approx([0.0, 0.0, 20.0], abs=2.0)
    assert conflict.second == pytest.approx(100.0 + second_over_origin, abs=0.5)
    assert conflict.distance_m < 2.0
    assert conflict.probability > 0.5


LOW = flight("low", np.array([over(-60, 0, 0), over(-60, 0, 8), over(60, 0, 8), over(60, 0, 0)]))
#: It climbs away to the north from a pad under the line of `LOW`, and lands 100 m away.
WAITING = flight("waiting", np.array([over(0, 0, 0), over(0, 0, 60), over(0, 100, 60), over(0, 100, 0)]))


@pytest.mark.parametrize(("delay", "probability"), [(500.0, 1.0), (-500.0, 0.0)])
def test_a_vehicle_on_its_pad_conflicts_with_one_that_flies_over(delay: float, probability: float) -> None:
    """It is on its pad before its departure, and no more after its take-off."""
    met = Encounters(SEPARATION)
    planned = PlannedDeparture(LOW, 500.0), PlannedDeparture(WAITING, 500.0 + delay)
    assert met.probabilities(*planned, np.zeros(1))[0] == pytest.approx(probability, abs=1e-6)
    assert met.probabilities(*planned[::-1], np.zeros(1))[0] == pytest.approx(probability, abs=1e-6)


@pytest.mark.parametrize(("delay", "probability"), [(500.0, 0.0), (-500.0, 1.0)])
def test_a_vehicle_that_has_landed_conflicts_with_one_that_flies_over(delay: float, probability: float) -> None:
    landing = flight("landing", np.array([over(0, 100, 0), over(0, 100, 60), over(0, 0, 60), over(0, 0, 0)]))
    planned = PlannedDeparture(LOW, 500.0), PlannedDeparture(landing, 500.0 + delay)
    assert Encounters(SEPARATION).probabilities(*planned, np.zeros(1))[0] == pytest.approx(probability, abs=1e-6)


def test_one_pad_is_used_by_one_vehicle_after_the_other() -> None:
    """The second is brought to the pad after the first has left it."""
    first = flight("first", np.array([over(0, 0, 0), over(0, 0, 30), over(0, 90, 30), over(0, 90, 0)]), 5.0, 0.5)
    corners = np.array([over(0.5, 0, 0), over(0.5, 0, 30), over(90, 0, 30), over(90, 0, 0)])
    second = flight("second", corners, 5.0, 0.5)
    delays = np.array([0.0, 5.0, 60.0])
    lost = Encounters(SEPARATION).probabilities(PlannedDeparture(first, 0.0), PlannedDeparture(second, 0.0), delays)
    assert lost[0] == pytest.approx(1.0, abs=1e-3)
    assert lost[1] > 0.7
    assert lost[2] < 1e-6


def test_vehicles_on_pads_side_by_side_conflict_when_one_takes_off() -> None:
    near = flight("near", np.array([over(6, 0, 0), over(6, 0, 30), over(90, 0, 30), over(90, 0, 0)]))
    planned = PlannedDeparture(WAITING, 0.0), PlannedDeparture(near, 300.0)
    assert Encounters(SEPARATION).probabilities(*planned, np.zeros(1))[0] > 0.99


def test_flights_apart_have_no_encounter() -> None:
    far = flight("far", EASTWARD.places[[0, 40, -40, -1]] + [0.0, 300.0, 0.0])
    assert not list(encounters(EASTWARD, far, SEPARATION))


SPREAD = Quantiles((0.0, 1.0, 2.0), (0.5, 0.1, 0.01))
NARROW = Quantiles((0.0, 1e-6), (0.5, 1e-6))


@pytest.mark.parametrize(("up", "down", "too_near"), [(SPREAD, NARROW, 1.0 - 0.05**0.5), (NARROW, SPREAD, 1.0)])
def test_deviations_away_from_the_other_open_the_distance(up: Quantiles, down: Quantiles, too_near: float) -> None:
    """A vehicle that passes 9.5 m above another is too near, unless it deviates upwards by more than 0.5 m."""
    low = replace(flight("low", np.array([over(-60), over(60)]), 8.0, 1e-3), departure_deviation_s=1e-3)
    high = flight("high", np.array([over(0, -60, 29.5), over(0, 60, 29.5)]), 8.0, 1e-3)
    wide = replace(high, law=replace(EXACT, up=up, down=down), departure_deviation_s=1e-3)
    for pair in ((wide, low), (low, wide)):
        first, second = (PlannedDeparture(each, 0.0) for each in pair)
        assert Encounters(SEPARATION).probabilities(first, second, np.zeros(1))[0] == pytest.approx(too_near, abs=0.03)
