"""Messages on errors, with changes of the scenario that the page offers."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Literal

from ipoa_mission import MissionError, Scenario
from ipoa_mission.studio.answers import Remedy, Trouble
from ipoa_mission.studio.requests import Add, Change, Put, Take
from ipoa_mission.studio.survey_view import in_words, numbers_in_full, ring_name
from ipoa_mission.studio.view import fences_drawn, without_folders
from ipoa_mission.studio.vocabulary import as_on_map
from ipoa_mission.survey.survey_area import parts_of
from ipoa_mission.survey.survey_section import survey_of


def plan_trouble(error: MissionError, scenario: Scenario, of: Literal["plan", "sketch"] = "plan") -> Trouble:
    if survey_of(scenario) is None:
        of_kind = tuple(_return_remedies(error, scenario))
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
    for change in error.remedies:
        match change.field, change.value:
            case ("survey", "height_above_ground"), height:
                survey = survey_of(scenario)
                has_resolution = survey is not None and survey.gsd_cm is not None
                takes = (Take(path=("survey", "gsd_cm")),) if has_resolution else ()
                put = Put(path=change.field, value=float(height))
                yield Remedy(label=f"{height:g} m above ground", changes=(*takes, put))
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


def _without_rings(error: MissionError, table: Mapping[str, Any]) -> Iterator[Remedy]:
    for change in error.remedies:
        if change.field[:2] == ("survey", "polygon"):
            polygon = table["survey"]["polygon"]
            numbers = numbers_in_full([int(step) for step in change.field[2:]], polygon)
            area, ring = (*numbers, 0)[:2]
            take = Take(path=("survey", "polygon", area, ring))
            yield Remedy(label=f"Take {ring_name(area, ring, len(parts_of(polygon)))} out", changes=(take,))
