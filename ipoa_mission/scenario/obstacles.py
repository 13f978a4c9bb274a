from collections.abc import Sequence
from typing import Annotated, Literal, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import Field, field_validator

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Plane, places_under
from ipoa_mission.ground import Ground
from ipoa_mission.maps.areas import MapArea
from ipoa_mission.maps.map_window import Box
from ipoa_mission.scenario.map_sections import NoFlyMap
from ipoa_mission.scenario.place_sections import Horizontal, Ring, east_north_of
from ipoa_mission.scenario.section import Number, Positive, Section, one_of
from ipoa_mission.unread import Unread
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere, Zone
from ipoa_mission.world.polygon import rings_of
from ipoa_mission.world.terrain import Grid, SeaLevel, Terrain

NoFlyZone: TypeAlias = tuple[NoFlyMap, MapArea]
UNLIMITED_HEIGHT = 10_000.0  # of a zone [m]
MARGIN = 100.0  # around the bounds [m]


class NamedObstacle(Section):
    name: str | None = None
    """Name for messages. Default: its kind and number."""


class UprightObstacle(NamedObstacle):
    height: Positive
    """Height above its base, or above the highest ground under it [m]."""
    base: Number | None = None
    """Height of the lower end [m above home]. Default: the ground."""

    def vertical_extent(self, footprint: Plane, shape: shapely.Polygon, ground: Ground) -> tuple[float, float]:
        if self.base is not None:
            return self.base, self.base + self.height
        heights = ground(np.vstack([footprint, footprint.mean(axis=0), places_under(shape)]))
        return float(heights.min()), float(heights.max()) + self.height


class SphereSection(Horizontal, NamedObstacle):
    """A sphere."""

    kind: Literal["sphere"]
    radius: Positive
    """Radius [m]."""
    up: Number | None = None
    """Height of the center [m above home]. Default: the sphere touches the ground."""

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        east, north = self.east_north(frame)
        up = self.up if self.up is not None else ground.at(east, north) + self.radius
        return Sphere(name, (east, north, up), self.radius)


class CylinderSection(Horizontal, UprightObstacle):
    """A vertical cylinder: a tower, a mast, a tree."""

    kind: Literal["cylinder"]
    radius: Positive
    """Radius [m]."""

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        east, north = self.east_north(frame)
        rim = np.array([[east, north]]) + self.radius * np.array([(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)])
        disk = shapely.Point(east, north).buffer(self.radius)
        return Cylinder(name, east, north, self.radius, *self.vertical_extent(rim, disk, ground))


class BoxSection(Horizontal, UprightObstacle):
    """A box around its position, turned clockwise from north by `heading_deg`."""

    kind: Literal["box"]
    width: Positive
    """Extent along east, before rotation [m]."""
    depth: Positive
    """Extent along north, before rotation [m]."""
    heading_deg: Number = 0.0
    """Rotation, clockwise from north."""

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (self.width / 2, self.depth / 2)
        heading = np.radians(self.heading_deg)
        turn = np.array([(np.cos(heading), -np.sin(heading)), (np.sin(heading), np.cos(heading))])
        corners = corners @ turn + self.east_north(frame)
        return Prism(name, _ring(corners), (), *self.vertical_extent(corners, shapely.Polygon(corners), ground))


class PrismSection(UprightObstacle):
    """A building: a polygon footprint (with holes) and a height."""

    kind: Literal["prism"]
    footprint: Ring | None = None
    """Corners as [east, north]."""
    footprint_geodetic: Ring | None = None
    """Corners as [latitude_deg, longitude_deg]."""
    holes: tuple[Ring, ...] = ()
    """Courtyards, in the same coordinates as the footprint."""

    @field_validator("footprint", "footprint_geodetic")
    @classmethod
    def _crosses_nothing(cls, ring: Ring | None) -> Ring | None:
        if ring is not None and not shapely.Polygon(ring).is_valid:
            why = shapely.is_valid_reason(shapely.Polygon(ring))
            raise ValueError(f"expected a ring that does not cross itself, not one with {why}")
        return ring

    _one_footprint = one_of("footprint", "footprint_geodetic")

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        outer, *holes = (
            np.asarray(ring, float) if self.footprint_geodetic is None else east_north_of(ring, frame)
            for ring in (self.footprint_geodetic or self.footprint or (), *self.holes)
        )
        bottom, top = self.vertical_extent(outer, shapely.Polygon(outer), ground)
        return Prism(name, _ring(outer), tuple(map(_ring, holes)), bottom, top)


ObstacleSection: TypeAlias = Annotated[
    SphereSection | CylinderSection | BoxSection | PrismSection, Field(discriminator="kind")
]


def _ring(corners: Plane) -> tuple[tuple[float, float], ...]:
    return tuple((float(east), float(north)) for east, north in corners)


def no_fly_prisms(
    no_fly: Sequence[NoFlyZone], corners: Box, up: tuple[float, float], terrain: Terrain, frame: LocalFrame
) -> tuple[tuple[Obstacle, ...], tuple[Unread, ...]]:
    """Return the zones as obstacles. One with limits below the ground is unlimited, and reported."""
    prisms = list[Obstacle]()
    unread = list[Unread]()
    for section, zone in no_fly:
        base, top = _ends(section, zone, corners, terrain, frame)
        if section.base is None and section.top is None and top is not None:
            least = _ground_under(terrain, _box_of(zone, corners))[0]
            if top <= max(least, least if base is None else base):
                what = "limits below the ground, ignored"
                unread.append(Unread(section.file.name, what, zone.name.removeprefix(f"{section.file}: ")))
                base = top = None
        low = base if base is not None else min(up[0], top or 0.0) - MARGIN
        high = top if top is not None else max(UNLIMITED_HEIGHT, (base or 0.0) + MARGIN)
        if low < high:
            prisms.append(Zone(zone.name, *rings_of(zone.shape), low, high))
    return tuple(prisms), tuple(unread)


def _box_of(zone: MapArea, corners: Box) -> Box:
    west, south, east, north = shapely.bounds(zone.shape)
    return np.maximum(corners[0] - MARGIN, (west, south)), np.minimum(corners[1] + MARGIN, (east, north))


def _ends(
    section: NoFlyMap, zone: MapArea, corners: Box, terrain: Terrain, frame: LocalFrame
) -> tuple[float | None, float | None]:
    base = section.base
    top = section.top
    if zone.lower is None and zone.upper is None:
        return base, top
    box = _box_of(zone, corners)
    ground = _ground_under(terrain, box)
    reach = float(np.hypot(*np.maximum(np.abs(box[0]), np.abs(box[1]))))
    if base is None and zone.lower is not None:
        level = zone.lower.height - frame.home.altitude
        at_sea = level - SeaLevel.around(frame.home, level, reach).drop
        base = at_sea if zone.lower.reference == "AMSL" else ground[0] + zone.lower.height
    if top is None and zone.upper is not None:
        at_sea = zone.upper.height - frame.home.altitude
        top = at_sea if zone.upper.reference == "AMSL" else ground[1] + zone.upper.height
    return base, top


def _ground_under(terrain: Terrain, box: Box) -> tuple[float, float]:
    if isinstance(terrain, Grid):
        rows, columns = terrain.heights.shape
        origin = np.array([terrain.east, terrain.north])
        first = np.clip(np.floor((box[0] - origin) / terrain.spacing).astype(int), 0, (columns - 1, rows - 1))
        last = np.clip(np.ceil((box[1] - origin) / terrain.spacing).astype(int), 0, (columns - 1, rows - 1))
        heights = terrain.heights[first[1] : last[1] + 1, first[0] : last[0] + 1]
    else:
        heights = on_lines(terrain, box)
    return float(heights.min()), float(heights.max())


def on_lines(terrain: Terrain, box: Box) -> NDArray[np.float64]:
    """Return heights on a lattice, (n,) [m]."""
    east, north = (np.linspace(box[0][axis], box[1][axis], 33) for axis in (0, 1))
    return terrain.height(np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2))


def meets(boxes: NDArray[np.float64], box: Box, reach: float) -> NDArray[np.bool_]:
    """Return which boxes (n, 4) are within `reach` [m]."""
    boxes = boxes.reshape(-1, 4)
    return np.asarray((boxes[:, :2] <= box[1] + reach).all(axis=1) & (boxes[:, 2:] >= box[0] - reach).all(axis=1))
