from dataclasses import replace

import numpy as np

from ipoa_mission.planning.planner import perturbed
from ipoa_mission.planning.problem import Candidate, follow, prepare
from ipoa_mission.planning.spline import Spline
from ipoa_mission.planning.strategy import USUAL
from tests.planning.conftest import Make


def test_only_a_long_curve_that_is_not_the_best_becomes_another(scenario: Make) -> None:
    job = scenario(obstacles=[])
    problem, best = prepare(job), follow(job.places, 70, job)  # straight, with nothing in its way
    assert not list(perturbed(best, problem, USUAL))
    control = best.curve.control.copy()
    control[30:40, 1] += np.sin(np.pi * (np.arange(10) + 0.5) / 10)
    worse = Candidate(Spline(control), best.via_at)
    (mended,) = perturbed(worse, problem, USUAL)
    costs = [problem.cost(candidate) for candidate in (best, mended, worse)]
    assert costs[2] > 1.02 * costs[0]
    assert costs[1] - costs[0] < 0.5 * (costs[2] - costs[0])
    np.testing.assert_array_equal(mended.curve.control[[0, -1]], control[[0, -1]])
    assert not list(perturbed(worse, problem, replace(USUAL, perturbed_control_points=80)))


def test_a_curve_through_via_points_is_left_alone(scenario: Make) -> None:
    job = scenario(obstacles=[], via=[(50, 30, 25)])
    assert not list(perturbed(follow(job.places, 70, job), prepare(job), USUAL))
