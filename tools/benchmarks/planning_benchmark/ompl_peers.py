"""OMPL's planners on a scenario, given the seconds of CPU that they are given.

What keeps a state from being valid is what keeps our planner: obstacles, inflated; ground, ceiling and bounds. A leg
is checked in one compiled call, every tenth of a metre, so that Python costs OMPL little. They minimize length, and
inflation is how a margin is asked of them: obstacles are inflated by the distance at which the threat ends, or, where
nothing was found so, by the distance that is required. Climb limits are none of theirs.
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
STEP = 0.1  # between the places at which a leg is looked at [m]
MARGIN = 0.01  # more than required: they look at places, the proof at everything [m]
ROUNDS, SHORTCUTS = 3, 500  # of smoothing, which is not taken off the time allowed
FIRST_SAMPLES = 500  # of FMT*, doubled as long as there is time

util.setLogLevel(util.LogLevel.LOG_NONE)


def best_paths(name: str, scenario: Scenario, seconds: Sequence[float]) -> list[tuple[float, Points] | None]:
    """The cheapest safe polyline (n, 3) with its cost, or None, when each of these times [s of CPU] was spent."""
    problem = prepare(scenario)
    found: list[tuple[float, Points] | None] = []
    for inflation in (problem.rules.d_safe + problem.rules.radius, problem.rules.clearance):
        found = list(_after_each(name, _space(problem, inflation + MARGIN), scenario, seconds))
        if found[-1] is not None:
            break
    return found


def polyline_cost(points: Points, scenario: Scenario) -> float:
    """The composite cost of a polyline, its corners and all: nodes every few centimetres, as for a curve."""
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    traveled = np.concatenate([[0.0], np.cumsum(legs)])
    at = np.union1d(traveled, np.linspace(0.0, traveled[-1], int(np.clip(traveled[-1] / COST_STEP, 1000, 8000))))
    nodes = np.column_stack([np.interp(at, traveled, points[:, k]) for k in range(3)])
    return path_cost(nodes, scenario).total


def _after_each(
    name: str, space: Any, scenario: Scenario, seconds: Sequence[float]
) -> Iterator[tuple[float, Points] | None]:
    """The best so far after each time; an anytime planner goes on where it was, FMT* begins anew with more samples."""
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
    """What a planner found: as it is, shortcut, shortcut more, and smoothed to a spline."""
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
