"""Assemble a tour's mission: lines, transits, camera and gimbal commands."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import shapely

from ipoa_mission import Airspace, Command, Forecast, Frame, MissionError, plan_path
from ipoa_mission.forecast.contingency.shortfalls import clear_in
from ipoa_mission.forecast.deviation.kept_limits import clearance_task, with_margins
from ipoa_mission.geometry import Points, Vector, arc_lengths, union_of
from ipoa_mission.mission.items import Item, Mission, camera_trigger
from ipoa_mission.planning.path_problem import PathProblem, problem_of
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.build import build_mission, items_of_waypoints
from ipoa_mission.routing.resample import NoRoute, Route, corridor, push_clear
from ipoa_mission.survey.free import FreeSpace
from ipoa_mission.survey.sight import lift_path
from ipoa_mission.survey.survey_task import TIGHT_PLACES, SurveyTask
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Tour

SAME_PLACE = 0.5  # [m]


def assemble_survey(tour: Tour, task: SurveyTask, seed: int) -> Mission:
    sight = task.sight
    scenario = task.scenario
    points, corners = lift_path(tour.path, sight, scenario.airspace.ground)
    places = np.array(corners)[tour.numbers]
    out = _clear_transit(scenario.start_point, points[0], task, seed)[:-1]
    back = np.zeros((0, 3))
    if np.linalg.norm(scenario.goal_point - scenario.start_point) > SAME_PLACE:
        back = _clear_transit(points[-1], scenario.goal_point, task, seed)[1:]
    route = Route(np.vstack([out, points, back]))
    mission = build_mission(route, scenario)
    if scenario.route.ending == "rtl" and not clear_in(scenario)(Forecast(mission, scenario).ways_home):
        last_place = back[-1] if len(back) else points[-1]
        home = np.array([0.0, 0.0, scenario.start_point[2]])
        back = np.vstack([back, _clear_transit(last_place, home, task, seed)[1:]])
        route = Route(np.vstack([out, points, back]))
        mission = build_mission(route, scenario)
    numbers = np.array(items_of_waypoints(route)[len(out) :])[places].tolist()
    added = defaultdict[int, list[Item]](list)  # by the index of the item before
    for swath, n in zip(tour.swaths, np.flatnonzero(tour.is_on).tolist(), strict=True):
        start_photos, stop_photos = _camera_items(sight.triggering(swath.length)[0], mission)
        added[numbers[n]] += start_photos
        added[numbers[n + 1]] += stop_photos
    if task.section.gimbal is not None:
        added[0] = _gimbal_items(mission) + added[0]
    items = [each for n, item in enumerate(mission.items) for each in (item, *added[n])]
    return replace(mission, items=tuple(items))


def _gimbal_items(mission: Mission) -> list[Item]:
    _expect_taken(Command.DO_MOUNT_CONTROL, "turns a gimbal", mission, "survey.gimbal")
    pitch_deg = -90.0
    mount_mode = 2.0  # MAV_MOUNT_MODE_MAVLINK_TARGETING
    return [Item(Command.DO_MOUNT_CONTROL, Frame.MISSION, (pitch_deg, 0.0, 0.0, 0.0), altitude=mount_mode)]


def _camera_items(distance: float, mission: Mission) -> tuple[list[Item], list[Item]]:
    if distance == 0.0:
        return [], []
    _expect_taken(Command.DO_SET_CAM_TRIGG_DIST, "triggers a camera by distance", mission, "camera")
    return [camera_trigger(round(distance, 2))], [camera_trigger(0.0, at_once=False)]


def _expect_taken(command: Command, does: str, mission: Mission, place: str) -> None:
    if not mission.firmware.takes(command):
        words = f"{mission.firmware} takes no mission command that {does}"
        raise MissionError(words, code="command-not-taken", place=place)


def _clear_transit(begin: Vector, end: Vector, task: SurveyTask, seed: int) -> Points:
    """Return waypoints (k, 3): straight, else quickest round obstacles, else planned."""
    straight = np.array([begin, end])
    if np.linalg.norm(end - begin) < SAME_PLACE:
        return straight[1:]
    problem = _with_room(straight, task)
    if prove(straight, problem, spare=0.0).is_proved:
        return straight
    for added_distance, corner_segments, factor in ((0.1, 4, 1.02), (0.01, 16, 1.0013)):
        distance = factor * (problem.limits.obstacle_distance + added_distance)
        around = _round_obstacles(problem, distance, corner_segments, task.times)
        if around is not None and prove(around, problem, spare=0.0).is_proved:
            return around
    curve = plan_path(problem, seed=seed).curve
    width = task.scenario.route.tolerance
    for _ in range(5):
        points = push_clear(corridor(curve, width)[0], problem)
        proof = prove(points, problem, spare=0.0)
        if proof.is_proved:
            return points
        width /= 2
    words = f"the way between home and the survey comes too close: {proof.words()}"
    raise NoRoute(words, code="survey-too-near", known=proof.worst.about)


def _round_obstacles(problem: PathProblem, distance: float, corner_segments: int, times: LegTimes) -> Points | None:
    """Return the quickest way between the places at `distance` [m] round obstacles; None with too many corners."""
    straight = problem.places
    bounds = problem.airspace.bounds
    line = shapely.LineString(straight[:, :2])
    min_reach = 60.0  # [m]
    max_corners = 250
    near = line.buffer(max(line.length / 2, min_reach))
    low, high = np.sort(straight[:, 2])
    inside = near.intersection(shapely.box(*bounds.lower[:2], *bounds.upper[:2]))
    if bounds.footprint is not None:
        inside = inside.intersection(bounds.footprint.shape)
    bodies = [
        body.horizontal_shape.buffer(distance, quad_segs=corner_segments)
        for body in problem.airspace.obstacles
        if body.bounds[0, 2] - distance < high
        and body.bounds[1, 2] + distance > low
        and body.horizontal_shape.intersects(near)
    ]
    free = FreeSpace.of(inside.difference(union_of(bodies)))
    if not 0 < len(free.corners) <= max_corners:
        return None
    path = free.way(straight[0, :2], straight[1, :2], times)
    if path is None:
        return None
    along = arc_lengths(path)
    return np.column_stack([path, straight[0, 2] + along / along[-1] * (straight[1, 2] - straight[0, 2])])


def _with_room(places: Points, task: SurveyTask) -> PathProblem:
    problem = problem_of(with_margins(clearance_task(task.scenario), TIGHT_PLACES))
    air = problem.airspace
    grown = {name: (by, by, by) for name, by in task.growth.items()}
    bodies = tuple(body.grown(*grown[body.name]) if body.name in grown else body for body in air.obstacles)
    return replace(problem, airspace=Airspace(air.bounds, air.terrain, bodies), places=places)
