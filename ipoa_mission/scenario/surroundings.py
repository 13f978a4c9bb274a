"""From a scenario to its world: bounds, terrain and obstacles in the local frame, drawn by hand and read from maps.

Maps may reach far beyond the flight. Where `bounds` leaves a side open it is drawn round the ends, what was drawn by
hand, and those things on the maps that are near; what lies well outside the bounds is left out.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.areas import Zone, join_zones
from ipoa_mission.maps.buildings import Standing, raise_buildings
from ipoa_mission.maps.planar import rings_of
from ipoa_mission.scenario.fencing import allowed_area, forbidden
from ipoa_mission.scenario.maps import BuildingsMap, ElevationTerrain, FlightAreaMap, NoFlyMap
from ipoa_mission.scenario.places import FenceSection
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.obstacles import Zone as NoFly
from ipoa_mission.world.polygon import Polygon
from ipoa_mission.world.terrain import Terrain

if TYPE_CHECKING:
    from ipoa_mission.scenario.model import Scenario

BEYOND = 100.0  # what lies farther outside the bounds is left out [m]
GLANCES = 33  # the ground is looked at on so many lines each way to see how high the bounds must be

Box = tuple[NDArray[np.float64], NDArray[np.float64]]  # lower and upper corner


@dataclass(frozen=True)
class Surroundings:
    """A scenario's world, the geofence of its mission, and remarks on what was assumed or mended in its maps."""

    airspace: Airspace
    geofence: tuple[FenceSection, ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class _Maps:
    """What was found in all maps."""

    standing: tuple[Standing, ...]
    no_fly: tuple[tuple[NoFlyMap, Zone], ...]
    area: Any | None
    area_fenced: bool
    remarks: tuple[str, ...]


def survey(scenario: "Scenario") -> Surroundings:
    """The world of a scenario.

    Raises:
        BadInput: naming the map file and the place in it that makes no sense, or that home lies outside.
        MissionError: a library that reads a map is not installed.
    """
    maps = _read_maps(scenario)
    allowed = allowed_area(scenario.fence, scenario.frame)
    lower, upper, near = _horizontal_bounds(scenario, maps, allowed)
    terrain, said = _terrain(scenario, lower, upper)
    drawn = _drawn(scenario, terrain)
    raised = raise_buildings(near, terrain.height)
    up = scenario.bounds.up or _up(scenario, terrain, (lower, upper), (*drawn, *raised))
    below, above = min(up[0], 0.0) - BEYOND, up[1] + BEYOND
    zones = (*_no_fly_prisms(maps, (lower, upper), up), *forbidden(scenario.fence, scenario.frame, below, above))
    areas = [area for area in (maps.area, allowed) if area is not None and not area.covers(shapely.box(*lower, *upper))]
    footprint = Polygon(*rings_of(_one(areas))) if areas else None
    bounds = Bounds((*map(float, lower), up[0]), (*map(float, upper), up[1]), footprint)  # type: ignore[arg-type]
    left_out = len(maps.standing) - len(near)
    if left_out:
        said = (*said, f"{left_out} things on the maps are more than {BEYOND:g} m outside the bounds and left out")
    airspace = Airspace(bounds, terrain, (*drawn, *raised, *zones))
    return Surroundings(airspace, (*scenario.fence, *_geofence(maps, (lower, upper))), (*maps.remarks, *said))


def _read_maps(scenario: "Scenario") -> _Maps:
    standing: list[Standing] = []
    no_fly: list[tuple[NoFlyMap, Zone]] = []
    areas: list[Any] = []
    remarks: list[str] = []
    fenced = False
    for section in scenario.maps:
        if isinstance(section, BuildingsMap):
            found, said = section.read(scenario.frame)
            standing += found
        else:
            zones, said = section.read(scenario.frame)
            if isinstance(section, NoFlyMap):
                no_fly += [(section, zone) for zone in zones]
            else:
                areas.append(join_zones(zones, section.file))
                fenced |= section.geofence
            _expect_home_allowed(section, zones)
        remarks += [f"{section.file.name}: {remark}" for remark in said]
    area = _one(areas) if areas else None
    return _Maps(tuple(standing), tuple(no_fly), area, fenced, tuple(remarks))


def _one(areas: list[Any]) -> Any:
    common = shapely.intersection_all(areas)
    if common.geom_type != "Polygon" or common.is_empty:
        raise BadInput("maps: expected flight areas, and fences, that have one area in common")
    return common


def _expect_home_allowed(section: NoFlyMap | FlightAreaMap, zones: tuple[Zone, ...]) -> None:
    home = shapely.Point(0, 0)
    if isinstance(section, FlightAreaMap):
        distance = min(zone.shape.distance(home) for zone in zones)
        if distance > 0:
            raise BadInput(f"{section.file}: expected home inside the flight area, not {distance:.1f} m outside of it")
    elif section.base is None or section.base <= 0:
        for zone in zones:
            if zone.shape.contains(home):
                raise BadInput(f"{section.file}: expected home outside of no-fly zones, but it is in {zone.name}")


def _horizontal_bounds(
    scenario: "Scenario", maps: _Maps, allowed: Any | None
) -> tuple[NDArray[np.float64], NDArray[np.float64], tuple[Standing, ...]]:
    """Lower and upper corner (2,) of the bounds, and what stands near enough to them to matter."""
    places = (scenario.start, scenario.goal, *scenario.via)
    ends = np.array([(0.0, 0.0), *(place.east_north(scenario.frame) for place in places)])
    drawn = [o.build("", scenario.frame, _level) for o in scenario.obstacles]
    things = np.vstack([ends, *(obstacle.bounds[:, :2] for obstacle in drawn)])
    boxes = np.array([shapely.bounds(s.shape.buffer(s.reach) if s.reach else s.shape) for s in maps.standing])
    margin = scenario.bounds.margin
    if maps.area is not None:
        west, south, east, north = shapely.bounds(maps.area)
        least, most = np.array([west, south]), np.array([east, north])
    else:
        reach = max(margin, float(np.linalg.norm(np.ptp(ends, axis=0))) / 2)
        around = boxes[_meets(boxes, (things.min(axis=0), things.max(axis=0)), reach)]
        things = np.vstack([things, around.reshape(-1, 2)])
        least, most = things.min(axis=0) - margin, things.max(axis=0) + margin
    for axis, side in enumerate((scenario.bounds.east, scenario.bounds.north)):
        if side is not None:
            least[axis], most[axis] = side
    if allowed is not None:
        west, south, east, north = shapely.bounds(allowed)
        least, most = np.maximum(least, (west, south)), np.minimum(most, (east, north))
    matters = _meets(boxes, (least, most), BEYOND)
    return least, most, tuple(s for s, counts in zip(maps.standing, matters, strict=True) if counts)


def _meets(boxes: NDArray[np.float64], box: Box, reach: float) -> NDArray[np.bool_]:
    """Which of the boxes (n, 4) west, south, east, north come within `reach` of a box, (n,)."""
    boxes = boxes.reshape(-1, 4)
    return np.asarray((boxes[:, :2] <= box[1] + reach).all(axis=1) & (boxes[:, 2:] >= box[0] - reach).all(axis=1))


def _terrain(
    scenario: "Scenario", lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> tuple[Terrain, tuple[str, ...]]:
    if isinstance(scenario.terrain, ElevationTerrain):
        return scenario.terrain.read(
            scenario.frame, (float(lower[0]), float(lower[1])), (float(upper[0]), float(upper[1]))
        )
    return scenario.terrain.build(), ()


def _drawn(scenario: "Scenario", terrain: Terrain) -> tuple[Obstacle, ...]:
    """The obstacles that stand in the scenario itself."""
    return tuple(
        o.build(o.name or f"{o.kind} {i}", scenario.frame, terrain.height) for i, o in enumerate(scenario.obstacles)
    )


def _up(scenario: "Scenario", terrain: Terrain, corners: Box, obstacles: tuple[Obstacle, ...]) -> tuple[float, float]:
    """From below all ground, ends and obstacles inside the bounds to above them."""
    places = (scenario.start, scenario.goal, *scenario.via)
    ends = [0.0, *(place.point(scenario.frame, terrain.height)[2] for place in places)]
    east, north = (np.linspace(corners[0][axis], corners[1][axis], GLANCES) for axis in (0, 1))
    ground = terrain.height(np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2))
    boxes = [obstacle.bounds for obstacle in obstacles]
    heights = [box[:, 2] for box in boxes if _meets(box[:, :2].reshape(1, 4), corners, 0.0)[0]]
    everything = np.concatenate([ends, [ground.min(), ground.max()], *heights])
    return float(everything.min()) - scenario.bounds.margin, float(everything.max()) + scenario.bounds.margin


def _no_fly_prisms(maps: _Maps, corners: Box, up: tuple[float, float]) -> tuple[Obstacle, ...]:
    """The zones as obstacles; an end that is left out lies well outside the bounds."""
    return tuple(
        NoFly(
            zone.name,
            *rings_of(zone.shape),
            section.base if section.base is not None else min(up[0], section.top or 0.0) - BEYOND,
            section.top if section.top is not None else max(up[1], section.base or 0.0) + BEYOND,
        )
        for section, zone in maps.no_fly
        if _zone_near(zone, corners)
    )


def _geofence(maps: _Maps, corners: Box) -> tuple[FenceSection, ...]:
    """The flight area, its holes, and the zones without an end, as the vehicle is told to keep them."""
    fences = []
    if maps.area is not None and maps.area_fenced:
        outer, holes = rings_of(maps.area)
        fences += [FenceSection(polygon=outer), *(FenceSection(polygon=hole, inclusion=False) for hole in holes)]
    for section, zone in maps.no_fly:
        if section.geofence and section.base is None and section.top is None and _zone_near(zone, corners):
            fences.append(FenceSection(polygon=rings_of(zone.shape)[0], inclusion=False))
    return tuple(fences)


def _zone_near(zone: Zone, corners: Box) -> bool:
    return bool(_meets(np.array([shapely.bounds(zone.shape)]), corners, BEYOND)[0])


def _level(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros(len(points))
