from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.scenario import Scenario
from ipoa_mission.studio.answers import Remedy, Trouble
from ipoa_mission.studio.area_view import in_words
from ipoa_mission.studio.requests import Add, Put, Take
from ipoa_mission.studio.survey_remedies import area_remedies, survey_remedies
from ipoa_mission.studio.view import fences_drawn, without_folders
from ipoa_mission.studio.vocabulary import as_on_map

TRIED: Mapping[tuple[str | int, ...], str] = {
    ("vehicle", "cruise_speed"): "Cruise speed {:g} m/s (tried)",
    ("route", "mode"): "Waypoints: {} (tried)",
    ("safety", "confidence"): "Confidence {:g} (tried)",
}
HEIGHT_MARGIN = 0.5  # [m]


def refused(error: MissionError, scenario: Scenario, revision: int, of: Literal["plan", "sketch"] = "plan") -> Trouble:
    return Trouble(
        of=of,
        message=in_words(without_folders(str(error), scenario)),
        of_home=_is_of_home(error),
        hint=error.hint and in_words(without_folders(error.hint, scenario)),
        revision=revision,
        remedies=(
            *_tried(error),
            *_unread(error, scenario),
            *_heights(error, scenario),
            *_higher(error, scenario),
            *survey_remedies(error, scenario),
            *_ways_home(error, scenario),
        ),
    )


def misread(error: MissionError, table: Mapping[str, Any], path: str, revision: int) -> Trouble:
    """Return the message on an invalid scenario, without the file's name."""
    message = as_on_map(str(error).removeprefix(f"{path}: "))
    remedies = tuple(area_remedies(error, table))
    return Trouble(
        of="scenario",
        message=in_words(message, table),
        of_home=_is_of_home(error, f"{path}: "),
        hint=error.hint,
        revision=revision,
        remedies=remedies,
        fences=tuple(fences_drawn(table)),
    )


def _is_of_home(error: MissionError, file: str = "") -> bool:
    codes = error.known.get("codes", [error.code])
    of_home = isinstance(codes, list) and any(code.startswith("home-") for code in codes)
    return of_home or (error.place or "").removeprefix(file).startswith("home")


def _tried(error: MissionError) -> Iterator[Remedy]:
    for change in error.remedies:
        if (label := TRIED.get(change.field)) is not None:
            yield Remedy(label=label.format(change.value), changes=(Put(path=change.field, value=change.value),))


def _unread(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    """Yield a remedy for unread contents: the user states that they limit no flight."""
    codes = error.known.get("codes")
    if isinstance(codes, list) and "not-read" in codes:
        put = Put(path=("safety", "ignore"), value=[*scenario.safety.ignore, "not-read"])
        yield Remedy(label="Ignore what was not read", changes=(put,))


def _ways_home(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    changes = {change.field: change.value for change in error.remedies}
    if ("route", "ending") not in changes or scenario.survey is not None:  # they end over home as given
        return
    for field, value in changes.items():
        if field[:2] == ("vehicle", "parameters"):
            label = f"{field[2]} = {value:g}, here and in the vehicle"
            yield Remedy(label=label, changes=(Put(path=field, value=value),))
    over_home = Put(path=("goal",), value={"east": 0.0, "north": 0.0, "up": round(float(scenario.goal_point[2]), 1)})
    goal = Add(to="via", table=scenario.goal.model_dump(exclude_none=True))
    yield Remedy(label="Plan the way home too", changes=(goal, over_home))
    yield Remedy(label="Land at the goal", changes=(Put(path=("route", "ending"), value="land"),))


def _heights(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    found = dict[tuple[str, str, float], list[Put]]()
    for change in error.remedies:
        match change.field:
            case ("maps", int(n), str(key)):
                put = Put(path=change.field, value=change.value)
                found.setdefault((scenario.maps[n].file.name, key, change.value), []).append(put)
    for (file, key, value), changes in found.items():
        what = f"{key.removesuffix('_height')}s of {file}"
        words = f"{what} are {value:g} m high" if value else f"no obstacle there: no {what}"
        yield Remedy(label=words[0].upper() + words[1:], changes=tuple(changes))


def _higher(error: MissionError, scenario: Scenario) -> Iterator[Remedy]:
    points = {"start": scenario.start_point, "goal": scenario.goal_point}
    points |= {f"via[{n}]": point for n, point in enumerate(scenario.via_points)}
    if error.code != "place-blocked" or error.place not in points or scenario.survey is not None:
        return
    name, number = error.place.partition("[")[0], list(points).index(error.place) - 2
    point = np.asarray(points[error.place], float)
    required, airspace = scenario.limits.obstacle_distance, scenario.airspace
    tops = [float(airspace.ground(point[None, :])[0])]
    for body in airspace.obstacles:
        middle = np.append(point[:2], body.bounds[:, 2].mean())
        if float(body.distance(middle[None, :])[0]) < required:
            tops.append(float(body.bounds[1, 2]))
    height = round(max(tops) + required + HEIGHT_MARGIN, 1)
    if not point[2] < height < airspace.bounds.upper[2]:
        return
    path = (name, number) if name == "via" else (name,)
    section = scenario.via[number] if name == "via" else getattr(scenario, name)
    others = [key for key in ("height_above_ground", "altitude_amsl") if getattr(section, key, None) is not None]
    takes = tuple(Take(path=(*path, key)) for key in others)
    label = f"{name}{f' {number + 1}' if name == 'via' else ''} to {height:g} m above home"
    yield Remedy(label=label[0].upper() + label[1:], changes=(*takes, Put(path=(*path, "up"), value=height)))
