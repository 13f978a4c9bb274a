"""OMPL's planners on a scenario, given the seconds of CPU that they are given.

What keeps a state from being valid is what keeps our planner: obstacles, inflated; ground, ceiling and bounds. A leg
is checked in one compiled call, every tenth of a metre, so that Python costs OMPL little. They minimise length, for
inflation is how a margin is asked of them: obstacles are inflated by the distance at which the threat ends, and once
more by the distance that is required; the better counts. Climb limits are none of theirs.
"""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from ompl import base, geometric, util

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning._kernels import survey
from ipoa_mission.planning.cost import FINE, path_cost
from ipoa_mission.planning.problem import pose
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
ROUNDS, SHORTCUTS = 3, 500  # of smoothing, which is not taken off the time allowed
FIRST_SAMPLES = 500  # of FMT*, doubled as long as there is time

util.setLogLevel(util.LogLevel.LOG_NONE)


def best_path(name: str, scenario: Scenario, seconds: float) -> tuple[float, Points] | None:
    """The cheapest safe polyline (n, 3) of all inflations and of all stages of smoothing, with its cost."""
    limits = pose(scenario).limits
    inflations = {scenario.cost.d_safe + scenario.vehicle.radius + 0.01, limits.obstacle_distance + 0.01}
    best = None
    for inflation in inflations:
        for points in _paths(name, scenario, seconds, inflation):
            if prove(points, scenario).holds:
                cost = polyline_cost(points, scenario)
                if best is None or cost < best[0]:
                    best = (cost, points)
    return best


def polyline_cost(points: Points, scenario: Scenario) -> float:
    """The composite cost of a polyline, its corners and all: nodes every few centimetres, as for a curve."""
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(legs)])
    at = np.union1d(travelled, np.linspace(0.0, travelled[-1], int(np.clip(travelled[-1] / FINE, 1000, 8000))))
    nodes = np.column_stack([np.interp(at, travelled, points[:, k]) for k in range(3)])
    return path_cost(nodes, scenario).total


def _paths(name: str, scenario: Scenario, seconds: float, inflation: float) -> Iterator[Points]:
    """What the planner found: as it is, simplified, and smoothed to a spline."""
    space = _space(scenario, inflation)
    deadline = time.process_time() + seconds
    if name == "FMT*":
        samples = FIRST_SAMPLES
        while (left := deadline - time.process_time()) > 0.1 * seconds:
            yield from _solve(_fmt(space, samples), space, scenario, left)
            samples *= 2
    else:
        yield from _solve(PLANNERS[name](space), space, scenario, seconds)


def _fmt(space: Any, samples: int) -> Any:
    planner = geometric.FMT(space)
    planner.setNumSamples(samples)
    return planner


def _solve(planner: Any, space: Any, scenario: Scenario, seconds: float) -> Iterator[Points]:
    problem = base.ProblemDefinition(space)
    problem.setStartAndGoalStates(_state(space, scenario.start_point), _state(space, scenario.goal_point))
    problem.setOptimizationObjective(base.PathLengthOptimizationObjective(space))
    planner.setProblemDefinition(problem)
    planner.setup()
    deadline = time.process_time() + seconds
    planner.solve(base.PlannerTerminationCondition(lambda: time.process_time() > deadline))
    if not problem.hasExactSolution():
        return
    path = problem.getSolutionPath()
    simplifier = geometric.PathSimplifier(space)
    yield _points(path)
    for _ in range(ROUNDS):
        simplifier.simplify(path, 0.1)
        simplifier.partialShortcutPath(path, SHORTCUTS, SHORTCUTS)
        simplifier.reduceVertices(path)
        yield _points(path)
    simplifier.smoothBSpline(path)
    yield _points(path)


def _space(scenario: Scenario, inflation: float) -> Any:
    problem = pose(scenario)
    rules = problem.rules._replace(clearance=inflation)
    lower, upper = scenario.airspace.bounds.lower, scenario.airspace.bounds.upper
    euclidean = base.RealVectorStateSpace(3)
    box = base.RealVectorBounds(3)
    for k in range(3):
        box.setLow(k, lower[k])
        box.setHigh(k, upper[k])
    euclidean.setBounds(box)
    space = base.SpaceInformation(euclidean)

    def is_free(points: Points) -> bool:
        return bool((survey(points, problem.chart, rules)[0] >= 0).all())

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
