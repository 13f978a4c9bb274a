"""Move home to a start place; meters from home are converted."""

import math
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias, TypeVar

import numpy as np

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Points
from ipoa_mission.scenario.map_sections import NoFlyMap
from ipoa_mission.scenario.model import CACHED, WORLD, Scenario
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
from ipoa_mission.world.frame import Geodetic, LocalFrame, apart
from ipoa_mission.world.terrain import Grid

Moved = TypeVar("Moved", bound=Section)
Ring: TypeAlias = tuple[tuple[float, float], ...]
Move: TypeAlias = Callable[[Points], Points]  # of places (n, 2) [m]


def flown_from(scenario: Scenario, home: Geodetic) -> Scenario:
    tolerance, away = 1.0, _away(scenario, home)  # [m]
    if not away or min(away) > tolerance or apart(home, scenario.frame.home) <= tolerance:
        return scenario
    return at_start(scenario, int(np.argmin(away)))


def nearest_start(scenario: Scenario, there: Geodetic) -> Scenario:
    away = _away(scenario, there)
    return at_start(scenario, int(np.argmin(away))) if away else scenario


def _away(scenario: Scenario, there: Geodetic) -> list[float]:
    starts = () if scenario.survey is None else scenario.survey.starts or ()
    return [apart(there, scenario.frame.geodetic(np.array([*start, 0.0]))) for start in starts]


def at_start(scenario: Scenario, n: int) -> Scenario:
    """Return the scenario from start place `n`, cached. Raises BadInput, MissionError."""
    assert scenario.survey is not None
    assert scenario.survey.starts is not None
    if scenario.survey.starts[n] == (0.0, 0.0):
        return scenario
    if (seen := scenario.from_starts.get(n)) is None:
        seen = scenario.model_copy(update=_sections_from(scenario, n))
        try:
            seen.read_maps()
        except MissionError as error:
            raise error.at(f"survey.starts[{n}]: as home") from error
        scenario.from_starts[n] = seen
    moved = scenario.model_copy(update={key: getattr(seen, key) for key in (*WORLD, "rally")})
    moved.__dict__ |= {key: seen.__dict__[key] for key in CACHED if key in seen.__dict__}
    return moved


def between(old: LocalFrame, new: LocalFrame) -> Move:
    def moved(places: Points) -> Points:
        if old.home == new.home:
            return places
        latitude, longitude, _ = old.to_geodetic(np.column_stack([places, np.zeros(len(places))]))
        return new.to_local(latitude, longitude, new.home.altitude)[:, :2]

    return moved


def _sections_from(scenario: Scenario, n: int) -> dict[str, Any]:
    section, old = scenario.survey, scenario.frame
    assert section is not None
    assert section.starts is not None
    place = np.array(section.starts[n])
    there = old.geodetic(np.append(place, float(scenario.airspace.terrain.height(place[None])[0])))
    home = HomeSection(
        latitude_deg=round(there.latitude_deg, 7),
        longitude_deg=round(there.longitude_deg, 7),
        altitude_amsl=round(there.altitude, 3),
    )
    new = LocalFrame(home.geodetic())
    move, rise = between(old, new), home.altitude_amsl - old.home.altitude
    start = Place(east=0.0, north=0.0, height_above_ground=section.height)
    survey = {key: _nested(getattr(section, key), move) for key in ("polygon", "line", "starts")}
    return {
        "home": home,
        "start": start,
        "goal": start,
        "via": (),
        "bounds": _bounds(scenario, new, rise),
        "terrain": _terrain(scenario, new, rise, n),
        "obstacles": tuple(_moved(obstacle, old, new) for obstacle in scenario.obstacles),
        "maps": tuple(_raised(zones, -rise) if isinstance(zones, NoFlyMap) else zones for zones in scenario.maps),
        "fence": tuple(_moved(fence, old, new) for fence in scenario.fence),
        "rally": tuple(_moved(place, old, new) for place in scenario.rally),
        "survey": section.model_copy(update=survey),
    }


def _bounds(scenario: Scenario, new: LocalFrame, rise: float) -> BoundsSection:
    air, (east, north, _) = scenario.airspace.bounds, new.local(scenario.frame.home)
    (west, south, low), (right, back, high) = air.lower, air.upper
    return BoundsSection(
        east=(west + east, right + east),
        north=(south + north, back + north),
        up=(low - rise, high - rise),
        margin=scenario.bounds.margin,
    )


def _terrain(scenario: Scenario, new: LocalFrame, rise: float, n: int) -> TerrainSection:
    section, terrain = scenario.terrain, scenario.airspace.terrain
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


def _moved(section: Moved, old: LocalFrame, new: LocalFrame) -> Moved:
    changes, at = dict[str, Any](), (0.0, 0.0)
    if isinstance(section, Horizontal):
        at = section.east_north(old)
        there = old.geodetic(np.array([*at, 0.0]))
        degrees = {"latitude_deg": there.latitude_deg, "longitude_deg": there.longitude_deg}
        changes = {"east": None, "north": None, **degrees}
    for key in ("footprint", "polygon"):
        if (ring := getattr(section, key, None)) is not None:
            changes |= {key: None, f"{key}_geodetic": _degrees(ring, old)}
            at = tuple(np.mean(ring, axis=0).tolist())
            if holes := getattr(section, "holes", ()):
                changes["holes"] = tuple(_degrees(hole, old) for hole in holes)
        elif (ring := getattr(section, f"{key}_geodetic", None)) is not None:
            latitude, longitude = np.mean(ring, axis=0)
            at = tuple(old.local(Geodetic(latitude, longitude, old.home.altitude))[:2].tolist())
    if (center := getattr(section, "center", None)) is not None:
        changes["center"] = _moved(center, old, new)
    for key in ("up", "base"):
        if (height := getattr(section, key, None)) is not None:
            changes[key] = float(new.local(old.geodetic(np.array([*at, height])))[2])
    if (heading := getattr(section, "heading_deg", None)) is not None:
        (east, north), (ahead, farther) = between(old, new)(np.array([at, (at[0], at[1] + 1.0)]))
        changes["heading_deg"] = heading + math.degrees(math.atan2(ahead - east, farther - north))
    return section.model_copy(update=changes)


def _degrees(ring: Iterable[tuple[float, float]], frame: LocalFrame) -> Ring:
    latitude, longitude, _ = frame.to_geodetic(np.array([(*corner, 0.0) for corner in ring]))
    return tuple(zip(latitude.tolist(), longitude.tolist(), strict=True))


def _raised(zones: NoFlyMap, by: float) -> NoFlyMap:
    ends = {key: value + by for key in ("base", "top") if (value := getattr(zones, key)) is not None}
    return zones.model_copy(update=ends)


def _nested(value: Any, move: Move) -> Any:
    if value is None:
        return None
    if not isinstance(value[0][0], int | float):
        return [_nested(part, move) for part in value]
    return tuple(map(tuple, move(np.array(value, float)).tolist()))
