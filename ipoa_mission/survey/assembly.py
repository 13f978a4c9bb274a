from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ipoa_mission import Command, Frame
from ipoa_mission.checks.airspace_check import clear_in
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Item, Mission, camera_trigger
from ipoa_mission.routing.build import build_mission, items_of_waypoints
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.line_heights import lifted
from ipoa_mission.survey.qgc_item import survey_item
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.tour import Tour
from ipoa_mission.survey.transit import SAME_PLACE, clear_way

PITCH_DOWN_DEG = -90.0
MOUNT_MODE_TARGETING = 2.0  # MAV_MOUNT_MODE_MAVLINK_TARGETING


def assemble_survey(tour: Tour, sight: Sight, scenario: Scenario, growth: Mapping[str, float], seed: int) -> Mission:
    """Return the mission of a tour. Raises NoPath, NoRoute, MissionError, BadInput, Unsafe."""
    path, begins, ends = _path(tour)
    points, corners = lifted(path, sight, scenario.airspace.ground)
    out = clear_way(scenario.start_point, points[0], scenario, growth, seed)[:-1]
    back = np.zeros((0, 3))
    if np.linalg.norm(scenario.goal_point - scenario.start_point) > SAME_PLACE:
        back = clear_way(points[-1], scenario.goal_point, scenario, growth, seed)[1:]
    built = _built(out, points, back, scenario)
    if scenario.route.ending == "rtl" and not clear_in(scenario)(Forecast(built[0], scenario).ways_home):
        here = back[-1] if len(back) else points[-1]
        home = np.array([0.0, 0.0, scenario.start_point[2]])
        built = _built(out, points, np.vstack([back, clear_way(here, home, scenario, growth, seed)[1:]]), scenario)
    mission, numbers = built
    numbers = numbers[len(out) :]
    cameras = [camera_items(sight.triggering(swath.length)[0], mission) for swath in tour.swaths]
    after = [(numbers[corners[at]], 2 * n, cameras[n][0]) for n, at in enumerate(begins)]
    after += [(numbers[corners[at]], 2 * n + 1, cameras[n][1]) for n, at in enumerate(ends)]
    items = [*mission.items]
    for place, _, camera in sorted(after, key=lambda one: one[:2], reverse=True):
        items[place + 1 : place + 1] = camera
    added = sum(len(camera) for *_, camera in after)
    gimbal = gimbal_items(scenario, mission)
    items[1:1] = gimbal
    first = max(numbers[corners[begins[0]]], 2) + len(gimbal)
    last = numbers[corners[ends[-1]]] + added + len(gimbal)
    flown = replace(mission, items=tuple(items))
    if flown.items[first].command != Command.NAV_WAYPOINT:
        return flown
    return replace(flown, complex_items=(survey_item(flown, first, last, tour, sight, scenario),))


def _built(out: Points, points: Points, back: Points, scenario: Scenario) -> tuple[Mission, tuple[int, ...]]:
    route = Route(np.vstack([out, points, back]))
    return build_mission(route, scenario), items_of_waypoints(route)


def _path(tour: Tour) -> tuple[Points, list[int], list[int]]:
    """Return the corners (n, 2), and the indices of line begins and ends."""
    path, begins, ends = list[Points](), list[int](), list[int]()

    def reach(place: Points) -> int:
        if not path or (path[-1] != place).any():
            path.append(place)
        return len(path) - 1

    for n, swath in enumerate(tour.swaths):
        for place in tour.ways[n - 1] if n else ():
            reach(place)
        begins.append(reach(swath.begin))
        ends.append(reach(swath.end))
    return np.array(path), begins, ends


def gimbal_items(scenario: Scenario, mission: Mission) -> list[Item]:
    if scenario.survey is None or scenario.survey.gimbal is None:
        return []
    own = mission.autopilot.firmware(mission.firmware_version)
    if not own.takes(Command.DO_MOUNT_CONTROL):
        words = f"{own} takes no mission command that turns a gimbal"
        raise MissionError(words, code="command-not-taken", place="survey.gimbal")
    angles = PITCH_DOWN_DEG, 0.0, 0.0, 0.0
    return [Item(Command.DO_MOUNT_CONTROL, Frame.MISSION, angles, altitude=MOUNT_MODE_TARGETING)]


def camera_items(distance: float, mission: Mission) -> tuple[list[Item], list[Item]]:
    """Return the items that start photos every `distance` [m], and those that stop them."""
    if distance == 0.0:
        return [], []
    own = mission.autopilot.firmware(mission.firmware_version)
    if own.takes(Command.DO_SET_CAM_TRIGG_DIST):
        return [camera_trigger(round(distance, 2))], [camera_trigger(0.0, at_once=False)]
    if own.takes(Command.IMAGE_START_CAPTURE) and own.takes(Command.IMAGE_STOP_CAPTURE):
        every = round(distance / (mission.cruise_speed or 1.0), 2)
        start = Item(Command.IMAGE_START_CAPTURE, Frame.MISSION, (0.0, every, 0.0, 0.0))
        return [start], [Item(Command.IMAGE_STOP_CAPTURE, Frame.MISSION)]
    words = f"{own} takes no mission command that triggers a camera"
    raise MissionError(words, code="command-not-taken", place="camera")
