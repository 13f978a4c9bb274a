import json
import math
import os
import re
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from pydantic import ValidationError

from ipoa_mission.autopilot.autopilot import default_autopilot
from ipoa_mission.errors import BadInput, NothingThere, WrongFormat
from ipoa_mission.files import read_text, reading
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.scenario.explain import explained, lowered
from ipoa_mission.scenario.model import Scenario, added_sections


def read_scenario(path: str | Path) -> Scenario:
    """Read a scenario from a TOML file, with all its maps.

    Args:
        path: its name is the default name.

    Returns:
        The scenario.

    Raises:
        BadInput: with file, place and expected value; or a library is missing.

    Example:
        >>> from ipoa_mission import read_scenario
        >>> read_scenario("missions/sitl.toml").name
        'sitl'
    """
    return scenario_of(read_table(Path(path)), Path(path))


def read_table(path: Path) -> dict[str, Any]:
    return parse_toml(read_text(path), path)


def parse_scenario(text: str, path: Path) -> Scenario:
    return scenario_of(parse_toml(text, path), path)


def scenario_of(table: dict[str, Any], path: Path) -> Scenario:
    """Return the scenario; files are relative to `path`."""
    try:
        scenario = Scenario.model_validate({"name": path.stem} | table, context={"folder": str(path.parent)})
    except ValidationError as error:
        raise explained(error, table, Scenario, f"{path}: ") from error
    try:
        return scenario.with_files_read()
    except BadInput as error:
        if re.split(r"[.:\[ ]", str(error), maxsplit=1)[0] not in Scenario.model_fields | added_sections():
            raise
        raise error.at(path) from error


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    with reading(path):
        try:
            return tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            at = re.search(r"at line (\d+)", str(error))
            decimal_comma = r"=\s*([-+]?\d+),(\d+)\s*(?:#.*)?$"
            if at is not None and (comma := re.search(decimal_comma, text.split("\n")[int(at[1]) - 1].rstrip())):
                words = f"expected a number with a point, {comma[1]}.{comma[2]}, not {comma[1]},{comma[2]}"
                raise WrongFormat(words, place=f"{path}: line {at[1]}") from error
            raise WrongFormat(f"{lowered(str(error))}", hint="a scenario is a TOML file", place=path) from error


FREE_RADIUS = 12.0  # [m]


class NewScenario(NamedTuple):
    text: str
    remarks: tuple[str, ...]


def new_scenario(
    target: Path,
    home: tuple[float, float, float] | None = None,
    buildings: Path | None = None,
    elevation: Path | None = None,
) -> NewScenario:
    """Return a scenario file with paths relative to `target`.

    `home`: latitude, longitude [deg], altitude [m]; default: a free place among the buildings.
    """
    places: tuple[tuple[float, float], ...] = () if buildings is None else _free_places(buildings)
    if home is None and not places:
        raise BadInput("expected --home LAT LON ALT, or --buildings FILE", code="missing", place=target)
    latitude, longitude = home[:2] if home is not None else places[0]
    goal = max(places, key=lambda place: math.dist(place, (latitude, longitude)), default=None)
    remarks = [] if goal else ["the goal is 100 m north of home: correct it"]
    if home is not None:
        altitude = home[2]
    elif elevation is not None:
        from ipoa_mission.maps.elevation import ground_altitude  # slow import

        altitude = round(ground_altitude(elevation, latitude, longitude), 1)
    else:
        altitude = 0.0
        remarks.append("home.altitude_amsl is 0 m: correct it, or give --elevation FILE or --home LAT LON ALT")
    template = files("ipoa_mission.scenario").joinpath("new.toml.template").read_text(encoding="utf-8")
    parts = dict(re.findall(r"^%% (\w+)\n(.*?)(?=^%%|\Z)", template, re.MULTILINE | re.DOTALL))
    text = (
        parts["template"]
        .rstrip()
        .format(
            home=(latitude, longitude, altitude),
            goal=goal or (round(latitude + 0.0009, 7), longitude),  # about 100 m
            autopilot=default_autopilot(),
            terrain=parts["flat"] if elevation is None else parts["elevation"].format(_quoted(elevation, target)),
            maps=parts["no_maps"] if buildings is None else parts["buildings"].format(_quoted(buildings, target)),
        )
    )
    parse_scenario(text, target)
    return NewScenario(text, tuple(remarks))


def _free_places(path: Path) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return places south-west and north-east, at most 200 m from the middle [deg]."""
    frame = LocalFrame(_middle(path))
    farthest = 200.0
    within = np.full(2, -farthest - 2 * FREE_RADIUS), np.full(2, farthest + 2 * FREE_RADIUS)
    buildings = search_buildings(path, BuildingRules(), frame, within)
    if not buildings.obstacles:
        buildings = search_buildings(path, BuildingRules(take="all"), frame, within)
    if not buildings.obstacles:
        raise NothingThere(f"expected buildings, but none of {buildings.features} features is an obstacle", place=path)
    shapes = [s.shape.buffer(s.reach) if s.reach else s.shape for s in buildings.obstacles]
    reach = np.minimum(np.ptp(shapely.total_bounds(shapes).reshape(2, 2), axis=0) / 2 + 2 * FREE_RADIUS, farthest)
    obstacles = (thing for thing in buildings.passed_over if thing.may_be_obstacle)
    shapes += [thing.shape for thing in obstacles if not shapely.is_empty(thing.shape)]
    places = np.stack(np.meshgrid(*(np.arange(-side, side + 4.0, 4.0) for side in reach)), axis=-1).reshape(-1, 2)
    near = shapely.STRtree(shapes).query(shapely.points(places), "dwithin", FREE_RADIUS)[0]
    free = np.delete(places, np.unique(near), axis=0)
    if len(free) < 2:
        raise BadInput(f"expected {FREE_RADIUS:g} m of free room for a take-off among the buildings", place=path)
    ends = [free[np.argmin(np.linalg.norm(free - corner, axis=1))] for corner in (-0.8 * reach, 0.8 * reach)]
    start, goal = np.round(frame.to_geodetic(np.column_stack([ends, np.zeros(2)]))[:2], 7).T.tolist()
    return tuple(start), tuple(goal)


def _middle(path: Path) -> Geodetic:
    features = read_features(path)
    if not features:
        raise NothingThere("expected buildings, but it has no features", place=path)
    west, south, east, north = shapely.total_bounds([feature.shape for feature in features]).tolist()
    return Geodetic((south + north) / 2, (west + east) / 2)


def _quoted(path: Path, target: Path) -> str:
    return json.dumps(Path(os.path.relpath(path, target.parent)).as_posix(), ensure_ascii=False)
