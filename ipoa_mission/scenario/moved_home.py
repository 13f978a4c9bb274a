"""Move a scenario's tables to another home."""

import math
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias, TypeVar

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Plane
from ipoa_mission.scenario.map_sections import NoFlyMap
from ipoa_mission.scenario.place_sections import (
    BoundsSection,
    FlatTerrain,
    GridTerrain,
    HomeSection,
    Horizontal,
    Place,
    TerrainSection,
)
from ipoa_mission.scenario.section import Section
from ipoa_mission.scenario.surroundings import Site
from ipoa_mission.scenario.survey_section import SurveySection
from ipoa_mission.world.terrain import Grid

Moved = TypeVar("Moved", bound=Section)
Ring: TypeAlias = tuple[tuple[float, float], ...]
Move: TypeAlias = Callable[[Plane], Plane]  # of places


def move_between(old: LocalFrame, new: LocalFrame) -> Move:
    def moved(places: Plane) -> Plane:
        if old.home == new.home:
            return places
        latitude, longitude, _ = old.to_geodetic(np.column_stack([places, np.zeros(len(places))]))
        return new.to_local(latitude, longitude, new.home.altitude)[:, :2]

    return moved


def sections_from(scenario: Site, section: SurveySection, n: int) -> dict[str, Any]:
    old = scenario.frame
    place = np.array(section.start_places[n])
    there = old.geodetic(np.append(place, float(scenario.airspace.terrain.height(place[None])[0])))
    home = HomeSection(
        latitude_deg=round(there.latitude_deg, 7),
        longitude_deg=round(there.longitude_deg, 7),
        altitude_amsl=round(there.altitude, 3),
    )
    new = LocalFrame(home.geodetic())
    rise = home.altitude_amsl - old.home.altitude
    start = Place(east=0.0, north=0.0, height_above_ground=section.height)
    survey = {key: _move_nested(getattr(section, key), move_between(old, new)) for key in ("polygon", "line", "starts")}
    return {
        "home": home,
        "start": start,
        "goal": start,
        "via": (),
        "bounds": _bounds(scenario, new, rise),
        "terrain": _terrain(scenario, new, rise, n),
        "obstacles": tuple(_move_section(obstacle, old, new) for obstacle in scenario.obstacles),
        "maps": tuple(_raise_zones(zones, -rise) if isinstance(zones, NoFlyMap) else zones for zones in scenario.maps),
        "fence": tuple(_move_section(fence, old, new) for fence in scenario.fence),
        "rally": tuple(_move_section(place, old, new) for place in scenario.rally),
        "survey": section.model_copy(update=survey),
    }


def _bounds(scenario: Site, new: LocalFrame, rise: float) -> BoundsSection:
    bounds = scenario.airspace.bounds
    east, north, _ = new.local(scenario.frame.home)
    (west, far_east), (south, far_north), (low, high) = zip(bounds.lower, bounds.upper, strict=True)
    return BoundsSection(
        east=(west + east, far_east + east),
        north=(south + north, far_north + north),
        up=(low - rise, high - rise),
        margin=scenario.bounds.margin,
    )


def _terrain(scenario: Site, new: LocalFrame, rise: float, n: int) -> TerrainSection:
    section = scenario.terrain
    terrain = scenario.airspace.terrain
    if isinstance(section, FlatTerrain):
        return section.model_copy(update={"height": section.height - rise})
    if isinstance(section, GridTerrain) and isinstance(terrain, Grid):
        rows, columns = terrain.heights.shape
        east = terrain.east + terrain.spacing * np.arange(columns)
        north = terrain.north + terrain.spacing * np.arange(rows)
        nodes = np.column_stack([np.tile(east, rows), np.repeat(north, columns), terrain.heights.ravel()])
        moved = new.to_local(*scenario.frame.to_geodetic(nodes))
        corner = moved[:, :2].mean(axis=0) - terrain.spacing * (np.array([columns, rows]) - 1) / 2
        heights = tuple(map(tuple, moved[:, 2].reshape(rows, columns).tolist()))
        grid = {"east": float(corner[0]), "north": float(corner[1]), "heights": heights, "file": None}
        return section.model_copy(update=grid)
    if section.kind == "analytic":
        words = "expected home, or terrain of another kind: this one is defined from home only"
        raise BadInput(words, place=f"survey.starts[{n}]")
    return section


def _move_section(section: Moved, old: LocalFrame, new: LocalFrame) -> Moved:
    changes = dict[str, Any]()
    place = (0.0, 0.0)
    if isinstance(section, Horizontal):
        place = section.east_north(old)
        there = old.geodetic(np.array([*place, 0.0]))
        degrees = {"latitude_deg": there.latitude_deg, "longitude_deg": there.longitude_deg}
        changes = {"east": None, "north": None, **degrees}
    written = {key: value for key, value in section if value is not None}
    for key in ("footprint", "polygon"):
        if key in written:
            ring = written[key]
            changes |= {key: None, f"{key}_geodetic": _degrees(ring, old)}
            place = tuple(np.mean(ring, axis=0).tolist())
            if "holes" in written:
                changes["holes"] = tuple(_degrees(hole, old) for hole in written["holes"])
        elif f"{key}_geodetic" in written:
            latitude, longitude = np.mean(written[f"{key}_geodetic"], axis=0)
            place = tuple(old.local(Geodetic(latitude, longitude, old.home.altitude))[:2].tolist())
    if "center" in written:
        changes["center"] = _move_section(written["center"], old, new)
    for key in ("up", "base"):
        if key in written:
            changes[key] = float(new.local(old.geodetic(np.array([*place, written[key]])))[2])
    if "heading_deg" in written:
        begin, end = move_between(old, new)(np.array([place, (place[0], place[1] + 1.0)]))
        east, north = end - begin
        changes["heading_deg"] = written["heading_deg"] + math.degrees(math.atan2(east, north))
    return section.model_copy(update=changes)


def _degrees(ring: Iterable[tuple[float, float]], frame: LocalFrame) -> Ring:
    latitude, longitude, _ = frame.to_geodetic(np.array([(*corner, 0.0) for corner in ring]))
    return tuple(zip(latitude.tolist(), longitude.tolist(), strict=True))


def _raise_zones(zones: NoFlyMap, by: float) -> NoFlyMap:
    ends = {"base": zones.base, "top": zones.top}
    return zones.model_copy(update={key: end + by for key, end in ends.items() if end is not None})


def _move_nested(value: Any, move: Move) -> Any:
    if value is None:
        return None
    if not isinstance(value[0][0], int | float):
        return [_move_nested(part, move) for part in value]
    return tuple(map(tuple, move(np.array(value, float)).tolist()))
