"""Buttons for what is wrong with a survey, where it can be put in numbers."""

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import shapely

from ipoa_mission.scenario import Scenario
from ipoa_mission.studio.answers import Remedy
from ipoa_mission.studio.area_edits import depth_of
from ipoa_mission.studio.area_view import ring_name
from ipoa_mission.studio.requests import Change, Put, Take
from ipoa_mission.studio.vocabulary import Path
from ipoa_mission.survey.keep_out import SPARE, keep_out, tube
from ipoa_mission.survey.sight import sight_of
from ipoa_mission.world.obstacles import Obstacle

ROOM = 5.0  # beyond the survey, in bounds that are widened for it [m]
TOO_LOW = re.compile(r"^survey: .* too near to it, at least ([\d.]+) m required")
NOTHING_LEFT = re.compile(r"^survey: obstacles .* leave nothing of the area")
TOO_NEAR = re.compile(
    r"^(?:survey: even at .* flights would come too near"
    r"|the way between home and the survey comes too close: [\d.]+ m from) (.*?) at east "
)
TOO_MANY = re.compile(r"^survey\.flights: expected at most one for each of (\d+) lines")
TOO_WIDE = re.compile(r"^survey\.line_spacing: expected at most what a photo shows, ([\d.]+) m")
TOO_CLOSE = re.compile(r"^survey\.(line_spacing|side_overlap|front_overlap): expected lines and photos")
OUTSIDE = re.compile(r"(?:too near|beyond) the (?:upper|lower|east|west|north|south) bound")
STRAY = re.compile(
    r"survey\.polygon((?:\[\d+\])+): expected (?:a hole inside|no ring inside|no part inside|parts that)"
)


def survey_remedies(message: str, scenario: Scenario) -> Iterator[Remedy]:
    """What may help a survey that was refused; the next plan says whether it does."""
    if scenario.survey is None or scenario.survey_area is None:
        return
    if OUTSIDE.search(message):
        yield from _within_bounds(scenario)
    elif found := TOO_LOW.match(message):
        yield _at_height(math.ceil(float(found[1]) + SPARE), "", scenario)
    elif NOTHING_LEFT.match(message) or (found := TOO_NEAR.match(message)):
        yield from _over(None if found is None else found[1], scenario)
    elif found := TOO_MANY.match(message):
        few = Put(path=("survey", "flights"), value=int(found[1]))
        yield Remedy(label=f"{found[1]} flights", changes=(few,))
        yield Remedy(label="As few flights as can be", changes=(Take(path=("survey", "flights")),))
    elif found := TOO_WIDE.match(message):
        wide = math.floor(float(found[1]) * 10) / 10
        yield Remedy(label=f"Lines {wide:g} m apart", changes=(Put(path=("survey", "line_spacing"), value=wide),))
        yield Remedy(label="By the side overlap", changes=(Take(path=("survey", "line_spacing")),))
    elif (found := TOO_CLOSE.match(message)) and found[1] != "line_spacing":
        words = found[1].replace("_", " ")
        yield Remedy(label=f"The usual {words}", changes=(Take(path=("survey", found[1])),))


def _within_bounds(scenario: Scenario) -> Iterator[Remedy]:
    """Bounds that hold the survey, where those of the file do not."""
    section, area, bounds = scenario.survey, scenario.survey_area, scenario.bounds
    assert section is not None
    assert area is not None
    corners, height = section.reach(area)
    ground = scenario.airspace.ground(corners)
    (west, south), (east, north) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    needed = {"east": (west, east), "north": (south, north), "up": (float(ground.min()), float(ground.max()) + height)}
    changes = list[Change]()
    for key, (least, most) in needed.items():
        if (given := getattr(bounds, key)) is not None and not given[0] <= least - ROOM < most + ROOM <= given[1]:
            wide = [float(min(given[0], math.floor(least - ROOM))), float(max(given[1], math.ceil(most + ROOM)))]
            changes.append(Put(path=("bounds", key), value=wide))
    if changes:
        yield Remedy(label="Bounds that hold the survey", changes=tuple(changes))


def _at_height(height: float, words: str, scenario: Scenario) -> Remedy:
    survey = scenario.survey
    takes: tuple[Change, ...] = (Take(path=("survey", "gsd_cm")),) if survey and survey.gsd_cm is not None else ()
    put = Put(path=("survey", "height_above_ground"), value=float(height))
    return Remedy(label=f"{height:g} m above ground{words}", changes=(*takes, put))


def _over(name: str | None, scenario: Scenario) -> Iterator[Remedy]:
    """So high that what is in the way is flown over: one thing, or all that lies in the area."""
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
    """How high above the lowest ground round it one must fly to pass over something [m]."""
    (west, south, _), (east, north, top) = body.bounds.tolist()
    ground = scenario.airspace.ground(np.array([[west, south], [west, north], [east, south], [east, north]]))
    return float(top) - float(ground.min()) + float(scenario.limits.obstacle_distance) + tube(scenario).down + 2 * SPARE


def area_remedies(message: str, table: Mapping[str, Any]) -> Iterator[Remedy]:
    """For a ring that lies where none may: it is taken out."""
    survey = table.get("survey")
    if not isinstance(survey, Mapping) or not (found := STRAY.search(message)):
        return
    polygon = survey.get("polygon", [])
    numbers = [int(one) for one in re.findall(r"\d+", found[1])][: max(depth_of(polygon) - 2, 0)]
    path: Path = ("survey", "polygon", *numbers)
    if numbers:
        name = ring_name((*path, *([0] * (depth_of(polygon) - 2 - len(numbers)))), polygon)
        yield Remedy(label=f"Take {name} out", changes=(Take(path=path),))
