import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.forecast.itinerary.itinerary import itinerary
from tests.least_time import PathLimits, least_time
from tests.recorded_flights import FLIGHTS, read_flight
from tests.refused import refuses

PLAIN = PathLimits(speed=12.0, climb=3.0, descent=2.0, accel=2.5)


def straight(length: float) -> np.ndarray:
    return np.array([[0.0, 0.0, 30.0], [length, 0.0, 30.0]])


@pytest.mark.parametrize("length", [100.0, 350.0, 2000.0])
def test_a_straight_line_takes_its_cruise_and_one_acceleration(length: float) -> None:
    assert least_time(straight(length), PLAIN).seconds == pytest.approx(length / 12.0 + 12.0 / 2.5, rel=1e-3)


def test_a_short_line_is_half_acceleration_half_braking() -> None:
    assert least_time(straight(20.0), PLAIN).seconds == pytest.approx(2 * math.sqrt(20.0 / 2.5), rel=2e-3)


def test_jerk_costs_half_its_ramp_at_either_end() -> None:
    """From rest under jerk j the speed a^2/2j comes at a^3/6j^2; after that v^2 grows as if nothing had been."""
    jerky = PathLimits(12.0, 3.0, 2.0, 2.5, jerk=1.0)
    more = least_time(straight(1000.0), jerky).seconds - least_time(straight(1000.0), PLAIN).seconds
    ramp, v0 = 2.5, 3.125
    reach = 2.5**3 / 6
    after = (12.0 - v0) / 2.5
    by_hand = ramp + after - (reach + (12.0**2 - v0**2) / 5.0) / 12.0
    assert more == pytest.approx(2 * (by_hand - (12.0 / 2.5) / 2), abs=0.05)


def test_bend_of_a_circle_sets_the_speed() -> None:
    angle = np.linspace(0, 6 * math.pi, 600)
    circle = np.column_stack([20 * np.cos(angle), 20 * np.sin(angle), np.full(600, 30.0)])
    fastest = least_time(circle, PLAIN)
    middle = fastest.speeds[len(fastest.speeds) // 2]
    assert middle == pytest.approx(math.sqrt(2.5 * 20), rel=1e-3)


@pytest.mark.parametrize(("rise", "speed"), [(100.0, 3.0), (-100.0, 2.0)])
def test_straight_up_and_down_have_their_own_speeds(rise: float, speed: float) -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, rise]])
    assert least_time(points, PLAIN).speeds.max() == pytest.approx(speed)


@given(st.lists(st.tuples(*[st.floats(-50, 50)] * 3), min_size=4, max_size=8, unique=True), st.floats(0.5, 4.0))
def test_more_of_anything_is_never_slower(corners: list[tuple[float, float, float]], factor: float) -> None:
    points = np.array(corners)
    if np.linalg.norm(np.diff(points, axis=0), axis=1).min() < 1.0:
        return
    slow, fast = sorted((1.0, factor))
    times = [least_time(points, PathLimits(8.0 * f, 3.0 * f, 2.0 * f, 2.0 * f, 1.0 * f)).seconds for f in (slow, fast)]
    assert times[1] <= times[0] * (1 + 1e-9)


@pytest.mark.parametrize("name", ["ways_even5-ardupilot", "ways_spl12-ardupilot", "ways_even5-px4"])
def test_no_flight_of_the_curve_beats_the_bound(name: str) -> None:
    flight = read_flight(FLIGHTS / name)
    route = itinerary(flight.mission)
    places = route.program.places[[v.item.has_position for v in route.visits]]
    bound = least_time(places[1:], PathLimits(12.0, 3.0, 3.0, 3.0)).seconds
    assert 33.0 < bound < flight.spans.min()


@pytest.mark.parametrize(
    ("points", "kinematics", "message"),
    [
        ([[0.0, 0.0, 0.0]], PLAIN, ("bad-input", "curve")),
        ([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], PLAIN, ("bad-input", "curve")),
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], PathLimits(0.0, 1.0, 1.0, 1.0), ("bad-input", "speed")),
    ],
)
def test_senseless_input_is_refused(
    points: list[list[float]], kinematics: PathLimits, message: tuple[str, ...]
) -> None:
    with refuses(*message):
        least_time(np.array(points), kinematics)
