"""Estimates against flights, as in the table of docs/lab/flight-time.md."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.forecast.timing.estimate import Estimate, qgroundcontrol_time
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.geodesy import LocalFrame
from tests.plain_python import flown_as_plain_python
from tests.recorded_flights import Recorded, read_flights

COPTER = read_flights(Autopilot.ARDUPILOT)
PX4 = read_flights(Autopilot.PX4)
REPEATED = [flight for flight in PX4 if len(flight.runs) > 1]
ESTIMATES: dict[str, Estimate] = {}


def estimated(flight: Recorded) -> Estimate:
    if flight.name not in ESTIMATES:
        ESTIMATES[flight.name] = estimate(flight.mission, flight.parameters)
    return ESTIMATES[flight.name]


def done(flight: Recorded) -> dict[int, float]:
    return {item.seq: item.done_s for item in estimated(flight).items}


def error(flight: Recorded) -> float:
    """Of the time from the first item done to the last waypoint, as a share."""
    when = done(flight)
    return (when[flight.last] - when[flight.first]) / float(flight.spans.mean()) - 1


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_arducopter_from_take_off_to_the_last_waypoint_within_two_per_cent(flight: Recorded) -> None:
    assert abs(error(flight)) < 0.02


def test_arducopter_is_right_within_half_a_per_cent_as_often_as_not() -> None:
    assert np.median([abs(error(flight)) for flight in COPTER]) < 0.005


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_arducopter_flies_each_leg_within_0_3_seconds_or_three_per_cent(flight: Recorded) -> None:
    when, (run,) = done(flight), flight.runs
    items = [n for n in sorted(run) if flight.first <= n <= flight.last]
    for before, after in pairwise(items):
        flown = run[after] - run[before]
        assert when[after] - when[before] == pytest.approx(flown, abs=max(0.3, 0.03 * flown)), f"item {after}"


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_arducopter_takeoff_and_landing_times_within_three_per_cent(flight: Recorded) -> None:
    when, (run,) = done(flight), flight.runs
    assert when[flight.first] == pytest.approx(run[flight.first], rel=0.02)
    last_item = len(flight.mission.items)
    assert when[last_item] - when[flight.last] == pytest.approx(run[last_item] - run[flight.last], rel=0.03)


@pytest.mark.parametrize("flight", REPEATED, ids=lambda f: f.name)
def test_px4_within_three_per_cent_of_the_mean_of_its_repeats(flight: Recorded) -> None:
    assert abs(error(flight)) < 0.03


def test_px4_is_right_within_one_and_a_half_per_cent_as_often_as_not() -> None:
    assert np.median([abs(error(flight)) for flight in REPEATED]) < 0.015


@pytest.mark.parametrize("flight", [f for f in PX4 if f not in REPEATED], ids=lambda f: f.name)
def test_single_px4_flights_lie_within_four_per_cent_or_the_interval(flight: Recorded) -> None:
    """On dense waypoints one flight differs from the next by 3 to 8 s."""
    last = next(item for item in estimated(flight).items if item.seq == flight.last)
    flown = float(flight.spans.mean())
    missed = error(flight) * flown
    assert abs(missed) < 0.04 * flown or last.done_s - last.high_s < missed < last.done_s - last.low_s


@pytest.mark.parametrize("flight", PX4, ids=lambda f: f.name)
def test_px4s_take_off_within_ten_per_cent(flight: Recorded) -> None:
    """Eleven per cent where it was flown once: of `survey` and `survey_again`, one mission, one is 3 s quicker."""
    flown = float(np.mean([run[flight.first] for run in flight.runs]))
    assert done(flight)[flight.first] == pytest.approx(flown, rel=0.10 if flight in REPEATED else 0.11)


@pytest.mark.parametrize("flight", PX4, ids=lambda f: f.name)
def test_px4s_landing_within_ten_per_cent_but_for_one(flight: Recorded) -> None:
    """`climb_gentle` hung over home for 12 s more than any other flight: 13 %."""
    last_item, predicted = len(flight.mission.items), estimated(flight)
    if last_item in flight.runs[0]:
        flown = float(np.mean([run[last_item] - run[flight.last] for run in flight.runs]))
        ours = done(flight)[last_item] - done(flight)[flight.last]
    else:
        flown, ours = flight.end_s - flight.runs[0][flight.last], predicted.total_s - done(flight)[flight.last]
    assert ours == pytest.approx(flown, rel=0.14 if flight.name == "climb_gentle-px4" else 0.10)


@pytest.mark.parametrize("flights", [COPTER, PX4], ids=["ArduCopter", "PX4"])
def test_the_interval_keeps_what_was_flown(flights: tuple[Recorded, ...]) -> None:
    inside = [
        item.low_s <= run[item.seq] <= item.high_s
        for flight in flights
        for item in estimated(flight).items
        for run in flight.runs
        if item.seq in run
    ]
    assert 0.85 < np.mean(inside) <= 0.95, "nine in ten are promised: fewer is wrong, and more is too wide"
    assert np.mean([item.high_s / item.low_s for item in map(estimated, flights)]) < 1.25, "not by being wide"


def test_px4s_waypoints_are_missed_as_often_as_predicted() -> None:
    """A waypoint that takes 3 s more than in most flights was missed: seven of those recorded."""
    predicted, recorded = 0.0, 0
    for flight in PX4:
        for before, item in pairwise(estimated(flight).items):
            usual = item.duration_s - item.missed.share * item.missed.cost_s
            for run in flight.runs:
                if flight.first <= before.seq and item.seq <= flight.last and before.seq in run and item.seq in run:
                    predicted += item.missed.share
                    recorded += run[item.seq] - run[before.seq] > usual + 3.0
    assert recorded / 2 < predicted < 2 * recorded
    assert not any(item.missed.share for flight in COPTER for item in estimated(flight).items)


@pytest.mark.parametrize("flight", [*COPTER, *PX4], ids=lambda f: f.name)
def test_the_flown_path_keeps_near_the_predicted_one(flight: Recorded) -> None:
    """ArduCopter's place is known within centimeters in the simulator, PX4's within a meter and more."""
    trace, predicted = flight.trace, estimated(flight)
    inside = (trace[:, 0] > flight.runs[0][flight.first]) & (trace[:, 0] < flight.runs[0][flight.last])
    frame = LocalFrame(flight.mission.home)
    flown = frame.to_local(trace[inside, 1], trace[inside, 2], flight.mission.home.altitude)[:, :2]
    path = predicted.track.points[:, :2]
    beside = np.array([np.linalg.norm(path - place, axis=1).min() for place in flown])
    between = float(np.linalg.norm(np.diff(path, axis=0), axis=1).max()) / 2
    assert np.quantile(beside, 0.95) < between + (0.25 if flight in COPTER else 1.3)


@pytest.mark.parametrize("flight", [COPTER[0], PX4[7]], ids=lambda f: f.name)
def test_compiled_and_plain_code_say_the_same_to_the_millisecond(flight: Recorded) -> None:
    forecast = Forecast(flight.mission.with_parameters(flight.parameters))
    model = type(flight.mission.autopilot.part(FlightModel))
    compiled = model().predicted(forecast.itinerary, forecast.wind, noise_free=False)
    with flown_as_plain_python():
        plain = model().predicted(forecast.itinerary, forecast.wind, noise_free=False)
    assert plain.done == pytest.approx(compiled.done, abs=1e-3)
    assert np.allclose(plain.track.points, compiled.track.points, atol=1e-3)


def test_distance_over_speed_says_the_same_of_a_curve_however_it_is_cut() -> None:
    for flight in COPTER:
        if flight.name.startswith("ways"):
            assert 28.0 < quoted(flight) < 31.0
            assert 1.5 < float(flight.spans.mean()) / quoted(flight) < 8.0


def quoted(flight: Recorded) -> float:
    upto = [
        qgroundcontrol_time(replace(flight.mission, items=flight.mission.items[:n]))
        for n in (flight.first, flight.last)
    ]
    return upto[1] - upto[0]
