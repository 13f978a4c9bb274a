from typing import Any

import numpy as np
import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.optimize.registry import optimizer_names
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.planning.proof import prove_curve
from tests.examples import some
from tests.planning.conftest import Make, Place, Town
from tests.quick_search import QUICK
from tests.refused import refuses

TALL = {"kind": "box", "east": 50, "north": 0, "width": 6, "height": 120, "base": 0.0}
PILLAR = {"kind": "cylinder", "name": "pillar", "east": 50, "north": 1, "radius": 10, "height": 99, "base": 0.0}
BALL = {"kind": "sphere", "name": "ball", "east": 75, "north": -4, "up": 20, "radius": 6}
TOWER = {"kind": "box", "name": "tower", "east": 100, "north": 0, "width": 20, "depth": 20, "height": 50, "base": 0.0}


def fort(height: float) -> dict[str, object]:
    outer, inner = ((70, -30), (130, -30), (130, 30), (70, 30)), ((74, -26), (126, -26), (126, 26), (74, 26))
    return {"kind": "prism", "name": "fort", "footprint": outer, "holes": (inner,), "height": height, "base": 0.0}


def gap(width: float) -> list[dict[str, Any]]:
    sides = {"left": 60 + width / 2, "right": -60 - width / 2}
    return [TALL | {"name": f"{name} wall", "north": north, "depth": 120} for name, north in sides.items()]


@pytest.mark.parametrize("name", some(1, optimizer_names()))
def test_every_optimizer_finds_a_safe_path(scenario: Make, name: str) -> None:
    job = scenario(obstacles=[PILLAR, BALL], optimizer={"name": name})
    plan = plan_path(job, seed=1)
    assert plan.proof.is_proved
    assert prove_curve(plan.curve, job).worst.slack >= 0
    assert plan.cost.total < 85  # the straight way would cost 70
    assert plan.optimizer == name
    np.testing.assert_array_equal(plan.curve.control[[0, -1]], [job.start_point, job.goal_point])


@pytest.mark.parametrize("tables", some(1, [{}, {"planning": {"polish": False}}, {"cost": {"form": "nodes"}}]))
def test_the_same_seed_gives_the_same_plan_to_the_last_bit(scenario: Make, tables: dict[str, Any]) -> None:
    job = scenario(obstacles=[PILLAR], optimizer={"population": 10, "iterations": 20}, **tables)
    one, two, of_other_seed = (plan_path(job, seed=seed, strategy=QUICK) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one.curve.control, two.curve.control)
    np.testing.assert_array_equal(one.history, two.history)
    assert one.cost == two.cost
    assert not np.array_equal(one.curve.control, of_other_seed.curve.control)


def test_free_way_is_flown_straight(scenario: Make) -> None:
    plan = plan_path(scenario())
    assert plan.curve.length == pytest.approx(100, abs=1e-3)
    assert plan.cost.total == pytest.approx(70, abs=0.02)


def test_history_never_gets_worse_and_counts_evaluations(scenario: Make) -> None:
    progress = []
    plan = plan_path(scenario(obstacles=[PILLAR]), progress=lambda done, words: progress.append(done))
    assert (np.diff(plan.history) <= 0).all()
    assert (np.diff(plan.evaluations) > 0).all()
    assert progress == sorted(progress)
    assert 0 <= progress[0] < progress[-1] < 1


def test_a_strategy_that_looks_less_hard_spends_less(scenario: Make) -> None:
    plan = plan_path(scenario(obstacles=[PILLAR]), strategy=QUICK)
    assert plan.proof.is_proved
    assert plan.evaluations[-1] < 20_000


def test_via_points_are_passed_in_order(scenario: Make) -> None:
    via = [(30, 40, 25), (70, -40, 30)]
    plan = plan_path(scenario(obstacles=[PILLAR, BALL], via=via), strategy=QUICK)
    points = plan.curve.points(np.linspace(0, 1, 40_001))
    away = [np.linalg.norm(points - place, axis=1) for place in via]
    assert max(a.min() for a in away) < 0.01
    assert np.argmin(away[0]) < np.argmin(away[1])
    assert plan.proof.is_proved


def test_a_round_trip_is_a_path_too(scenario: Make) -> None:
    plan = plan_path(scenario(goal=(0, 0, 20), via=[(80, 0, 20)], obstacles=[PILLAR]), strategy=QUICK)
    assert plan.proof.is_proved
    assert 160 < plan.cost.length < 190


def test_limits_are_kept(town: Town) -> None:
    plan = plan_path(town(0), strategy=QUICK)
    limits = {check.limit: check for check in plan.proof.checks}
    assert limits.keys() == {"obstacles", "bounds", "ground", "ceiling", "climb", "descent"}
    assert plan.proof.worst.slack >= -1e-3


def test_the_papers_planner_searches_once_in_absolute_coordinates(scenario: Make) -> None:
    job = scenario(obstacles=[BALL], planning={"planner": "paper"})
    plan = plan_path(job, seed=1)
    assert plan.evaluations[-1] == 90_060
    assert len(plan.curve.control) == 10
    assert plan.proof.is_proved


def test_cost_of_length_only_gives_the_shortest_way(scenario: Make) -> None:
    """Round a mast in the middle: two tangents and an arc."""
    job = scenario(obstacles=[PILLAR | {"north": 0}], cost={"omega": (1, 0, 0)}, vehicle={"radius": 0.5})
    r = 11.5
    assert plan_path(job).curve.length == pytest.approx(2 * np.sqrt(50**2 - r**2) + 2 * r * np.arcsin(r / 50), rel=2e-3)


@pytest.mark.parametrize(
    ("start", "goal", "obstacles", "words"),
    [
        ((0, 0, 20), (100, 0, 20), [TOWER], "goal: nothing can fly there: 10.00 m inside tower at east 100.0"),
        ((100, 0, 20), (0, 0, 20), [TOWER], "start: nothing can fly there: 10.00 m inside tower at east 100.0"),
        ((0, 0, 20), (88, 0, 20), [TOWER | {"height": 15}], None),
        ((0, 0, 20), (89, 0, 20), [TOWER], "goal: nothing can fly there: 1.00 m from tower at east 89.0"),
        ((0, 0, -1), (90, 0, 20), [], "start: nothing can fly there: 1.00 m beyond the lower bound"),
        ((0, 0, 20), (200, 0, 20), [], "goal: nothing can fly there: 50.00 m beyond the east bound"),
        ((0, 0, 20), (100, 0, 20), [fort(120)], "every way is walled off: by fort, at east 74.0"),
    ],
)
def test_a_place_or_a_wall_that_makes_it_impossible_is_named(
    scenario: Make, start: Place, goal: Place, obstacles: list[dict[str, Any]], words: str | None
) -> None:
    job = scenario(start=start, goal=goal, obstacles=obstacles)
    if words is None:
        assert plan_path(job).proof.is_proved
        return
    with pytest.raises(NoPath) as refusal:
        plan_path(job)
    assert str(refusal.value).startswith(words)


def test_a_gap_that_is_too_narrow_is_named_with_its_width(scenario: Make) -> None:
    with pytest.raises(NoPath) as refusal:
        plan_path(scenario(obstacles=gap(2.4)))
    words = str(refusal.value)
    assert words.startswith("no gap is wide enough: the widest is 2.40 m between left wall and right wall at east")
    assert words.endswith("at least 3.00 m required")
    assert "safety_distance" in str(refusal.value.hint)


def test_a_gap_that_is_just_wide_enough_is_flown_through(scenario: Make) -> None:
    plan = plan_path(scenario(obstacles=gap(3.2)))
    assert plan.proof.is_proved
    assert plan.proof.clearance.what in ("left wall", "right wall")


def test_over_the_wall_where_that_is_the_only_way(scenario: Make) -> None:
    plan = plan_path(scenario(obstacles=[fort(60)]), strategy=QUICK)
    assert plan.proof.is_proved
    assert plan.curve.sample(500)[:, 2].max() > 60


@pytest.mark.parametrize("thick", some(1, [7.0, 0.3]))
def test_a_gap_much_narrower_than_the_lattice_is_flown_through(scenario: Make, thick: float) -> None:
    narrow = [wall | {"north": 41.3 + 2 * wall["north"], "width": thick, "depth": 240} for wall in gap(0.22)]
    bounds = {"east": (-50, 150), "north": (-100, 100), "up": (0, 40)}
    plan = plan_path(scenario(obstacles=narrow, bounds=bounds, vehicle={"radius": 0}, safety_distance=0.2))
    assert plan.proof.is_proved
    assert 41 < plan.curve.sample(2000)[:, 1].max() < 43


def test_start_and_goal_in_the_same_place_are_refused(scenario: Make) -> None:
    with refuses("goal-at-start", "goal", kind=BadInput):
        plan_path(scenario(goal=(0, 0, 20)))


def test_an_unknown_optimizer_is_bad_input(scenario: Make) -> None:
    with refuses("unknown-name", "optimizer.name"):
        plan_path(scenario(optimizer={"name": "ipao"}))


def test_settings_of_the_optimizer_are_passed_on(scenario: Make) -> None:
    job = scenario(obstacles=[PILLAR], optimizer={"name": "poa", "population": 5, "iterations": 3})
    first, *_ = np.diff(plan_path(job).evaluations)
    assert first == 5
