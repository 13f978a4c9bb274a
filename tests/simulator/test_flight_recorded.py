"""Against missions that real autopilots flew; docs/lab/built-in-autopilot.md has all of them."""

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from tests.examples import some
from tests.flown_here import fly_here
from tests.recorded_flights import FLIGHTS, LANDINGS, Recorded, read_flight, read_flights

#: PX4's flights differ: the mean of several seeds.
SEEDS = range(2)


@pytest.mark.parametrize("flight", read_flights(Autopilot.ARDUPILOT), ids=lambda flight: flight.name)
def test_an_arducopter_mission_takes_as_long_as_it_was_recorded(flight: Recorded) -> None:
    done, end = fly_here(flight, seed=0)
    assert done[flight.last] - done[flight.first] == pytest.approx(flight.spans.mean(), rel=0.025)
    assert end - done[flight.last] == pytest.approx(flight.end_s - flight.runs[0][flight.last], rel=0.05)


@pytest.mark.parametrize("name", some(2, ["dense2", "corners", "spline5", "straight"]))
def test_a_px4_mission_takes_as_long_as_the_mean_of_its_recordings(name: str) -> None:
    flight = read_flight(FLIGHTS / f"{name}-px4")
    flown = [fly_here(flight, seed) for seed in SEEDS]
    spans = [done[flight.last] - done[flight.first] for done, _ in flown]
    assert np.mean(spans) == pytest.approx(flight.spans.mean(), rel=0.05)
    assert np.mean([done[flight.first] for done, _ in flown]) == pytest.approx(
        np.mean([run[flight.first] for run in flight.runs]), rel=0.1
    )
    landing = np.mean([end - done[flight.last] for done, end in flown])
    assert landing == pytest.approx(flight.end_s - flight.runs[0][flight.last], rel=0.1)


@pytest.mark.parametrize("flight", read_flights(Autopilot.ARDUPILOT, LANDINGS), ids=lambda flight: flight.name)
def test_arducopter_leaves_the_ground_and_comes_back_to_it_as_recorded(flight: Recorded) -> None:
    """Except for the second of a leg of a centimeter before the landing."""
    done, _ = fly_here(flight, seed=0)
    (run,), land = flight.runs, len(flight.mission.items)
    assert done[flight.first] == pytest.approx(run[flight.first], abs=0.3)
    assert done[land] - done[flight.last] == pytest.approx(run[land] - run[flight.last], abs=1.3)


@pytest.mark.long
def test_px4_stands_on_the_ground_as_long_as_recorded() -> None:
    flights = [read_flight(LANDINGS / f"land{height}_fast-px4") for height in (8, 30)]
    land = len(flights[0].mission.items)
    here = [fly_here(flight, seed)[0] for flight in flights for seed in range(24)]
    there = [run for flight in flights for run in flight.runs]
    for first, last in ((0, flights[0].first), (flights[0].last, land)):
        ours, theirs = (np.mean([flight[last] - flight.get(first, 0.0) for flight in flown]) for flown in (here, there))
        assert ours == pytest.approx(theirs, rel=0.06)
