import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.autopilot.energy import Battery, PowerCurve, PowerModel, power, shortage
from ipoa_mission.forecast.flight_energy import Consumption, by_curve, by_momentum
from ipoa_mission.forecast.timing.track import Track

QUAD = PowerModel(mass_kg=2.4, disc_area=0.342, drag_area=0.09)


def drawn(speed: float, climb: float = 0.0) -> float:
    return float(power(QUAD, np.array([speed]), np.array([climb]), np.array([1.225]))[0])


def cruise(speed: float, seconds: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, points and speeds of a level flight to the east."""
    times = np.arange(0.0, seconds + 1)
    return times, np.column_stack([speed * times, 0 * times, 0 * times]), np.full(len(times), speed)


def test_hovering_for_an_hour_takes_the_power_in_watt_hours() -> None:
    used = by_momentum(QUAD, Track(*cruise(0.0, 3600)))
    assert used.energy_wh == pytest.approx(drawn(0.0), rel=1e-6)
    assert (used.mean_w, used.spans_w.max()) == pytest.approx((used.energy_wh, used.energy_wh))


def test_vehicle_on_the_ground_before_takeoff_takes_no_energy() -> None:
    times, points, speeds = cruise(5.0, 120)
    points[:60] = points[60]
    used = by_curve(PowerCurve(180.0), Track(times, points, speeds))
    assert used.energy_wh == pytest.approx(180.0 * 60 / 3600)
    assert (used.spans_w[:60] == 0).all()
    still = by_curve(PowerCurve(180.0), Track(*cruise(0.0, 120)))
    assert still.energy_wh == pytest.approx(6.0)


def test_a_cruise_takes_its_power() -> None:
    assert by_momentum(QUAD, Track(*cruise(10.0, 100))).energy_wh * 3600 == pytest.approx(drawn(10.0) * 100, rel=1e-9)


def test_speeding_up_takes_kinetic_energy_and_braking_gives_none_back() -> None:
    times, points, speeds = cruise(10.0, 100)
    stops = speeds.copy()
    stops[[0, 50, 100]] = 0.0
    # Four spans have a mean of 5 m/s; 10 m/s is reached twice.
    joules = drawn(10.0) * 96 + drawn(5.0) * 4 + 2 * 0.5 * 2.4 * 10**2 / 0.8
    used = by_momentum(QUAD, Track(times, points, stops))
    assert used.energy_wh * 3600 == pytest.approx(joules, rel=1e-9)
    assert used.spans_w[[0, 50]] == pytest.approx([used.spans_w.max()] * 2)


def test_a_climb_is_flown_in_thinner_and_thinner_air() -> None:
    times, points, speeds = np.array([0.0, 60.0]), np.array([[0, 0, 0], [0, 0, 180.0]]), np.array([3.0, 3.0])
    low = by_momentum(QUAD, Track(times, points, speeds))
    assert low.mean_w == pytest.approx(drawn(0.0, 3.0), rel=0.01)
    assert by_momentum(QUAD, Track(times, points, speeds), altitude_amsl=2500.0).energy_wh > 1.05 * low.energy_wh


def test_wind_is_reckoned_as_airspeed() -> None:
    assert by_momentum(QUAD, Track(*cruise(5.0, 100)), head_wind=6.0).mean_w == pytest.approx(drawn(11.0))


def test_a_jump_in_position_costs_nothing() -> None:
    times, points, speeds = cruise(10.0, 100)
    jumpy = points.copy()
    jumpy[50:, 0] -= 0.7
    assert (
        by_momentum(QUAD, Track(times, jumpy, speeds)).energy_wh
        == by_momentum(QUAD, Track(times, points, speeds)).energy_wh
    )


def test_a_repeated_time_counts_once() -> None:
    track = Track(np.array([0.0, 0.0, 10.0, 10.0, 20.0]), np.zeros((5, 3)), np.zeros(5)).without_repeated_times()
    assert by_momentum(QUAD, track).energy_wh * 3600 == pytest.approx(20 * drawn(0.0))


@given(st.lists(st.integers(1, 99), min_size=1, max_size=6, unique=True))
def test_cutting_a_straight_flight_into_spans_changes_nothing(cuts: list[int]) -> None:
    ends = np.array([[0.0, 0, 0], [300.0, 200.0, 0.0]])
    fractions = np.array([0, *sorted(cuts), 100]) / 100
    whole = by_momentum(QUAD, Track(np.array([0.0, 50.0]), ends, np.full(2, 7.2)))
    points = ends[0] + fractions[:, None] * (ends[1] - ends[0])
    pieces = by_momentum(QUAD, Track(50 * fractions, points, np.full(len(points), 7.2)))
    assert pieces.energy_wh == pytest.approx(whole.energy_wh, rel=1e-9)


def used(energy_wh: float) -> Consumption:
    return Consumption(np.array([0.0, 3600.0]), *[np.array([energy_wh])] * 3)


def test_a_flight_that_keeps_the_reserve_passes() -> None:
    assert shortage(used(80.0).between, Battery(100.0, 0.2)) is None


@pytest.mark.parametrize(
    ("energy_wh", "words"),
    [
        (84.2, "the flight takes 84.2 Wh, leaves 15.8% of 100 Wh"),
        (130.0, "the flight takes 130.0 Wh, more than the 100 Wh of its battery"),
    ],
)
def test_a_flight_that_eats_the_reserve_is_refused(energy_wh: float, words: str) -> None:
    short = shortage(used(energy_wh).between, Battery(100.0, 0.2))
    assert short is not None
    assert str(short) == f"battery: expected a reserve of 20% after landing, but {words}"
    assert f"a battery of {energy_wh / 0.8:.1f} Wh" in str(short.hint)
    assert short.exit_code == 1


def test_energy_after_a_part_and_that_part_make_the_whole_flight() -> None:
    """The bounds are of one flight: one that draws more does so before and after."""
    flight = used(80.0).widened(0.9, 1.5)
    half = flight.until(1800.0)
    assert flight.between.rest_after(half) == pytest.approx(half)
    assert half == pytest.approx((36.0, 40.0, 60.0))
