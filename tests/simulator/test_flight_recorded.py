"""The built-in autopilot against missions that real autopilots flew; docs/built-in-autopilot.md has all of them."""

import numpy as np
import pytest
from flown_here import fly_here
from recorded_flights import FLIGHTS, read_flight, read_flights

from ipoa_mission.vehicle import Autopilot

#: PX4's flights differ from one to the next, recorded as flown here: the mean of so many stands for ours.
SEEDS = range(2)


@pytest.mark.parametrize("flight", read_flights(Autopilot.ARDUPILOT), ids=lambda flight: flight.name)
def test_an_arducopter_mission_takes_as_long_as_it_was_recorded(flight) -> None:  # type: ignore[no-untyped-def]
    done, end = fly_here(flight, seed=0)
    assert done[flight.last] - done[flight.first] == pytest.approx(flight.spans.mean(), rel=0.025)
    assert end - done[flight.last] == pytest.approx(flight.end_s - flight.runs[0][flight.last], rel=0.05)


@pytest.mark.parametrize("name", ["dense2", "corners", "spline5", "straight"])
def test_a_px4_mission_takes_as_long_as_the_mean_of_its_recordings(name: str) -> None:
    flight = read_flight(FLIGHTS / f"{name}-px4")
    flown = [fly_here(flight, seed) for seed in SEEDS]
    spans = [done[flight.last] - done[flight.first] for done, _ in flown]
    assert np.mean(spans) == pytest.approx(flight.spans.mean(), rel=0.05)
    assert np.mean([done[flight.first] for done, _ in flown]) == pytest.approx(
        np.mean([run[flight.first] for run in flight.runs]), rel=0.1
    )
    ending = np.mean([end - done[flight.last] for done, end in flown])
    assert ending == pytest.approx(flight.end_s - flight.runs[0][flight.last], rel=0.1)
