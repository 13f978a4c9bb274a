"""Build a scenario's airspace and fences."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import compress
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import AwareDatetime

import ipoa_mission.scenario.obstacles as obstacle_sections
import ipoa_mission.scenario.place_sections as place_sections
from ipoa_mission.errors import BadInput, InvalidRing
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Plane
from ipoa_mission.ground import FLAT_GROUND, Ground
from ipoa_mission.maps.areas import MapArea, Zones, join_zones
from ipoa_mission.maps.buildings import Buildings, MapObstacle, raise_obstacles
from ipoa_mission.maps.feature import many_objects
from ipoa_mission.maps.map_window import Box
from ipoa_mission.maps.passed import PassedOver, count_passed_over
from ipoa_mission.scenario.map_sections import BuildingsMap, FlightAreaMap, MapSection, NoFlyMap
from ipoa_mission.scenario.obstacles import MARGIN, UNLIMITED_HEIGHT, NoFlyZone, meets, no_fly_prisms, on_lines
from ipoa_mission.scenario.place_sections import FenceSection, east_north_of
from ipoa_mission.unread import Unread, gathered
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.obstacles import Obstacle, RoundZone, Zone
from ipoa_mission.world.polygon import Polygon, rings_of
from ipoa_mission.world.terrain import Terrain

HOME = shapely.Point(0.0, 0.0)
WINDOW_MARGIN = 500.0  # growth of the bounds without a second reading [m]
BEYOND = f"more than {MARGIN:g} m outside the bounds"


Reach: TypeAlias = tuple[Plane, float]  # corners, greatest height above ground [m]


class Site(Protocol):
    start: place_sections.Place
    goal: place_sections.Place
    via: tuple[place_sections.Place, ...]
    bounds: place_sections.BoundsSection
    terrain: place_sections.TerrainSection
    obstacles: tuple[obstacle_sections.ObstacleSection, ...]
    maps: tuple[MapSection, ...]
    fence: tuple[FenceSection, ...]
    time: AwareDatetime | None

    @property
    def frame(self) -> LocalFrame: ...

    @property
    def added_reach(self) -> Reach: ...


def allowed_area(fences: Sequence[FenceSection], frame: LocalFrame) -> Any | None:
    """Return the intersection of inclusions."""
    shapes = [_shape(fence, frame, f"fence[{i}]") for i, fence in enumerate(fences) if fence.inclusion]
    if not shapes:
        return None
    common = _intersect(shapes, "expected inclusions that have one area in common", "fence")
    distance = common.distance(HOME)
    if distance > 0:
        words = f"expected home inside of it, not {distance:.1f} m outside"
        raise BadInput(words, code="home-outside-fence", place="fence")
    return common


def forbidden(fences: Sequence[FenceSection], frame: LocalFrame, base: float, top: float) -> tuple[Obstacle, ...]:
    obstacles: list[Obstacle] = []
    for i, fence in enumerate(fences):
        if fence.inclusion:
            continue
        name = f"fence[{i}]"
        shape = _shape(fence, frame, name)
        if shape.contains(HOME):
            raise BadInput("expected home outside of an exclusion", code="home-outside-fence", place=name)
        if fence.center is not None and fence.radius is not None:
            obstacles.append(RoundZone(name, *fence.center.east_north(frame), fence.radius, base, top))
        else:
            obstacles.append(Zone(name, *rings_of(shape), base, top))
    return tuple(obstacles)


def _shape(fence: FenceSection, frame: LocalFrame, name: str) -> Any:
    if fence.center is not None and fence.radius is not None:
        return shapely.Point(fence.center.east_north(frame)).buffer(fence.radius, quad_segs=16)
    geodetic = fence.polygon_geodetic
    shape = shapely.Polygon(fence.polygon if geodetic is None else east_north_of(geodetic, frame))
    if not shape.is_valid or math.isclose(shape.area, 0.0):
        reason = shapely.is_valid_reason(shape).split("[")[0].lower()
        raise InvalidRing(f"expected a polygon whose edges do not cross or overlap: {reason}", place=name)
    return shape


@dataclass(frozen=True)
class Surroundings:
    airspace: Airspace
    geofence: tuple[FenceSection, ...]
    passed_over: tuple[PassedOver, ...]
    unread: tuple[Unread, ...]
    remarks: tuple[str, ...]


class _MapZones(NamedTuple):
    """Zones by map number, the flight area, and the areas that do not touch it."""

    by_map: Mapping[int, Zones]
    no_fly: Sequence[NoFlyZone]
    area: Any | None
    is_area_fenced: bool
    other_areas: Sequence[PassedOver]


@many_objects()
def surroundings_of(scenario: Site) -> Surroundings:
    frame = scenario.frame
    zones = _read_zones(scenario)
    allowed = allowed_area(scenario.fence, frame)
    buildings, corners = _read_buildings(scenario, zones.area, allowed)
    near, no_fly, beyond = _near(_map_obstacles(scenario, buildings), zones.no_fly, corners)
    terrain, terrain_remarks = scenario.terrain.build(frame, corners)
    ground = Ground(terrain)
    tables = enumerate(scenario.obstacles)
    drawn = tuple(table.build(table.name or f"{table.kind} {i}", frame, ground) for i, table in tables)
    raised = raise_obstacles(near, ground)
    lower, upper = scenario.bounds.up or _up(scenario, terrain, corners, (*drawn, *raised))
    prisms, contrary = no_fly_prisms(no_fly, corners, (lower, upper), terrain, frame)
    exclusions = forbidden(scenario.fence, frame, min(lower, 0.0) - MARGIN, UNLIMITED_HEIGHT)

    box = shapely.box(*corners[0], *corners[1])
    areas = [area for area in (zones.area, allowed) if area is not None and not area.covers(box)]
    footprint = Polygon(*rings_of(_intersect(areas))) if areas else None
    west, south = map(float, corners[0])
    east, north = map(float, corners[1])
    bounds = Bounds((west, south, lower), (east, north, upper), footprint)
    airspace = Airspace(bounds, terrain, (*drawn, *raised, *prisms, *exclusions))

    found: dict[int, Zones | Buildings] = {**zones.by_map, **buildings}
    passed = (*(thing for each in found.values() for thing in each.passed_over), *zones.other_areas, *beyond)
    unread = gathered((*(thing for each in found.values() for thing in each.unread), *contrary))
    of_maps = [(scenario.maps[number].file.name, found[number].remarks) for number in sorted(found)]
    remarks = (
        *(f"{name}: {remark}" for name, of_map in of_maps for remark in of_map),
        *terrain_remarks,
        *(counted.words() for counted in count_passed_over(passed)),
        *(thing.words for thing in unread),
    )
    return Surroundings(airspace, (*scenario.fence, *_geofence(zones, no_fly)), passed, unread, remarks)


def _read_zones(scenario: Site) -> _MapZones:
    unix_s = None if scenario.time is None else scenario.time.timestamp()
    by_map = dict[int, Zones]()
    no_fly = list[NoFlyZone]()
    areas = list[Any]()
    is_fenced = False
    other_areas = list[PassedOver]()
    for number, section in enumerate(scenario.maps):
        if isinstance(section, BuildingsMap):
            continue
        zones = section.read(scenario.frame, unix_s)
        by_map[number] = zones
        if isinstance(section, NoFlyMap):
            no_fly += [(section, zone) for zone in zones.zones]
        else:
            area, others = join_zones(zones.zones)
            areas.append(area)
            why = "an area that does not touch the one around home"
            name = section.file.name
            other_areas += [PassedOver(name, f"area {n}", why, part, False) for n, part in enumerate(others, 2)]
            is_fenced |= section.geofence
        _expect_home_allowed(section, zones.zones, scenario.frame.home.altitude)
    return _MapZones(by_map, no_fly, _intersect(areas) if areas else None, is_fenced, other_areas)


def _read_buildings(scenario: Site, area: Any | None, allowed: Any | None) -> tuple[dict[int, Buildings], Box]:
    """Return buildings by map number, and the bounds, which buildings may extend."""

    def read(within: Box) -> dict[int, Buildings]:
        sections = ((n, section) for n, section in enumerate(scenario.maps) if isinstance(section, BuildingsMap))
        return {number: section.read(scenario.frame, within) for number, section in sections}

    drawn = [obstacle.build("", scenario.frame, FLAT_GROUND) for obstacle in scenario.obstacles]
    corners = np.vstack([_places(scenario), *(obstacle.bounds[:, :2] for obstacle in drawn)])
    things = corners.min(axis=0), corners.max(axis=0)
    least, most = _horizontal_bounds(scenario, area, things, np.zeros((0, 4)), allowed)
    reach = _reach(scenario) + WINDOW_MARGIN + MARGIN
    window = np.minimum(least, things[0]) - reach, np.maximum(most, things[1]) + reach
    buildings = read(window)
    bounds = _horizontal_bounds(scenario, area, things, _boxes(_map_obstacles(scenario, buildings)), allowed)
    needed = bounds[0] - MARGIN, bounds[1] + MARGIN
    if (needed[0] < window[0]).any() or (needed[1] > window[1]).any():
        buildings = read(needed)
    return buildings, bounds


def _map_obstacles(scenario: Site, buildings: Mapping[int, Buildings]) -> tuple[tuple[Path, MapObstacle], ...]:
    return tuple((scenario.maps[n].file, thing) for n, read in buildings.items() for thing in read.obstacles)


def _intersect(
    areas: list[Any], expected: str = "expected flight areas and fences with one common area", place: str = "maps"
) -> Any:
    common = shapely.intersection_all(areas)
    if common.geom_type != "Polygon" or common.is_empty:
        raise BadInput(expected, code="fence-empty", place=place)
    return common


def _expect_home_allowed(section: NoFlyMap | FlightAreaMap, zones: tuple[MapArea, ...], altitude: float) -> None:
    if isinstance(section, FlightAreaMap):
        distance = min(zone.shape.distance(HOME) for zone in zones)
        if distance > 0:
            words = f"expected home inside the flight area, not {distance:.1f} m outside of it"
            raise BadInput(words, code="home-outside-fence", place=section.file)
    elif section.base is None or section.base <= 0:
        for zone in zones:
            lower = zone.lower if section.base is None else None
            above = lower is not None and lower.height > (altitude if lower.reference == "AMSL" else 0.0)
            if zone.shape.contains(HOME) and not above:
                words = f"expected home outside of no-fly zones, but it is in {zone.name}"
                raise BadInput(words, code="home-outside-fence", place=section.file)


def _places(scenario: Site) -> NDArray[np.float64]:
    """Return home, places and corners of added tables, (n, 2) [m]."""
    places = (scenario.start, scenario.goal, *scenario.via)
    return np.vstack([(0.0, 0.0), *(place.east_north(scenario.frame) for place in places), scenario.added_reach[0]])


def _reach(scenario: Site) -> float:
    return max(scenario.bounds.margin, float(np.linalg.norm(np.ptp(_places(scenario), axis=0))) / 2)


def _horizontal_bounds(
    scenario: Site, area: Any | None, things: Box, boxes: NDArray[np.float64], allowed: Any | None
) -> Box:
    if area is not None:
        least, most = shapely.bounds(area).reshape(2, 2)
    else:
        around = boxes[meets(boxes, things, _reach(scenario))].reshape(-1, 2)
        margin = scenario.bounds.margin
        least = np.minimum(things[0], around.min(axis=0, initial=np.inf)) - margin
        most = np.maximum(things[1], around.max(axis=0, initial=-np.inf)) + margin
    for axis, side in enumerate((scenario.bounds.east, scenario.bounds.north)):
        if side is not None:
            least[axis], most[axis] = side
    if allowed is not None:
        allowed_least, allowed_most = shapely.bounds(allowed).reshape(2, 2)
        least = np.maximum(least, allowed_least)
        most = np.minimum(most, allowed_most)
    return least, most


def _boxes(obstacles: Sequence[tuple[Path, MapObstacle]]) -> NDArray[np.float64]:
    shapes = np.array([thing.shape for _, thing in obstacles], dtype=object)
    reach = np.array([thing.reach for _, thing in obstacles], float)
    wide = reach != 0.0
    shapes[wide] = shapely.buffer(shapes[wide], reach[wide], quad_segs=16)
    return np.asarray(shapely.bounds(shapes)).reshape(-1, 4)


def _near(
    obstacles: Sequence[tuple[Path, MapObstacle]], no_fly: Sequence[NoFlyZone], corners: Box
) -> tuple[list[MapObstacle], list[NoFlyZone], list[PassedOver]]:
    zone_boxes = shapely.bounds([zone.shape for _, zone in no_fly])
    is_near = meets(_boxes(obstacles), corners, MARGIN)
    is_zone_near = meets(zone_boxes, corners, MARGIN)
    far: list[tuple[Path, MapObstacle | MapArea]] = [*compress(obstacles, ~is_near)]
    far += [(section.file, zone) for section, zone in compress(no_fly, ~is_zone_near)]
    beyond = [
        PassedOver(file.name, thing.name.removeprefix(f"{file}: "), BEYOND, thing.shape, False) for file, thing in far
    ]
    return [thing for _, thing in compress(obstacles, is_near)], [*compress(no_fly, is_zone_near)], beyond


def _up(scenario: Site, terrain: Terrain, corners: Box, obstacles: tuple[Obstacle, ...]) -> tuple[float, float]:
    places = (scenario.start, scenario.goal, *scenario.via)
    ends = [0.0, *(place.point(scenario.frame, Ground(terrain))[2] for place in places)]
    ground = on_lines(terrain, corners)
    boxes = np.array([obstacle.bounds for obstacle in obstacles], float).reshape(-1, 2, 3)
    inside = boxes[meets(boxes[:, :, :2], corners, 0.0)]
    ends += [float(ground.max()) + scenario.added_reach[1]]
    everything = np.concatenate([ends, [ground.min(), ground.max()], inside[:, :, 2].ravel()])
    return float(everything.min()) - scenario.bounds.margin, float(everything.max()) + scenario.bounds.margin


def _geofence(zones: _MapZones, no_fly: Sequence[NoFlyZone]) -> tuple[FenceSection, ...]:
    fences = []
    if zones.area is not None and zones.is_area_fenced:
        outer, holes = rings_of(zones.area)
        fences += [FenceSection(polygon=outer), *(FenceSection(polygon=hole, inclusion=False) for hole in holes)]
    for section, zone in no_fly:
        if section.geofence and all(end is None for end in (section.base, section.top, zone.lower, zone.upper)):
            fences.append(FenceSection(polygon=rings_of(zone.shape)[0], inclusion=False))
    return tuple(fences)
