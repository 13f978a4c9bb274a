"""Take-off and landing from 8 to 60 m high, from arming to disarming by the vehicle's clock; nothing was fitted."""

from functools import cache

import numpy as np
import pytest
import scipy

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.timing.estimate import Estimate
from tests.recorded_flights import LANDINGS, Recorded, read_flights

COPTER = read_flights(Autopilot.ARDUPILOT, LANDINGS)
PX4 = read_flights(Autopilot.PX4, LANDINGS)
BY_NAME = {flight.name: flight for flight in (*COPTER, *PX4)}


@cache
def predicted(name: str) -> Estimate:
    return estimate(BY_NAME[name].mission, BY_NAME[name].parameters)


def parts(flight: Recorded) -> tuple[float, float]:
    """Return estimated seconds of take-off and landing."""
    done = {item.seq: item.done_s for item in predicted(flight.name).items}
    return done[flight.first], done[len(flight.mission.items)] - done[flight.last]


def flown(flight: Recorded) -> np.ndarray:
    """(flights, 2): flown seconds of take-off and landing."""
    end = len(flight.mission.items)
    return np.array([(run[flight.first], run[end] - run[flight.last]) for run in flight.runs if flight.last in run])


@pytest.mark.parametrize("flight", COPTER, ids=lambda f: f.name)
def test_arducopter_landing_time_within_two_per_cent(flight: Recorded) -> None:
    """LAND may begin with a leg of one centimeter, which takes 1.1 s."""
    (take_off, landing), ((flown_off, flown_land),) = parts(flight), flown(flight)
    assert take_off == pytest.approx(flown_off, abs=0.1)
    assert landing == pytest.approx(flown_land, abs=max(0.02 * flown_land, 0.85))


def test_arducopters_landings_are_neither_long_nor_short_as_a_whole() -> None:
    off = [parts(flight)[1] - flown(flight)[0, 1] for flight in COPTER]
    assert abs(np.mean(off)) < 0.5


@pytest.mark.parametrize("part", [0, 1], ids=["take-off", "landing"])
def test_px4_takes_as_long_on_average_within_three_per_cent(part: int) -> None:
    ratios = [parts(flight)[part] / flown(flight)[:, part].mean() - 1 for flight in PX4]
    assert abs(np.mean(ratios)) < 0.03
    assert np.median(np.abs(ratios)) < 0.04


@pytest.mark.parametrize("flights", [COPTER, PX4], ids=["ArduCopter", "PX4"])
def test_nine_in_ten_of_what_was_flown_lie_in_the_interval(flights: tuple[Recorded, ...]) -> None:
    """Of PX4's 32 flights four missed a waypoint or hung in the air, with all items after that."""

    def inside(estimated: Estimate, run: dict[int, float]) -> list[bool]:
        return [item.low_s <= run[item.seq] <= item.high_s for item in estimated.items if item.seq in run]

    kept = [is_inside for flight in flights for run in flight.runs for is_inside in inside(predicted(flight.name), run)]
    # few items: not distinguishable from a share of 85 to 95 %
    assert scipy.stats.binomtest(sum(kept), len(kept), 0.85, "less").pvalue > 0.05
    assert scipy.stats.binomtest(sum(kept), len(kept), 0.95, "greater").pvalue > 0.05
