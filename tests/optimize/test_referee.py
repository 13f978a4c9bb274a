from dataclasses import fields

import numpy as np
import pytest

from ipoa_mission.optimize.registry import build_optimizer, optimizer_class, optimizer_names
from ipoa_mission.optimize.search import Box, Candidates, Costs, Optimizer, minimize
from tests.refused import refuses

D = 6
LOWER, UPPER = np.linspace(-30, -10, D), np.linspace(20, 60, D)
BOX = Box(LOWER, UPPER)
ROTATION, _ = np.linalg.qr(np.random.default_rng(5).standard_normal((D, D)))
OPTIMUM = LOWER + (UPPER - LOWER) * np.linspace(0.3, 0.7, D)


def ellipsoid(x: Candidates) -> Costs:
    """Shifted, rotated, condition 100."""
    return np.asarray(((x - OPTIMUM) @ ROTATION) ** 2 @ np.logspace(0, 2, D))


def small(name: str, evaluations: int = 6000, iterations: int = 100) -> Optimizer:
    """Build an optimizer with those of these limits that are a setting of its."""
    limits = {"evaluations": evaluations, "iterations": iterations}
    settings = {field.name for field in fields(optimizer_class(name))}  # type: ignore[arg-type]
    return build_optimizer(name, {setting: limit for setting, limit in limits.items() if setting in settings})


#: Known median error over eleven runs on the ellipsoid, within a factor of five.
ABILITY = {"ipoa": 20.0, "dbo": 250.0, "poa": 4.5, "ssa": 1.0, "mpoa": 0.08, "hho": 90.0}


@pytest.mark.parametrize("name", optimizer_names())
def test_every_candidate_is_inside_the_box(name: str) -> None:
    def watched(x: Candidates) -> Costs:
        assert x.ndim == 2
        assert x.shape[1] == D
        assert np.all(x >= LOWER)
        assert np.all(x <= UPPER)
        return ellipsoid(x)

    minimize(watched, BOX, small(name), np.random.default_rng(1))


@pytest.mark.parametrize("name", optimizer_names())
def test_a_budget_is_never_exceeded_and_the_count_is_that_of_the_cost(name: str) -> None:
    seen = 0

    def counted(x: Candidates) -> Costs:
        nonlocal seen
        seen += len(x)
        return ellipsoid(x)

    optimum = minimize(counted, BOX, small(name), np.random.default_rng(1), budget=1234)
    assert seen == optimum.evaluations[-1] <= 1234
    assert seen > 1234 - 120  # no batch is larger than that


@pytest.mark.parametrize("name", optimizer_names())
def test_the_same_seed_gives_the_same_run_and_another_seed_another(name: str) -> None:
    first, again, of_other_seed = (
        minimize(ellipsoid, BOX, small(name), np.random.default_rng(seed), budget=2000) for seed in (3, 3, 4)
    )
    assert np.array_equal(first.x, again.x)
    assert np.array_equal(first.history, again.history)
    assert not np.array_equal(first.x, of_other_seed.x)


@pytest.mark.parametrize("name", optimizer_names())
def test_the_best_cost_known_never_rises_and_is_that_of_the_best_candidate(name: str) -> None:
    optimum = minimize(ellipsoid, BOX, small(name), np.random.default_rng(2))
    assert np.all(np.diff(optimum.history) <= 0)
    assert np.all(np.diff(optimum.evaluations) > 0)
    assert optimum.cost == optimum.history[-1] == pytest.approx(ellipsoid(optimum.x[None])[0], rel=1e-9)


@pytest.mark.parametrize("name", optimizer_names())
def test_a_cost_that_is_sent_is_not_changed(name: str) -> None:
    search = small(name).search(BOX, np.random.default_rng(1))
    x = next(search)
    kept: list[tuple[Candidates, Candidates, Costs, Costs]] = []
    for _ in range(40):
        f = ellipsoid(x)
        kept.append((x, x.copy(), f, f.copy()))
        x = search.send(f)
        assert all(np.array_equal(f, g) for _, _, f, g in kept)


@pytest.mark.long
@pytest.mark.parametrize("name", optimizer_names())
def test_a_shifted_and_rotated_optimum_is_found_as_well_as_is_known(name: str) -> None:
    errors = [minimize(ellipsoid, BOX, small(name), np.random.default_rng(run)).cost for run in range(11)]
    assert ABILITY[name] / 5 < np.median(errors) < ABILITY[name] * 5 or np.median(errors) < 1e-12


@pytest.mark.parametrize("name", optimizer_names())
def test_a_cost_that_is_the_same_everywhere_stops_nobody(name: str) -> None:
    optimum = minimize(lambda x: np.ones(len(x)), BOX, small(name), np.random.default_rng(1))
    assert optimum.cost == 1


@pytest.mark.parametrize("penalty", [np.inf, np.nan])
@pytest.mark.parametrize("name", optimizer_names())
def test_penalties_that_are_infinite_or_undefined_do_no_harm(name: str, penalty: float) -> None:
    def walled(x: Candidates) -> Costs:
        return np.where(x[:, 0] > OPTIMUM[0] + 1, penalty, ellipsoid(x))

    optimum = minimize(walled, BOX, small(name), np.random.default_rng(1))
    assert np.isfinite(optimum.cost)
    assert optimum.cost < np.median(ellipsoid(BOX.sample(200, np.random.default_rng(9))))


@pytest.mark.parametrize("name", optimizer_names())
def test_one_dimension_and_one_iteration_are_enough(name: str) -> None:
    box = Box(np.array([-1.0]), np.array([2.0]))
    least = small(name, evaluations=40, iterations=1)
    optimum = minimize(lambda x: x[:, 0] ** 2, box, least, np.random.default_rng(1))
    assert -1 <= optimum.x[0] <= 2


@pytest.mark.parametrize(
    ("lower", "upper"), [([1.0, 0.0], [0.0, 1.0]), ([0.0], [1.0, 1.0]), ([np.nan], [1.0]), ([-np.inf], [1.0])]
)
def test_a_box_without_an_inside_is_refused(lower: list[float], upper: list[float]) -> None:
    with refuses("bad-input", "", "finite lower values"):
        Box(np.array(lower), np.array(upper))


def test_every_optimizer_has_a_known_ability() -> None:
    assert set(ABILITY) == set(optimizer_names())
