"""Flights that are flown on from where they were stopped."""

import math
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.autopilot.failsafe import TIMED, Contingency
from ipoa_mission.compiled import compiled
from ipoa_mission.forecast.contingency.contingencies import predict_contingency
from ipoa_mission.vehicles.px4_multicopter.simulation import FlownMotions, MissionSimulation
from tests.examples import examples
from tests.plain_python import flown_as_plain_python

MISSIONS = Path(__file__).parents[2] / "missions"
LASTS_S = 80.0  # longer than the mission


def forecast_of(name: str) -> Forecast:
    return Forecast(read_mission(MISSIONS / f"{name}.plan"), read_scenario(MISSIONS / f"{name}.toml"))


@pytest.fixture(scope="module")
def simulation() -> MissionSimulation:
    forecast = forecast_of("sitl")
    return MissionSimulation(forecast.itinerary, forecast.wind)


def numbers(state: Any) -> Iterator[float]:
    return chain.from_iterable(map(numbers, state)) if isinstance(state, tuple) else iter((float(state),))


def expect_equal(one: FlownMotions, other: FlownMotions) -> None:
    """Expect the same flights to the bit, also in all that they go on from."""
    assert one.done.tobytes() == other.done.tobytes()
    assert one.samples.tobytes() == other.samples.tobytes()
    np.testing.assert_array_equal([*numbers(one.progress)], [*numbers(other.progress)])


@settings(max_examples=examples(30))
@given(seed=st.integers(1, 90), stops=st.lists(st.floats(0.1, LASTS_S), min_size=2, max_size=4), noisy=st.booleans())
def test_a_flight_flown_on_is_the_same_as_one_without_a_stop(
    simulation: MissionSimulation, seed: int, stops: list[float], noisy: bool
) -> None:
    fly_on = simulation.flight_of(simulation.mission_motions.motions, noisy=noisy, sampled=True)
    stopped = simulation.at_start(seed)
    for time in sorted(stops):
        stopped = fly_on(stopped, until=time)
    expect_equal(stopped, fly_on(simulation.at_start(seed), until=max(stops)))


@pytest.mark.parametrize("until", [0.3, 20.0, 45.0, LASTS_S])
def test_a_flight_is_the_same_compiled_and_not(simulation: MissionSimulation, until: float) -> None:
    motions = simulation.mission_motions.motions
    start = simulation.at_start(7)
    with flown_as_plain_python():
        plain = simulation.flight_of(motions, noisy=True, sampled=True)
    expect_equal(plain(start, until=until), simulation.flight_of(motions, noisy=True, sampled=True)(start, until=until))


@pytest.fixture
def spans(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, float, float]]:
    """Record begin and end of each simulated span, and the time of its order [s]."""
    recorded = list[tuple[float, float, float]]()

    def recording(function: Any) -> Any:
        machine = compiled(function)

        def flown(orders: Any, constants: Any, flight: Any, until: float, every: int) -> Any:
            ended = machine(orders, constants, flight, until, every)
            recorded.append((flight.state[0], ended[2][0][0], until))
            return ended

        return flown

    monkeypatch.setattr("ipoa_mission.vehicles.px4_multicopter.simulation.compiled", recording)
    return recorded


@pytest.mark.parametrize("contingency", TIMED)
def test_a_contingency_is_flown_on_from_the_order(
    spans: list[tuple[float, float, float]], contingency: Contingency
) -> None:
    predict_contingency(forecast_of("sitl"), contingency, 30.0)
    ordered = [end for _, end, until in spans if until < math.inf]
    onward = [begin for begin, _, until in spans if until == math.inf and begin > 0.0]
    assert len(ordered) > 3
    assert sorted(onward) == sorted(ordered)
    assert len(spans) == len(ordered) + len(onward) + 1, "and the mission once without noise"
