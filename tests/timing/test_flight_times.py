"""The estimates against the flights, as in the table of docs/flight-time.md: flight by flight, leg by leg."""

from itertools import pairwise

import numpy as np
import pytest
from recorded_flights import Recorded, read_flights

from ipoa_mission.timing.estimate import Estimate, estimate
from ipoa_mission.vehicle import Autopilot

COPTER = read_flights(Autopilot.ARDUPILOT)
ESTIMATES: dict[str, Estimate] = {}


def estimated(flight: Recorded) -> Estimate:
    if flight.name not in ESTIMATES:
        ESTIMATES[flight.name] = estimate(flight.mission, flight.parameters)
    return ESTIMATES[flight.name]


def done(flight: Recorded) -> dict[int, float]:
    return {item.seq: item.done_s for item in estimated(flight).items}


def error(flight: Recorded) -> float:
    """Of the time from the first item done to the last waypoint, as a share of what was flown."""
    when = done(flight)
    return (when[flight.last] - when[flight.first]) / float(flight.spans.mean()) - 1


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_arducopter_from_take_off_to_the_last_waypoint_within_two_per_cent(flight: Recorded) -> None:
    assert abs(error(flight)) < 0.02


def test_arducopter_is_right_within_half_a_per_cent_as_often_as_not() -> None:
    assert np.median([abs(error(flight)) for flight in COPTER]) < 0.005


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_each_leg_of_arducopter_within_three_tenths_of_a_second_or_three_per_cent(flight: Recorded) -> None:
    when, (run,) = done(flight), flight.runs
    items = [n for n in sorted(run) if flight.first <= n <= flight.last]
    for before, after in pairwise(items):
        flown = run[after] - run[before]
        assert when[after] - when[before] == pytest.approx(flown, abs=max(0.3, 0.03 * flown)), f"item {after}"


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_arducopters_take_off_and_what_follows_the_last_waypoint_within_a_few_per_cent(flight: Recorded) -> None:
    when, (run,) = done(flight), flight.runs
    assert when[flight.first] == pytest.approx(run[flight.first], rel=0.02)
    ending = len(flight.mission.items)
    assert when[ending] - when[flight.last] == pytest.approx(run[ending] - run[flight.last], rel=0.03)
