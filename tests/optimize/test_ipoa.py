import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.optimize.ipoa import IPOA, iterate_chaotic_map, levy_factor, refract
from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import Box, Candidates, Costs, minimize

BOX = Box(np.full(4, -10.0), np.full(4, 30.0))


def bowl(x: Candidates) -> Costs:
    return np.asarray(((x - [3.0, -2.0, 8.0, 1.0]) ** 2).sum(axis=1))


@pytest.mark.parametrize(
    ("settings", "evaluations"),
    [
        ({}, 90_060),
        ({"reading": "literal"}, 90_060),
        ({"chaotic_start": False}, 90_030),
        ({"mutation": False}, 60_060),
        ({"mutated": "best"}, 61_060),
        ({"reading": "survivor"}, 120_060),
        ({"chaotic_start": False, "inertia": False, "levy": False, "mutation": False}, 60_030),
    ],
)
def test_the_evaluations_of_thirty_pelicans_and_a_thousand_iterations(
    settings: dict[str, object], evaluations: int
) -> None:
    """2 N + 3 N T with everything on."""
    optimum = minimize(lambda x: np.zeros(len(x)), BOX, build_optimizer("ipoa", settings), np.random.default_rng(1))
    assert optimum.evaluations[-1] == evaluations


@pytest.mark.parametrize(
    "settings",
    [
        {"chaotic_start": False},
        {"inertia": False},
        {"levy": False},
        {"mutation": False},
        {"reading": "literal"},
        {"reading": "survivor"},
        {"weight": "exp(t/T-1)"},
        {"weight": "exp(t/T)-1"},
        {"prey": "best"},
        {"mutated": "best"},
        {"mutated": "own"},
        {"rand": "dimension"},
        {"steps": "pelican"},
        {"share": 0.01},
        {"refraction": 2.0},
        {"chaos": 0.5},
        {"beta": 1.2},
        {"radius": 0.4},
        {"freedom_most": 3.0},
        {"freedom_least": 2.0},
    ],
    ids=str,
)
def test_no_setting_is_dead(settings: dict[str, object]) -> None:
    default = minimize(bowl, BOX, IPOA(iterations=10), np.random.default_rng(1))
    shorter = minimize(bowl, BOX, build_optimizer("ipoa", {"iterations": 10} | settings), np.random.default_rng(1))
    assert not np.array_equal(default.x, shorter.x)


def test_ipoa_without_its_four_strategies_is_poa() -> None:
    bare = IPOA(population=10, iterations=25, chaotic_start=False, inertia=False, levy=False, mutation=False)
    runs = range(100)
    ours = [minimize(bowl, BOX, bare, np.random.default_rng([1, run])).cost for run in runs]
    poas = [
        minimize(bowl, BOX, POA(population=10, iterations=25), np.random.default_rng([2, run])).cost for run in runs
    ]
    assert scipy.stats.ks_2samp(ours, poas).pvalue > 0.01


def test_the_literal_reading_is_the_worse_one_away_from_the_origin() -> None:
    """(1 + s) on the position hurts where the optimum is not at the origin."""
    step, literal = (
        np.median(
            [
                minimize(bowl, BOX, build_optimizer("ipoa", {"iterations": 60, "reading": reading}), rng).cost
                for rng in map(np.random.default_rng, range(15))
            ]
        )
        for reading in ("step", "literal")
    )
    assert step < literal / 2


def test_the_chaotic_map_is_its_formula_and_fills_its_interval() -> None:
    z = iterate_chaotic_map(0.7, 300, 5, np.random.default_rng(1))
    assert z.shape == (300, 5)
    assert z[1:] == pytest.approx(np.sin(0.7 * np.pi / z[:-1]), abs=1e-12)
    assert np.all(np.abs(z) <= 1)
    assert z.min() < -0.95
    assert z.max() > 0.95


@given(st.lists(st.floats(-10, 30), min_size=4, max_size=4))
def test_plain_opposition_mirrors_and_mirrors_back(x: list[float]) -> None:
    point = np.array([x])
    opposite = refract(point, BOX, 1.0)
    assert opposite == pytest.approx(20 - point, abs=1e-9)
    assert refract(opposite, BOX, 1.0) == pytest.approx(point, abs=1e-9)


def test_refraction_draws_the_opposite_towards_the_middle() -> None:
    """Eq. (20) with k n = 2: half as far on the other side."""
    assert refract(np.full((1, 4), 30.0), BOX, 2.0) == pytest.approx(np.zeros((1, 4)))


def test_levy_factors_have_mantegnas_scale_and_a_heavy_tail() -> None:
    """sigma_u is 0.6966 for beta = 1.5; P(|s| > a) falls as a^-1.5: a factor of ten costs one of 31.6."""
    s = np.abs(levy_factor(1.5, (400_000,), np.random.default_rng(1)))
    u = np.abs(np.random.default_rng(2).normal(0, 0.696575, 400_000))
    v = np.abs(np.random.default_rng(3).normal(size=400_000))
    assert scipy.stats.ks_2samp(s, u / v ** (2 / 3)).pvalue > 0.001
    assert (s > 3).mean() / (s > 30).mean() == pytest.approx(10**1.5, rel=0.15)
