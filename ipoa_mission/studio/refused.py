"""A plan that was refused, for the page: short sentences, and a button for each remedy that can be put in numbers."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.scenario import Scenario
from ipoa_mission.studio.answers import Remedy, Trouble
from ipoa_mission.studio.area_view import in_words
from ipoa_mission.studio.requests import Add, Put, Take
from ipoa_mission.studio.survey_remedies import area_remedies, survey_remedies
from ipoa_mission.studio.view import without_folders
from ipoa_mission.studio.vocabulary import as_on_map

ASSIGNMENT = re.compile(r"\b(\w+_height) = (\d+)\b")
PLACE = re.compile(r"^(start|goal|via)(?:\[(\d+)\])?: nothing can fly there")
TRIED = re.compile(r"; (\w+)\.(\w+) = (\S+) plans it")
TRIED_WORDS = {"cruise_speed": "Cruise speed {} m/s", "mode": "Waypoints: {}", "confidence": "Confidence {}"}
RETURNS = re.compile(r"^(\w+) = (-?[\d.]+) makes it clear")
LAND = 'or land: route.ending = "land"'
SPARE = 0.5  # how much more than required a place is put above what is below it [m]


def refused(error: MissionError, scenario: Scenario, revision: int, of: Literal["plan", "sketch"] = "plan") -> Trouble:
    """What the page is told of a plan's refusal, or of a first look's."""
    message = without_folders(str(error), scenario)
    return Trouble(
        of=of,
        message=in_words(message),
        hint=error.hint and in_words(without_folders(error.hint, scenario)),
        revision=revision,
        remedies=(
            *_tried(str(error)),
            *_heights(message, scenario),
            *_higher(str(error), scenario),
            *survey_remedies(str(error), scenario),
            *_ways_home(error.hint or "", scenario),
        ),
    )


def misread(error: MissionError, table: Mapping[str, Any], path: str, revision: int) -> Trouble:
    """What the page is told of a scenario that makes no sense; which file it is, it knows."""
    message = as_on_map(str(error).removeprefix(f"{path}: "))
    remedies = tuple(area_remedies(str(error), table))
    return Trouble(
        of="scenario", message=in_words(message, table), hint=error.hint, revision=revision, remedies=remedies
    )


def _tried(message: str) -> Iterator[Remedy]:
    """The change that the planner has tried, and that plans it."""
    if found := TRIED.search(message):
        section, key, value = found[1], found[2], json.loads(found[3])
        label = TRIED_WORDS.get(key, f"{key}: {{}}").format(value)
        yield Remedy(label=f"{label}, which was tried", changes=(Put(path=(section, key), value=value),))


def _ways_home(hint: str, scenario: Scenario) -> Iterator[Remedy]:
    """For a way home that is not clear: higher, planned as the flight is, or none."""
    if not hint.endswith(LAND) or scenario.survey is not None:  # whose flights end over home as it is
        return
    if found := RETURNS.match(hint):
        change = Put(path=("vehicle", "parameters", found[1]), value=float(found[2]))
        yield Remedy(label=f"{found[1]} = {found[2]}, here and in the vehicle", changes=(change,))
    over_home = Put(path=("goal",), value={"east": 0.0, "north": 0.0, "up": round(float(scenario.goal_point[2]), 1)})
    goal = Add(to="via", table=scenario.goal.model_dump(exclude_none=True))
    yield Remedy(label="Plan the way home too", changes=(goal, over_home))
    yield Remedy(label="Land at the goal", changes=(Put(path=("route", "ending"), value="land"),))


def _heights(message: str, scenario: Scenario) -> Iterator[Remedy]:
    """For what a map has without a height: the heights that its remedy names, each as a button."""
    named = [thing for thing in scenario.passed_over if thing.may_stand and f"{thing.name} on {thing.file}" in message]
    for file, remedy in dict.fromkeys((thing.file, thing.remedy) for thing in named):
        numbers = [n for n, section in enumerate(scenario.maps) if section.file.name == file]
        for key, value in dict.fromkeys(ASSIGNMENT.findall(remedy)):
            what = f"{key.removesuffix('_height')}s of {file}"
            words = f"{what} are {value} m high" if float(value) else f"nothing stands there: no {what}"
            changes = tuple(Put(path=("maps", n, key), value=float(value)) for n in numbers)
            yield Remedy(label=words[0].upper() + words[1:], changes=changes)


def _higher(message: str, scenario: Scenario) -> Iterator[Remedy]:
    """For a place that is too low: above the highest thing there. The next plan says whether that will do."""
    if (found := PLACE.match(message)) is None or scenario.survey is not None:  # which has a height for all places
        return
    name, number = found[1], int(found[2] or 0)
    places = {"start": scenario.start_point, "goal": scenario.goal_point}
    point = np.asarray(scenario.via_points[number] if name == "via" else places[name], float)
    required, airspace = scenario.limits.obstacle_distance, scenario.airspace
    tops = [float(airspace.ground(point[None, :])[0])]
    for body in airspace.obstacles:
        middle = np.append(point[:2], body.bounds[:, 2].mean())
        if float(body.distance(middle[None, :])[0]) < required:
            tops.append(float(body.bounds[1, 2]))
    height = round(max(tops) + required + SPARE, 1)
    if not point[2] < height < airspace.bounds.upper[2]:
        return
    path = (name, number) if name == "via" else (name,)
    section = scenario.via[number] if name == "via" else getattr(scenario, name)
    others = [key for key in ("height_above_ground", "altitude_amsl") if getattr(section, key, None) is not None]
    takes = tuple(Take(path=(*path, key)) for key in others)
    label = f"{name}{f' {number + 1}' if name == 'via' else ''} to {height:g} m above home"
    yield Remedy(label=label[0].upper() + label[1:], changes=(*takes, Put(path=(*path, "up"), value=height)))
