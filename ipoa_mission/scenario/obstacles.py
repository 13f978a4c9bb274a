from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
import shapely
from pydantic import Field, field_validator, model_validator

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Points
from ipoa_mission.ground import Ground
from ipoa_mission.scenario.place_sections import Horizontal, Ring, east_north_of
from ipoa_mission.scenario.section import Positive, Section
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere


class SphereSection(Horizontal):
    """A sphere."""

    kind: Literal["sphere"]
    name: str | None = None
    """Name for messages. Default: its kind and number."""
    radius: Positive
    """Radius [m]."""
    up: float | None = None
    """Height of the center [m above home]. Default: the sphere touches the ground."""

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        east, north = self.east_north(frame)
        up = self.up if self.up is not None else float(ground(np.array([[east, north]]))[0]) + self.radius
        return Sphere(name, (east, north, up), self.radius)


class CylinderSection(Horizontal):
    """A vertical cylinder: a tower, a mast, a tree."""

    kind: Literal["cylinder"]
    name: str | None = None
    """Name for messages. Default: its kind and number."""
    radius: Positive
    """Radius [m]."""
    height: Positive
    """Height above its base, or above the highest ground under it [m]."""
    base: float | None = None
    """Height of the lower end [m above home]. Default: the ground."""

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        east, north = self.east_north(frame)
        rim = np.array([[east, north]]) + self.radius * np.array([(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)])
        return Cylinder(name, east, north, self.radius, *_vertical_extent(self.base, self.height, ground, rim))


class BoxSection(Horizontal):
    """A box around its position, turned clockwise from north by `heading_deg`."""

    kind: Literal["box"]
    name: str | None = None
    """Name for messages. Default: its kind and number."""
    width: Positive
    """Extent along east, before rotation [m]."""
    depth: Positive
    """Extent along north, before rotation [m]."""
    height: Positive
    """Height above its base, or above the highest ground under it [m]."""
    heading_deg: float = 0.0
    """Rotation, clockwise from north."""
    base: float | None = None
    """Height of the lower end [m above home]. Default: the ground."""

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (self.width / 2, self.depth / 2)
        c, s = np.cos(np.radians(self.heading_deg)), np.sin(np.radians(self.heading_deg))
        corners = corners @ np.array([(c, -s), (s, c)]) + self.east_north(frame)
        return Prism(name, _ring(corners), (), *_vertical_extent(self.base, self.height, ground, corners))


class PrismSection(Section):
    """A building: a polygon footprint (with holes) and a height."""

    kind: Literal["prism"]
    name: str | None = None
    """Name for messages. Default: its kind and number."""
    footprint: Ring | None = None
    """Corners as [east, north]."""
    footprint_geodetic: Ring | None = None
    """Corners as [latitude_deg, longitude_deg]."""
    holes: tuple[Ring, ...] = ()
    """Courtyards, in the same coordinates as the footprint."""
    height: Positive
    """Height above its base, or above the highest ground under it [m]."""
    base: float | None = None
    """Height of the lower end [m above home]. Default: the ground."""

    @field_validator("footprint", "footprint_geodetic")
    @classmethod
    def _crosses_nothing(cls, ring: Ring | None) -> Ring | None:
        if ring is not None and not (shape := shapely.Polygon(ring)).is_valid:
            why = shapely.is_valid_reason(shape)
            raise ValueError(f"expected a ring that does not cross itself, not one with {why}")
        return ring

    @model_validator(mode="after")
    def _one_footprint(self) -> Self:
        if (self.footprint is None) == (self.footprint_geodetic is None):
            raise ValueError("expected either footprint or footprint_geodetic")
        return self

    def build(self, name: str, frame: LocalFrame, ground: Ground) -> Obstacle:
        outer, *holes = (
            np.asarray(ring, float) if self.footprint_geodetic is None else east_north_of(ring, frame)
            for ring in (self.footprint_geodetic or self.footprint or (), *self.holes)
        )
        bottom, top = _vertical_extent(self.base, self.height, ground, outer)
        return Prism(name, _ring(outer), tuple(map(_ring, holes)), bottom, top)


ObstacleSection: TypeAlias = Annotated[
    SphereSection | CylinderSection | BoxSection | PrismSection, Field(discriminator="kind")
]


def _vertical_extent(base: float | None, height: float, ground: Ground, footprint: Points) -> tuple[float, float]:
    if base is not None:
        return base, base + height
    heights = ground(np.vstack([footprint, footprint.mean(axis=0)]))
    return float(heights.min()), float(heights.max()) + height


def _ring(corners: Points) -> tuple[tuple[float, float], ...]:
    return tuple((float(east), float(north)) for east, north in corners)
