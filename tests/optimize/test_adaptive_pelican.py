from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipoa_mission.optimize.adaptive_pelican import AdaptivePelican
from ipoa_mission.optimize.ipoa import IPOA
from ipoa_mission.optimize.search import Box, Candidates, Costs, minimize
from tests.examples import examples

D = 8
BOX = Box(np.full(D, -5.0), np.full(D, 5.0))
ROTATION, _ = np.linalg.qr(np.random.default_rng(2).standard_normal((D, D)))


def rosenbrock(x: Candidates) -> Costs:
    z = (x - 0.7) @ ROTATION + 1
    return np.asarray(np.sum(100 * (z[:, 1:] - z[:, :-1] ** 2) ** 2 + (1 - z[:, :-1]) ** 2, axis=1))


@settings(max_examples=examples(15))
@given(st.integers(40, 3000), st.integers(1, 12))
def test_adaptive_pelican_spends_exactly_its_evaluations(evaluations: int, dimension: int) -> None:
    box = Box(np.full(dimension, -1.0), np.full(dimension, 2.0))
    search = AdaptivePelican(evaluations=evaluations)
    found = minimize(lambda x: (x**2).sum(axis=1), box, search, np.random.default_rng(1))
    assert found.evaluations[-1] == evaluations


def test_the_flock_shrinks_to_four() -> None:
    sizes: list[int] = []

    def watched(x: Candidates) -> Costs:
        sizes.append(len(x))
        return rosenbrock(x)

    minimize(watched, BOX, AdaptivePelican(evaluations=20_000), np.random.default_rng(1))
    towards_prey = sizes[1::2]
    assert sizes[0] == 12 * D
    assert towards_prey[0] == 12 * D
    assert all(later <= earlier for earlier, later in pairwise(towards_prey))
    assert 4 <= towards_prey[-2] <= 5


def test_a_small_budget_gets_a_small_flock() -> None:
    first = next(AdaptivePelican(evaluations=4000).search(BOX, np.random.default_rng(1)))
    assert len(first) == 4000 / 200


def test_a_shift_of_the_problem_shifts_the_run_and_nothing_else() -> None:
    """Differences do not know where the origin is; products do."""
    shift = 100.0
    moved = Box(BOX.lower + shift, BOX.upper + shift)
    here, there = (
        minimize(cost, box, AdaptivePelican(evaluations=2000), np.random.default_rng(4))
        for box, cost in ((BOX, rosenbrock), (moved, lambda x: rosenbrock(x - shift)))
    )
    assert there.x - shift == pytest.approx(here.x, abs=1e-6)
    assert there.cost == pytest.approx(here.cost, rel=1e-4)


def test_adaptive_pelican_beats_ipoa_with_a_tenth_of_the_evaluations() -> None:
    ours = [
        minimize(rosenbrock, BOX, AdaptivePelican(evaluations=9_000), np.random.default_rng(run)).cost
        for run in range(5)
    ]
    ipoa = [minimize(rosenbrock, BOX, IPOA(), np.random.default_rng(run)).cost for run in range(5)]
    assert np.median(ours) < np.median(ipoa) / 3
