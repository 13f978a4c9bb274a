import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import shapely

from ipoa_mission.errors import MissionError
from ipoa_mission.scenario import Scenario
from ipoa_mission.studio.answers import Remedy
from ipoa_mission.studio.area_edits import depth_of
from ipoa_mission.studio.area_view import ring_name
from ipoa_mission.studio.requests import Change, Put, Take
from ipoa_mission.survey.keep_out import SPARE, keep_out, survey_bound
from ipoa_mission.survey.sight import sight_of
from ipoa_mission.world.obstacles import Obstacle

MARGIN = 5.0  # beyond the survey [m]


def survey_remedies(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    if scenario.survey is None or scenario.survey_area is None:
        return
    if error.known.get("limit") == "bounds":
        yield from _within_bounds(scenario)
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
                label = f"{value} flights" if key == "flights" else f"Lines {value:g} m apart"
                yield Remedy(label=label, changes=(Put(path=change.field, value=value),))


def _within_bounds(scenario: Scenario) -> Iterator[Remedy]:
    section, area, bounds = scenario.survey, scenario.survey_area, scenario.bounds
    assert section is not None
    assert area is not None
    corners, height = section.reach(area)
    ground = scenario.airspace.ground(corners)
    (west, south), (east, north) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    needed = {"east": (west, east), "north": (south, north), "up": (float(ground.min()), float(ground.max()) + height)}
    changes = list[Change]()
    for key, (least, most) in needed.items():
        if (given := getattr(bounds, key)) is not None and not given[0] <= least - MARGIN < most + MARGIN <= given[1]:
            wide = [float(min(given[0], math.floor(least - MARGIN))), float(max(given[1], math.ceil(most + MARGIN)))]
            changes.append(Put(path=("bounds", key), value=wide))
    if changes:
        yield Remedy(label="Bounds that hold the survey", changes=tuple(changes))


def _at_height(height: float, words: str, scenario: Scenario) -> Remedy:
    survey = scenario.survey
    takes: tuple[Change, ...] = (Take(path=("survey", "gsd_cm")),) if survey and survey.gsd_cm is not None else ()
    put = Put(path=("survey", "height_above_ground"), value=float(height))
    return Remedy(label=f"{height:g} m above ground{words}", changes=(*takes, put))


def _over(name: object, scenario: Scenario) -> Iterator[Remedy]:
    section, area = scenario.survey, scenario.survey_area
    assert section is not None
    assert area is not None
    sight, air = sight_of(section, area, scenario), scenario.airspace
    in_way = keep_out(scenario, sight, {})
    reach = shapely.Polygon() if in_way is None else in_way.intersection(area.shape)
    bodies = [body for body in air.obstacles if (body.name == name if name else body.plan.intersects(reach))]
    if not bodies:
        return
    height = math.ceil(max(_height_over(body, scenario) for body in bodies))
    ceiling = scenario.planning.max_height_above_ground
    if height > sight.least and (ceiling is None or height * (1 + sight.band / sight.least) < ceiling):
        yield _at_height(height, f", over {name or 'all of it'}", scenario)


def _height_over(body: Obstacle, scenario: Scenario) -> float:
    (west, south, _), (east, north, top) = body.bounds.tolist()
    ground = scenario.airspace.ground(np.array([[west, south], [west, north], [east, south], [east, north]]))
    clearance = float(scenario.limits.obstacle_distance) + survey_bound(scenario).down
    return float(top) - float(ground.min()) + clearance + 2 * SPARE


def area_remedies(error: MissionError, table: Mapping[str, Any]) -> Iterator[Remedy]:
    for change in error.remedies:
        if change.field[:2] == ("survey", "polygon"):
            polygon = table["survey"]["polygon"]
            deep = depth_of(polygon) - len(change.field)
            name = ring_name((*change.field, *([0] * deep)), polygon)
            yield Remedy(label=f"Take {name} out", changes=(Take(path=change.field),))
