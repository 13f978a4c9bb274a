"""Messages on errors, with changes of the scenario that the page offers."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np
import shapely

from ipoa_mission import MissionError, Scenario
from ipoa_mission.geometry import Points
from ipoa_mission.studio.answers import Remedy, Trouble
from ipoa_mission.studio.requests import Add, Change, Put, Take
from ipoa_mission.studio.survey_view import in_words, numbers_in_full, ring_name
from ipoa_mission.studio.view import fences_drawn, without_folders
from ipoa_mission.studio.vocabulary import as_on_map
from ipoa_mission.survey.survey_area import parts_of
from ipoa_mission.survey.survey_section import survey_of
from ipoa_mission.survey.survey_task import SPARE, SurveyTask, survey_bound


def plan_trouble(error: MissionError, scenario: Scenario, of: Literal["plan", "sketch"] = "plan") -> Trouble:
    if survey_of(scenario) is None:
        of_kind = (*_higher(error, scenario), *_return_remedies(error, scenario))
    else:
        of_kind = tuple(_survey_remedies(error, scenario))
    return Trouble(
        of=of,
        message=in_words(without_folders(str(error), scenario)),
        of_home=_is_of_home(error),
        hint=error.hint and in_words(without_folders(error.hint, scenario)),
        remedies=(*_tried(error), *_unread(error, scenario), *_map_heights(error, scenario), *of_kind),
    )


def text_trouble(error: MissionError, table: Mapping[str, Any], path: str) -> Trouble:
    return Trouble(
        of="scenario",
        message=in_words(as_on_map(str(error).removeprefix(f"{path}: ")), table),
        of_home=_is_of_home(error, f"{path}: "),
        hint=error.hint,
        remedies=tuple(_without_rings(error, table)),
        fences=tuple(fences_drawn(table)),
    )


def _is_of_home(error: MissionError, file: str = "") -> bool:
    codes = error.known.get("codes", [error.code])
    of_home = isinstance(codes, list) and any(code.startswith("home-") for code in codes)
    return of_home or (error.place or "").removeprefix(file).startswith("home")


def _put(label: str, field: tuple[str | int, ...], value: Any) -> Remedy:
    return Remedy(label=label, changes=(Put(path=field, value=value),))


def _tried(error: MissionError) -> Iterator[Remedy]:
    labels: Mapping[tuple[str | int, ...], str] = {
        ("vehicle", "cruise_speed"): "Cruise speed {:g} m/s (tried)",
        ("route", "mode"): "Waypoints: {} (tried)",
        ("safety", "confidence"): "Confidence {:g} (tried)",
    }
    for change in error.remedies:
        if change.field in labels:
            yield _put(labels[change.field].format(change.value), change.field, change.value)


def _unread(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    codes = error.known.get("codes")
    if isinstance(codes, list) and "not-read" in codes:
        yield _put("Ignore what was not read", ("safety", "ignore"), [*scenario.safety.ignore, "not-read"])


def _map_heights(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    puts = dict[tuple[str, str, float], list[Put]]()
    for change in error.remedies:
        match change.field:
            case ("maps", int(n), str(key)):
                put = Put(path=change.field, value=change.value)
                puts.setdefault((scenario.maps[n].file.name, key, change.value), []).append(put)
    for (file, key, value), changes in puts.items():
        things = f"{key.removesuffix('_height')}s of {file}"
        words = f"{things} are {value:g} m high" if value else f"no obstacle there: no {things}"
        yield Remedy(label=words[0].upper() + words[1:], changes=tuple(changes))


def _higher(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    points = {"start": scenario.start_point, "goal": scenario.goal_point}
    points |= {f"via[{n}]": point for n, point in enumerate(scenario.via_points)}
    if error.code != "place-blocked" or error.place not in points:
        return
    name = error.place.partition("[")[0]
    number = list(points).index(error.place) - 2
    point = np.asarray(points[error.place], float)
    airspace = scenario.airspace
    required = scenario.limits.obstacle_distance
    tops = [float(airspace.ground(point[None, :])[0])]
    for body in airspace.obstacles:
        middle = np.append(point[:2], body.bounds[:, 2].mean())
        if float(body.distance(middle[None, :])[0]) < required:
            tops.append(float(body.bounds[1, 2]))
    margin = 0.5  # [m]
    height = round(max(tops) + required + margin, 1)
    if not point[2] < height < airspace.bounds.upper[2]:
        return
    path = (name, number) if name == "via" else (name,)
    section = scenario.via[number] if name == "via" else getattr(scenario, name)
    heights = [key for key in ("height_above_ground", "altitude_amsl") if getattr(section, key, None) is not None]
    takes = tuple(Take(path=(*path, key)) for key in heights)
    label = f"{name}{f' {number + 1}' if name == 'via' else ''} to {height:g} m above home"
    yield Remedy(label=label[0].upper() + label[1:], changes=(*takes, Put(path=(*path, "up"), value=height)))


def _return_remedies(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    changes = {change.field: change.value for change in error.remedies}
    if ("route", "ending") not in changes:
        return
    for field, value in changes.items():
        if field[:2] == ("vehicle", "parameters"):
            yield _put(f"{field[2]} = {value:g}, here and in the vehicle", field, value)
    over_home = Put(path=("goal",), value={"east": 0.0, "north": 0.0, "up": round(float(scenario.goal_point[2]), 1)})
    goal = Add(to="via", table=scenario.goal.model_dump(exclude_none=True))
    yield Remedy(label="Plan the way home too", changes=(goal, over_home))
    yield _put("Land at the goal", ("route", "ending"), "land")


def _survey_remedies(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    if error.known.get("limit") == "bounds":
        yield from _wider_bounds(scenario)
    elif error.code in ("area-covered", "survey-too-near"):
        yield from _over(error.known.get("near"), scenario)
    for change in error.remedies:
        match change.field, change.value:
            case ("survey", "height_above_ground"), height:
                yield _at_height(height, "", scenario)
            case ("survey", str(key)), None:
                words = {"flights": "As few flights as can be", "line_spacing": "By the side overlap"}
                label = words.get(key, f"The usual {key.replace('_', ' ')}")
                yield Remedy(label=label, changes=(Take(path=change.field),))
            case ("survey", str(key)), value:
                yield _put(f"{value} flights" if key == "flights" else f"Lines {value:g} m apart", change.field, value)


def _wider_bounds(scenario: Scenario) -> Iterator[Remedy]:
    corners, height = scenario.added_reach
    ground = scenario.airspace.ground(corners)
    west, south = corners.min(axis=0).tolist()
    east, north = corners.max(axis=0).tolist()
    needed = {"east": (west, east), "north": (south, north), "up": (float(ground.min()), float(ground.max()) + height)}
    changes: list[Change] = []
    margin = 5.0  # beyond the survey [m]
    for key, (least, most) in needed.items():
        sides = getattr(scenario.bounds, key)
        if sides is not None and not sides[0] <= least - margin < most + margin <= sides[1]:
            wide = [float(min(sides[0], math.floor(least - margin))), float(max(sides[1], math.ceil(most + margin)))]
            changes.append(Put(path=("bounds", key), value=wide))
    if changes:
        yield Remedy(label="Bounds that hold the survey", changes=tuple(changes))


def _at_height(height: float, words: str, scenario: Scenario) -> Remedy:
    survey = survey_of(scenario)
    takes: tuple[Change, ...] = (Take(path=("survey", "gsd_cm")),) if survey and survey.gsd_cm is not None else ()
    put = Put(path=("survey", "height_above_ground"), value=float(height))
    return Remedy(label=f"{height:g} m above ground{words}", changes=(*takes, put))


def _over(name: object, scenario: Scenario) -> Iterator[Remedy]:
    task = SurveyTask(scenario, {})
    sight = task.sight
    covered = shapely.Polygon() if task.keep_out is None else task.keep_out.intersection(task.area.shape)
    obstacles = scenario.airspace.obstacles
    bodies = [body for body in obstacles if (body.name == name if name else body.horizontal_shape.intersects(covered))]
    if not bodies:
        return
    height = math.ceil(max(_height_over(body.bounds, scenario) for body in bodies))
    ceiling = scenario.planning.max_height_above_ground
    if height > sight.least and (ceiling is None or height * (1 + sight.band / sight.least) < ceiling):
        yield _at_height(height, f", over {name or 'all of it'}", scenario)


def _height_over(box: Points, scenario: Scenario) -> float:
    (west, south, _), (east, north, top) = box.tolist()
    ground = scenario.airspace.ground(np.array([[west, south], [west, north], [east, south], [east, north]]))
    clearance = float(scenario.limits.obstacle_distance) + survey_bound(scenario).down
    return float(top) - float(ground.min()) + clearance + 2 * SPARE


def _without_rings(error: MissionError, table: Mapping[str, Any]) -> Iterator[Remedy]:
    for change in error.remedies:
        if change.field[:2] == ("survey", "polygon"):
            polygon = table["survey"]["polygon"]
            numbers = numbers_in_full([int(step) for step in change.field[2:]], polygon)
            area, ring = (*numbers, 0)[:2]
            take = Take(path=("survey", "polygon", area, ring))
            yield Remedy(label=f"Take {ring_name(area, ring, len(parts_of(polygon)))} out", changes=(take,))
