from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from ipoa_mission import read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.wind import CALM, Wind, WindLevel
from tests.plain_python import flown_as_plain_python
from tests.recorded_flights import FLIGHTS, IN_WIND, Recorded, read_flight, read_flights
from tests.refused import refuses

FLOWN = read_flights(Autopilot.ARDUPILOT, IN_WIND)
PX4_FLOWN = read_flights(Autopilot.PX4, IN_WIND)
CALM_FLIGHT = read_flight(FLIGHTS / "straight-ardupilot")


def estimated(flight: Recorded, wind: Wind) -> Estimate:
    return estimate(flight.mission, flight.parameters, wind)


def error(flight: Recorded, wind: Wind) -> float:
    """Of the time from the first item done to the last waypoint, as a share."""
    done = {item.seq: item.done_s for item in estimated(flight, wind).items}
    return (done[flight.last] - done[flight.first]) / float(flight.spans.mean()) - 1


@pytest.mark.parametrize("flight", FLOWN, ids=lambda f: f.name)
def test_a_flight_in_wind_takes_as_long_as_estimated_within_two_per_cent(flight: Recorded) -> None:
    assert abs(error(flight, flight.wind)) < 0.02


def test_median_flight_time_in_wind_within_one_per_cent() -> None:
    assert np.median([abs(error(flight, flight.wind)) for flight in FLOWN]) < 0.01
    assert np.median([abs(error(flight, CALM)) for flight in FLOWN]) > 0.05


def test_px4_in_a_steady_wind_takes_as_long_as_estimated() -> None:
    """Up to 6 m/s: PX4's simulated vehicle, whose drag allows 9.8 m/s, hardly moves against 8 m/s."""
    steady = [flight for flight in PX4_FLOWN if flight.wind.speed <= 6 and not flight.turbulence]
    assert len(steady) >= 10
    assert max(abs(error(flight, flight.wind)) for flight in steady) < 0.035
    assert np.median([abs(error(flight, flight.wind)) for flight in steady]) < 0.02
    assert np.median([abs(error(flight, CALM)) for flight in steady]) > 0.03


@pytest.mark.parametrize("flight", FLOWN, ids=lambda f: f.name)
def test_take_off_and_landing_in_wind_keep_their_predicted_times(flight: Recorded) -> None:
    done = {item.seq: item.done_s for item in estimated(flight, flight.wind).items}
    run, last = flight.runs[0], len(flight.mission.items)
    assert done[flight.first] == pytest.approx(run[flight.first], rel=0.02)
    flown = flight.end_s - run[flight.last]
    assert done[last] - done[flight.last] == pytest.approx(flown, rel=0.055 if flight.turbulence else 0.035)


@pytest.mark.parametrize(
    ("wind", "says"),
    [
        (Wind(9.9, 0.0), "does not get on to 0, 60, 30 m"),
        (Wind(13.0, 90.0), "blows the copter off its path at"),
        (Wind(25.0, 270.0), "item 1: the wind of 25 m/s from 270 deg blows the copter off"),
    ],
)
def test_a_wind_in_which_the_copter_does_not_hold_its_path_is_refused(wind: Wind, says: str) -> None:
    with pytest.raises(MissionError) as refused:
        estimated(CALM_FLIGHT, wind)
    assert says in str(refused.value)
    assert str(refused.value).startswith("item ")


def test_a_wind_near_the_ground_alone_costs_nothing_on_the_way() -> None:
    """A mission at 30 m, in a wind that reaches its speed at 2 km."""
    light = Wind(8.0, 0.0, exponent=1.0, gradient_height=2000.0)
    assert light.speed_at(30.0) == pytest.approx(0.12)
    calm, windy = error(CALM_FLIGHT, CALM), error(CALM_FLIGHT, light)
    assert windy == pytest.approx(calm, abs=0.002)
    assert error(CALM_FLIGHT, Wind(8.0, 0.0)) > 0.5


def test_the_built_in_autopilot_flies_in_the_same_wind() -> None:
    flight = read_flight(IN_WIND / "straight_w8d0t0-ardupilot")
    flown = SimulatedFlight(Autopilot.ARDUPILOT, flight.mission.home, flight.parameters, Conditions(flight.wind))
    flown.load(flight.mission.items)
    flown.arm()
    flown.start()
    while flown.armed and flown.time_s < 600.0:
        flown.advance(flown.time_s + 1.0)
    done = {reached.index + 1: reached.time_s for reached in flown.reached}
    assert done[flight.last] - done[flight.first] == pytest.approx(float(flight.spans.mean()), rel=0.02)


@pytest.mark.parametrize("autopilot", registered())
def test_a_wind_that_grows_with_height_is_weaker_below(autopilot: Autopilot) -> None:
    """At 10 m, a sixteenth of the gradient height, an exponent of a half leaves a quarter of the speed."""
    home, there = Geodetic(47.4, 8.5, 400.0), Geodetic(47.403, 8.5, 400.0)
    mission = Mission(home, (takeoff(home, 10.0), change_speed(8.0), waypoint(there, 10.0), land(there)), autopilot)
    weak, grown, strong = (
        estimate(mission, wind=wind).route_s for wind in (Wind(1.5, 0.0), Wind(6.0, 0.0, 0.5, 160.0), Wind(6.0, 0.0))
    )
    assert grown == pytest.approx(weak, rel=0.01)
    assert strong > 1.05 * grown


@pytest.mark.parametrize("autopilot", registered())
def test_a_profile_of_one_wind_or_of_a_power_law_agrees_with_it(autopilot: Autopilot) -> None:
    home = Geodetic(47.4, 8.5, 400.0)
    mission, short = (
        Mission(home, (takeoff(home, up / 4), change_speed(8.0), waypoint(there, up), land(there)), autopilot)
        for there, up in ((Geodetic(47.403, 8.5, 400.0), 40.0), (Geodetic(47.4002, 8.5, 400.0), 12.0))
    )
    heights = [0.0, 2.0, 6.0, 12.0, 20.0, 30.0, 45.0, 60.0]
    law = Wind(6.0, 200.0, 0.5, 60.0)
    same, profile = (
        Wind.of_profile([5.0, 50.0], [6.0] * 2, [200.0] * 2),
        Wind.of_profile(heights, [law.speed_at(height) for height in heights], [200.0] * 8),
    )
    plainly = nullcontext() if autopilot is Autopilot.PX4 else flown_as_plain_python()  # slow on PX4
    for flown, manner in ((mission, nullcontext()), (short, plainly)):
        with manner:
            plain, levels = (estimate(flown, wind=wind).total_s for wind in (Wind(6.0, 200.0), same))
        assert levels == pytest.approx(plain, abs=1e-6)
    by_law, by_levels = (estimate(mission, wind=wind).total_s for wind in (law, profile))
    assert by_levels == pytest.approx(by_law, rel=0.003)


def test_wind_profile_is_interpolated_between_levels_and_constant_beyond() -> None:
    wind = Wind.of_profile([20.0, 40.0, 100.0], [4.0, 4.0, 8.0], [270.0, 180.0, 180.0])
    assert wind.velocity(5.0) == pytest.approx((4.0, 0.0), abs=1e-9)
    assert wind.velocity(30.0) == pytest.approx((2.0, 2.0), abs=1e-9)
    assert wind.velocity(70.0) == pytest.approx((0.0, 6.0), abs=1e-9)
    assert wind.velocity(500.0) == pytest.approx((0.0, 8.0), abs=1e-9)
    assert (wind.speed, wind.from_deg) == (8.0, 180.0)


def test_spread_of_a_wind_profile_counts_at_each_level() -> None:
    wind = Wind.of_profile([10.0, 20.0, 40.0], [1.0, 0.0, 8.0], [180.0, 0.0, 270.0], spread=3.0)
    stronger = wind.as_strong_as_may_be()
    assert [stronger.speed_at(level.height) for level in stronger.levels] == pytest.approx([4.0, 3.0, 11.0])
    assert stronger.velocity(10.0) == pytest.approx((0.0, 4.0), abs=1e-9)
    assert stronger.velocity(20.0) == pytest.approx((3.0, 0.0), abs=1e-9)
    assert stronger.strongest == pytest.approx(11.0)


def test_wind_profile_needs_as_many_speeds_and_directions_as_heights() -> None:
    with refuses("bad-input", "", "3", "2"):
        Wind.of_profile([10.0, 20.0, 40.0], [1.0, 2.0], [0.0, 0.0])


@pytest.mark.parametrize("wrong", range(3))
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_wind_profile_of_other_than_finite_numbers_is_refused(wrong: int, value: float) -> None:
    numbers = [[10.0], [5.0], [270.0]]
    numbers[wrong] = [value]
    with refuses("bad-input", "", f"{value}"):
        Wind.of_profile(numbers[0], numbers[1], numbers[2])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0])
@pytest.mark.parametrize("name", ["speed", "exponent", "gradient_height", "spread"])
def test_a_wind_of_other_than_finite_numbers_is_refused(name: str, value: float) -> None:
    with refuses("bad-input", "", name, f"{value:g}"):
        Wind(**{"speed": 5.0, "gradient_height": 10.0, name: value})  # type: ignore[arg-type]
    with refuses("bad-input", "", "from_deg", "nan"):
        Wind(5.0, float("nan"))
    with refuses("bad-input", "", "speed", "-1"):
        Wind.of_profile([10.0, 20.0], [-1.0, -2.0], [0.0, 0.0])


def test_winds_of_unlike_profiles_have_unlike_json() -> None:
    uniform, sheared, lower = Wind(6.0), Wind(6.0, 0.0, 0.3, 100.0), Wind(6.0, 0.0, 0.3, 50.0)
    assert uniform.as_json() == {"speed_m_s": 6.0, "from_deg": 0.0, "spread_m_s": 0.0}
    assert sheared.as_json() == {**uniform.as_json(), "exponent": 0.3, "gradient_height_m": 100.0}
    assert lower.as_json() != sheared.as_json()


@pytest.mark.parametrize("wind", [Wind(6.0, 359.7), Wind.of_profile([10.0, 20.0], [6.0, 7.0], [359.7, 0.2])])
def test_a_wind_from_just_west_of_north_is_from_0_deg(wind: Wind) -> None:
    assert "360 deg" not in f"{wind}"
    assert "from 0 deg" in f"{wind}"


@pytest.mark.parametrize("heights", [(), (100.0, 10.0), (10.0, 10.0), (10.0, float("nan")), tuple(range(9))])
def test_wind_profile_of_other_than_a_few_increasing_heights_is_refused(heights: tuple[float, ...]) -> None:
    with refuses("bad-input", "", "1 to 8", f"{list(heights)}"):
        Wind.of_profile(heights, [5.0] * len(heights), [0.0] * len(heights))


@pytest.mark.parametrize("autopilot", list(registered()))
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_parameter_that_is_no_finite_number_is_refused(autopilot: Autopilot, value: float) -> None:
    mission = Mission(Geodetic(47.4, 8.5, 488.0), (), autopilot)
    name = sorted(autopilot.parameter_names)[0]
    with refuses("bad-input", name, f"{value}"):
        mission.with_parameters({name: value})


@pytest.mark.parametrize("levels", [2, 7, 8])
def test_wind_between_two_levels_is_linear(levels: int) -> None:
    heights = [10.0 * n + 0.1 for n in range(levels)]
    wind = Wind.of_profile(heights, [0.3 * n for n in range(levels)], [37.0 * n for n in range(levels)])
    for height in (0.0, *heights, *np.linspace(0.0, 90.0, 50)):
        expected = [np.interp(height, heights, [level[axis] for level in wind.levels]) for axis in (1, 2)]
        assert wind.velocity(height) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_a_power_law_counts_from_the_scenarios_home() -> None:
    """As the levels of a profile do; 4.56 m/s were 6 for a home 40 m below."""
    mission, scenario = read_mission("missions/sitl.plan"), read_scenario("missions/sitl.toml")
    wind = Wind(6.0, 270.0, exponent=0.3, gradient_height=50.0)
    heights = (5.0, 20.0, 35.0, 60.0, 95.0)
    for lower in (-10.0, 0.0, 40.0):
        home = replace(mission.home, altitude=scenario.frame.home.altitude - lower)
        air = Forecast(replace(mission, home=home), scenario, wind)._air
        assert [air.speed_at(height) for height in heights] == [wind.speed_at(height - lower) for height in heights]
        assert air.speed_at(lower + 20.0) == pytest.approx(6.0 * (20.0 / 50.0) ** 0.3)


@pytest.mark.parametrize("heights", [range(9), (10.0, 5.0)])
def test_levels_of_a_wind_are_few_and_increase(heights: Sequence[float]) -> None:
    with refuses("bad-input"):
        Wind(levels=tuple(WindLevel(height, 1.0, 0.0) for height in heights))


def test_a_mission_at_no_place_has_no_estimate() -> None:
    mission = read_mission("missions/sitl.plan")
    for home in (Geodetic(np.nan, 8.5, 488.0), Geodetic(200.0, 8.5, 488.0)):
        with refuses("home-place"):
            estimate(replace(mission, home=home))


def test_a_guarantee_without_a_scenario_is_an_error() -> None:
    with refuses("scenario-missing"):
        _ = Forecast(read_mission("missions/sitl.plan")).guarantee
