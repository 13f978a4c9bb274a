"""The ways to a survey's first line and home from its last: straight where that is clear, else planned as any path."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ipoa_mission.forecast.tube.room import with_room
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.path_problem import PathProblem, problem_of
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.resample import corridor
from ipoa_mission.routing.route import NoRoute, push_clear
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.keep_out import TIGHT_PLACES
from ipoa_mission.world.airspace import Airspace

HALVINGS = 5  # of the tolerance within which the waypoints stand for the planned curve
SAME = 0.5  # places so near are one [m]


def clear_way(begin: Vector, end: Vector, scenario: Scenario, growth: Mapping[str, float], seed: int) -> Points:
    """Waypoints (k, 3) from one place to another, with room for the tube on all legs between them.

    `growth`: by how much more some obstacles are to be kept away from [m], by name.

    Raises:
        NoPath: no path was found.
        NoRoute: no choice of waypoints on it keeps the limits.
    """
    straight = np.array([begin, end])
    if np.linalg.norm(end - begin) < SAME:
        return straight[1:]
    task = _with_room(straight, scenario, growth)
    if prove(straight, task, spare=0.0).holds:
        return straight
    curve, width = plan_path(task, seed=seed).curve, scenario.route.tolerance
    for _ in range(HALVINGS):
        points = push_clear(corridor(curve, width), task)
        if (proof := prove(points, task, spare=0.0)).holds:
            return points
        width /= 2
    raise NoRoute(f"the way between home and the survey comes too close: {proof.words()}")


def _with_room(places: Points, scenario: Scenario, growth: Mapping[str, float]) -> PathProblem:
    task = problem_of(with_room(scenario, TIGHT_PLACES))
    bodies = tuple(
        body.grown(growth[body.name], growth[body.name], growth[body.name]) if body.name in growth else body
        for body in task.airspace.obstacles
    )
    air = Airspace(task.airspace.bounds, task.airspace.terrain, bodies)
    return replace(task, airspace=air, places=places)
