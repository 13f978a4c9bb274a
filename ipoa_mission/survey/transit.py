from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import shapely

from ipoa_mission.forecast.clearance_task import clearance_task
from ipoa_mission.forecast.deviation.room import with_room
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.planning.path_problem import PathProblem, problem_of
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.resample import corridor
from ipoa_mission.routing.route import NoRoute, push_clear
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey._kernels import NO_WAY
from ipoa_mission.survey.free import FreeSpace
from ipoa_mission.survey.keep_out import TIGHT_PLACES
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.polygon import union_of

HALVINGS = 5
SAME_PLACE = 0.5  # [m]
MIN_REACH = 60.0  # round the straight way [m]
#: Additional distance [m], segments of a quarter circle, factor; the second: lines near obstacles.
DETOUR_ATTEMPTS = ((0.1, 4, 1.02), (0.01, 16, 1.0013))
MAX_CORNERS = 250


def clear_way(begin: Vector, end: Vector, scenario: Scenario, growth: Mapping[str, float], seed: int) -> Points:
    """Return waypoints (k, 3); `growth` [m] adds clearance by obstacle name. Raises NoPath, NoRoute."""
    straight = np.array([begin, end])
    if np.linalg.norm(end - begin) < SAME_PLACE:
        return straight[1:]
    task = _with_room(straight, scenario, growth)
    if prove(straight, task, spare=0.0).holds:
        return straight
    for apart, corners, wider in DETOUR_ATTEMPTS:
        around = _round(straight, task, wider * (task.limits.obstacle_distance + apart), corners)
        if around is not None and prove(around, task, spare=0.0).holds:
            return around
    curve, width = plan_path(task, seed=seed).curve, scenario.route.tolerance
    for _ in range(HALVINGS):
        points = push_clear(corridor(curve, width), task)
        if (proof := prove(points, task, spare=0.0)).holds:
            return points
        width /= 2
    words = f"the way between home and the survey comes too close: {proof.words()}"
    raise NoRoute(words, code="survey-too-near", known=proof.worst.about)


def _round(straight: Points, task: PathProblem, distance: float, corners: int) -> Points | None:
    """Return the shortest way between two places (2, 3) at `distance` round obstacles; None with over `MAX_CORNERS`."""
    (west, south, *_), (east, north, *_) = task.airspace.bounds.lower, task.airspace.bounds.upper
    line = shapely.LineString(straight[:, :2])
    near, (low, high) = line.buffer(max(line.length / 2, MIN_REACH)), np.sort(straight[:, 2])
    inside = near.intersection(shapely.box(west, south, east, north))
    if (footprint := task.airspace.bounds.footprint) is not None:
        inside = inside.intersection(footprint.shape)
    bodies = [
        body.plan.buffer(distance, quad_segs=corners)
        for body in task.airspace.obstacles
        if body.bounds[0, 2] - distance < high and body.bounds[1, 2] + distance > low and body.plan.intersects(near)
    ]
    free = FreeSpace.of(inside.difference(union_of(bodies)))
    if not 0 < len(free.corners) <= MAX_CORNERS:
        return None
    places = np.vstack([free.corners, straight[:, :2]])
    ways = np.full((len(places), len(places)), np.inf)
    ways[:-2, :-2] = np.where(free.between < NO_WAY, free.between, np.inf)
    seen = free.sees(straight[:, :2], free.corners)
    ways[-2:, :-2] = np.where(seen, np.linalg.norm(straight[:, None, :2] - free.corners, axis=2), np.inf)
    ways[:-2, -2:] = ways[-2:, :-2].T
    passed = _shortest(ways)
    if passed is None:
        return None
    path = np.vstack([straight[:1, :2], places[passed], straight[1:, :2]])
    along = arc_lengths(path)
    return np.column_stack([path, straight[0, 2] + along / along[-1] * (straight[1, 2] - straight[0, 2])])


def _shortest(ways: Points) -> list[int] | None:
    """Return the shortest way from the last node but one to the last, by legs (n, n) (Dijkstra)."""
    count = len(ways)
    length, before, is_open = ways[-2].copy(), np.full(count, count - 2), np.ones(count, bool)
    is_open[-2] = False
    while is_open[-1]:
        here = int(np.where(is_open, length, np.inf).argmin())
        if not (is_open[here] and np.isfinite(length[here])):
            return None
        is_open[here] = False
        shorter = is_open & (length[here] + ways[here] < length)
        length[shorter], before[shorter] = length[here] + ways[here][shorter], here
    found, here = list[int](), int(before[-1])
    while here != count - 2:
        found.insert(0, here)
        here = int(before[here])
    return found


def _with_room(places: Points, scenario: Scenario, growth: Mapping[str, float]) -> PathProblem:
    task = problem_of(with_room(clearance_task(scenario), TIGHT_PLACES))
    bodies = tuple(
        body.grown(growth[body.name], growth[body.name], growth[body.name]) if body.name in growth else body
        for body in task.airspace.obstacles
    )
    air = Airspace(task.airspace.bounds, task.airspace.terrain, bodies)
    return replace(task, airspace=air, places=places)
