"""What flights keep, by traces of recorded flights along a wall on one side.

`judged` flights came after the law was made.
"""

import csv
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.deviation.proximity import ProximityRisks

LONG = 120.0  # [s]
SIDES = ((1, 0), (0, 1), (-1, 0), (0, -1))


@cache
def traces(autopilot: Autopilot) -> list[tuple[bool, np.ndarray]]:
    """For each flight: is it judged; second, bend, east, north, up (n, 5)."""
    by_name: dict[str, tuple[bool, list[list[float]]]] = {}
    for row in csv.DictReader((Path(__file__).parents[1] / "data" / "traces.csv").read_text().splitlines()):
        if row["autopilot"] == autopilot.name:
            numbers = [float(row[name]) for name in ("second", "across", "east", "north", "up")]
            by_name.setdefault(row["flight"], (row["judged"] == "1", []))[1].append(numbers)
    return [(judged, np.array(rows)) for judged, rows in by_name.values()]


def beside_a_wall(autopilot: Autopilot, seconds: np.ndarray, across: np.ndarray) -> ProximityRisks:
    """A wall on one side, 10 m off, as long as the flight."""
    law, count = law_of(autopilot), len(seconds)
    number, far = np.zeros(count, dtype=np.intp), np.full(count, 10.0)
    low, over = np.full(count, -20.0), np.zeros(count, dtype=bool)
    return ProximityRisks(law, np.arange(count), number, seconds, far, low, over, law.widening(across), np.ones(count))


def chances(autopilot: Autopilot, judged: tuple[bool, ...], longest: float, shortest: float = 0.0) -> np.ndarray:
    """Return the chance of each flight and side to be as near as it was."""
    probabilities = []
    for is_judged, rows in traces(autopilot):
        seconds, across, level = rows[:, 0], rows[:, 1], rows[:, 2:4]
        if is_judged in judged and shortest <= seconds[-1] < longest:
            wall = beside_a_wall(autopilot, seconds, across)
            probabilities += [wall.chance(10.0 - float((level @ side).max())) for side in SIDES]
    return np.array(probabilities)


def shares(probabilities: np.ndarray) -> list[float]:
    """Return the shares below what 50, 90 and 99 % keep."""
    return [float((probabilities <= chance).mean()) for chance in (0.5, 0.1, 0.01)]


def test_short_px4_flights_fall_short_as_often_as_predicted() -> None:
    probabilities = chances(Autopilot.PX4, (False,), LONG)
    half, ninety, most = shares(probabilities)
    assert len(probabilities) >= 100
    assert 0.35 <= half <= 0.65
    assert 0.04 <= ninety <= 0.15
    assert most <= 0.02


@pytest.mark.parametrize("autopilot", list(registered()))
@pytest.mark.parametrize("judged", [False, True])
@pytest.mark.parametrize(("shortest", "longest"), [(0.0, LONG), (LONG, np.inf)])
def test_groups_of_flights_fall_short_no_more_often_than_predicted(
    autopilot: Autopilot, judged: bool, shortest: float, longest: float
) -> None:
    """Four sides a flight."""
    chances_of = chances(autopilot, (judged,), longest, shortest)
    assert len(chances_of) >= 12
    for share, chance in zip(shares(chances_of), (0.5, 0.1, 0.01), strict=True):
        assert scipy.stats.binomtest(round(share * len(chances_of)), len(chances_of), chance, "greater").pvalue > 0.05


@pytest.mark.parametrize("autopilot", list(registered()))
def test_a_surer_promise_and_a_longer_flight_keep_no_more(autopilot: Autopilot) -> None:
    rng = np.random.default_rng(11)
    for _ in range(5):
        near = _some_pairs(autopilot, rng)
        kept = [near.clearance_at(chance) for chance in (0.5, 0.2, 0.1, 0.01, 0.001)]
        assert np.all(np.diff(kept) <= 0.002)
        assert kept[0] <= near.distance.min()
        part = near.subset(near.seconds <= 60.0)
        assert all(part.clearance_at(chance) >= least - 0.002 for chance, least in ((0.5, kept[0]), (0.01, kept[3])))
        least = np.array([near.chance(float(far)) for far in np.linspace(-2.0, 6.0, 50)])
        assert np.all(np.diff(least) >= -1e-12)


@pytest.mark.parametrize("autopilot", list(registered()))
def test_the_chance_of_a_flight_is_no_more_than_the_sum_of_its_moments(autopilot: Autopilot) -> None:
    rng = np.random.default_rng(12)
    for _ in range(5):
        near = _some_pairs(autopilot, rng)
        for kept in (0.5, 1.5, 2.5):
            each = [near.subset(np.arange(len(near.piece)) == n).chance(kept) for n in range(len(near.piece))]
            assert max(each) <= near.chance(kept) + 1e-12 <= sum(each) + 2e-12


def test_twice_as_long_a_survey_keeps_centimeters_less() -> None:
    """Beside a wall for 800 and 1600 s, as beside trees for 100 and 200 legs."""
    flights = [beside_a_wall(Autopilot.PX4, np.arange(0.0, length), np.zeros(int(length))) for length in (800, 1600)]
    short, long = (10.0 - flight.clearance_at(0.01) for flight in flights)
    assert short < long < short + 0.2
    assert long < 2.6


def _some_pairs(autopilot: Autopilot, rng: np.random.Generator) -> ProximityRisks:
    """Forty moments in two minutes at one of five obstacles, beside, over or under them."""
    law, count = law_of(autopilot), 40
    numbers, seconds = rng.integers(0, 5, count), rng.uniform(0.0, 120.0, count)
    aside, above = rng.uniform(-1.0, 6.0, count), rng.uniform(-1.0, 6.0, count)
    away = np.where((aside < 0) & (above < 0), 3.0, aside)
    over, stretch = rng.random(count) < 0.5, law.widening(rng.uniform(0.0, 3.0, count))
    return ProximityRisks(law, np.arange(count), numbers, seconds, away, above, over, stretch, np.ones(count))
