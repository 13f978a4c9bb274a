"""Run OMPL's planners on a scenario within given CPU seconds.

States are invalid by our planner's conditions: inflated obstacles, ground, ceiling and bounds. One compiled call checks
a leg every tenth of a meter, so Python costs OMPL little. The planners minimize length. Their margin comes from
inflation: obstacles grow by the distance at which the threat ends, or without a result by the required distance.
They have no climb limits.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from ompl import base, geometric, util

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.cost import COST_STEP, path_cost
from ipoa_mission.planning.problem import PreparedProblem, prepare
from ipoa_mission.planning.proof import prove
from ipoa_mission.scenario import Scenario

PLANNERS = {
    "RRT*": geometric.RRTstar,
    "Informed RRT*": geometric.InformedRRTstar,
    "BIT*": geometric.BITstar,
    "AORRTC": geometric.AORRTC,
    "FMT*": geometric.FMT,
}
STEP = 0.1  # between checked places of a leg [m]
MARGIN = 0.01  # above the requirement: they check places, the proof checks the whole path [m]
ROUNDS, SHORTCUTS = 3, 500  # of smoothing, in addition to the time allowed
FIRST_SAMPLES = 500  # of FMT*, doubled while time is left

util.setLogLevel(util.LogLevel.LOG_NONE)


def best_paths(name: str, scenario: Scenario, seconds: Sequence[float]) -> list[tuple[float, Points] | None]:
    """Return the cheapest safe polyline (n, 3) with its cost, or None, after each of the times [s of CPU]."""
    problem = prepare(scenario)
    found: list[tuple[float, Points] | None] = []
    for inflation in (problem.rules.d_safe + problem.rules.radius, problem.rules.clearance):
        found = list(_after_each(name, _space(problem, inflation + MARGIN), scenario, seconds))
        if found[-1] is not None:
            break
    return found


def polyline_cost(points: Points, scenario: Scenario) -> float:
    """Return the composite cost of a polyline with its corners: nodes every few centimeters, as for a curve."""
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    traveled = np.concatenate([[0.0], np.cumsum(legs)])
    at = np.union1d(traveled, np.linspace(0.0, traveled[-1], int(np.clip(traveled[-1] / COST_STEP, 1000, 8000))))
    nodes = np.column_stack([np.interp(at, traveled, points[:, k]) for k in range(3)])
    return path_cost(nodes, scenario).total


def _after_each(
    name: str, space: Any, scenario: Scenario, seconds: Sequence[float]
) -> Iterator[tuple[float, Points] | None]:
    """Yield the best result after each time; anytime planners continue, FMT* restarts with more samples."""
    planner, samples, best = _ready(PLANNERS[name](space), space, scenario), FIRST_SAMPLES, None
    for spent, until in zip((0.0, *seconds), seconds, strict=False):
        deadline = time.process_time() + until - spent
        while time.process_time() < deadline - 0.05 * until:
            if name == "FMT*":
                planner = _ready(_fmt(space, samples), space, scenario)
                samples *= 2
            planner.solve(base.PlannerTerminationCondition(lambda end=deadline: time.process_time() > end))
            left = deadline - time.process_time()
            for points in _smoothed(planner.getProblemDefinition(), space):
                if prove(points, scenario).holds and (best is None or polyline_cost(points, scenario) < best[0]):
                    best = (polyline_cost(points, scenario), points)
            deadline = time.process_time() + left
        yield best


def _fmt(space: Any, samples: int) -> Any:
    planner = geometric.FMT(space)
    planner.setNumSamples(samples)
    return planner


def _ready(planner: Any, space: Any, scenario: Scenario) -> Any:
    problem = base.ProblemDefinition(space)
    problem.setStartAndGoalStates(_state(space, scenario.start_point), _state(space, scenario.goal_point))
    problem.setOptimizationObjective(base.PathLengthOptimizationObjective(space))
    planner.setProblemDefinition(problem)
    planner.setup()
    return planner


def _smoothed(problem: Any, space: Any) -> Iterator[Points]:
    """Yield a planner's path as found, shortcut, shortcut more, and smoothed to a spline."""
    if not problem.hasExactSolution():
        return
    path = geometric.PathGeometric(problem.getSolutionPath())
    simplifier = geometric.PathSimplifier(space)
    yield _points(path)
    for _ in range(ROUNDS):
        simplifier.simplify(path, 0.1)
        simplifier.partialShortcutPath(path, SHORTCUTS, SHORTCUTS)
        simplifier.reduceVertices(path)
        yield _points(path)
    simplifier.smoothBSpline(path)
    yield _points(path)


def _space(problem: PreparedProblem, inflation: float) -> Any:
    inflated = replace(problem, rules=problem.rules._replace(clearance=inflation))
    euclidean = base.RealVectorStateSpace(3)
    box = base.RealVectorBounds(3)
    for k in range(3):
        box.setLow(k, float(problem.grid.lower[k]))
        box.setHigh(k, float(problem.grid.upper[k]))
    euclidean.setBounds(box)
    space = base.SpaceInformation(euclidean)

    def is_free(points: Points) -> bool:
        return bool((inflated.survey(points)[0] >= 0).all())

    class Legs(base.MotionValidator):
        def checkMotion(self, a: Any, b: Any) -> bool:  # noqa: N802
            start, end = np.array([a[0], a[1], a[2]]), np.array([b[0], b[1], b[2]])
            count = int(np.ceil(np.linalg.norm(end - start) / STEP)) + 1
            return is_free(start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start))

    space.setStateValidityChecker(lambda state: is_free(np.array([[state[0], state[1], state[2]]])))
    space.setMotionValidator(Legs(space))
    space.setup()
    return space


def _state(space: Any, point: Vector) -> Any:
    state = space.allocState()
    for k in range(3):
        state[k] = float(point[k])
    return state


def _points(path: Any) -> Points:
    return np.array([[state[0], state[1], state[2]] for state in path.getStates()])
