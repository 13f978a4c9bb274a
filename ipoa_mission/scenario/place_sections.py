from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, field_validator, model_validator

from ipoa_mission.errors import NotCovered
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Plane, Vector
from ipoa_mission.ground import Ground
from ipoa_mission.maps.map_window import Box
from ipoa_mission.scenario.map_sections import ElevationTerrain
from ipoa_mission.scenario.section import (
    Latitude,
    Longitude,
    NotNegative,
    Number,
    Positive,
    Section,
    existing_file,
    one_of,
)
from ipoa_mission.world.terrain import Analytic, Flat, Grid, Peak, SeaLevel, Terrain

Ring: TypeAlias = Annotated[tuple[tuple[Number, Number], ...], Field(min_length=3)]


def east_north_of(ring: Ring, frame: LocalFrame) -> Plane:
    latitude, longitude = np.asarray(ring, float).T
    return frame.to_local(latitude, longitude, np.full(len(latitude), frame.home.altitude))[:, :2]


class HomeSection(Section):
    """Take-off place, and origin of the local frame."""

    latitude_deg: Latitude
    """Degrees on WGS 84, positive to the north."""
    longitude_deg: Longitude
    """Degrees on WGS 84, positive to the east."""
    altitude_amsl: Number = 0.0
    """Height of the ground at home above mean sea level [m]."""

    def geodetic(self) -> Geodetic:
        return Geodetic(self.latitude_deg, self.longitude_deg, self.altitude_amsl)


class Horizontal(Section):
    """A position on the map: `east` and `north` [m from home], or `latitude_deg` and `longitude_deg`."""

    east: Number | None = None
    """East of home [m]; with `north`, in place of latitude and longitude."""
    north: Number | None = None
    """North of home [m]."""
    latitude_deg: Latitude | None = None
    """Degrees on WGS 84; with `longitude_deg`, in place of east and north."""
    longitude_deg: Longitude | None = None
    """Degrees on WGS 84."""

    _one_way = one_of("east and north", "latitude_deg and longitude_deg")

    def there(self) -> Geodetic | None:
        if self.latitude_deg is None or self.longitude_deg is None:
            return None
        return Geodetic(self.latitude_deg, self.longitude_deg)

    def east_north(self, frame: LocalFrame) -> tuple[float, float]:
        if self.east is not None and self.north is not None:
            return self.east, self.north
        there = self.there()
        assert there is not None
        east, north, _ = frame.local(replace(there, altitude=frame.home.altitude))
        return float(east), float(north)


class Place(Horizontal):
    """A point in the air, with exactly one of `up` (from home), `altitude_amsl` or `height_above_ground` [m]."""

    up: Number | None = None
    """Height above home's plane [m]."""
    altitude_amsl: Number | None = None
    """Height above mean sea level [m]."""
    height_above_ground: Number | None = None
    """Height above the ground at that place [m]."""

    _one_height = one_of("up", "altitude_amsl", "height_above_ground")

    def point(self, frame: LocalFrame, ground: Ground) -> Vector:
        """Return east, north, up, (3,) [m]."""
        east, north = self.east_north(frame)
        if self.up is not None:
            up = self.up
        elif self.height_above_ground is not None:
            up = ground.at(east, north) + self.height_above_ground
        else:
            assert self.altitude_amsl is not None
            there = self.there()
            if there is not None:
                return frame.local(replace(there, altitude=self.altitude_amsl))
            up = self.altitude_amsl - frame.home.altitude
        return np.array([east, north, up])


class FlatTerrain(Section):
    """Level ground above mean sea level, curved as the Earth."""

    kind: Literal["flat"] = "flat"
    height: Number = 0.0
    """Height of the ground [m above home]."""

    def build(self, frame: LocalFrame, corners: Box) -> tuple[Terrain, tuple[str, ...]]:
        reach = float(np.hypot(*np.abs(corners).max(axis=0)))
        ground = SeaLevel.around(frame.home, self.height, reach)
        return (ground if ground.drop > 0.01 else Flat(self.height)), ()  # drop by curvature [m]


class PeakSection(Section):
    """A Gaussian mountain of the paper's eq. (2)."""

    height: Number
    """Height of its top above `base` [m]."""
    east: Number
    """East of its top [m from home]."""
    north: Number
    """North of its top [m from home]."""
    a: Positive
    """Extent along east: distance at which the height falls to 1/e [m]."""
    b: Positive
    """Extent along north [m]."""


class AnalyticTerrain(Section):
    """The paper's surface: eq. (1) with coefficients a to g, the peaks of eq. (2), and their maximum, eq. (3)."""

    kind: Literal["analytic"]
    a: Number = 0.0
    """Shift of the sine along north, in its argument [m]."""
    b: Number = 0.0
    """Weight of the sine along east."""
    c: Number = 0.0
    """Weight of the cosine rings around home."""
    d: Number = 0.0
    """Wave number of these rings [1/m]."""
    e: Number = 0.0
    """Weight of the cosine along north."""
    f: Number = 0.0
    """Weight and wave number of the sine rings around home."""
    g: Number = 0.0
    """Weight of a second cosine along north."""
    base: Number = 0.0
    """h_0 of eq. (2): base height of the peaks [m]."""
    peaks: tuple[PeakSection, ...] = ()
    """The mountains."""

    def build(self, frame: LocalFrame, corners: Box) -> tuple[Terrain, tuple[str, ...]]:
        peaks = tuple(Peak(p.height, p.east, p.north, p.a, p.b) for p in self.peaks)
        return Analytic(self.a, self.b, self.c, self.d, self.e, self.f, self.g, peaks, self.base), ()


class GridTerrain(Section):
    """A regular grid of heights with bilinear interpolation: rows go north, columns go east."""

    kind: Literal["grid"]
    east: Number
    """East of the first column [m]."""
    north: Number
    """North of the first row [m]."""
    spacing: Positive
    """Distance between neighboring heights, along east and north [m]."""
    heights: Annotated[tuple[tuple[Number, ...], ...], Field(min_length=2)] | None = None
    """Heights [m above home], the southernmost row first."""
    file: Annotated[Path | None, existing_file("a file of heights")] = None
    """A CSV file of heights in place of `heights`, relative to the scenario file."""

    @field_validator("file")
    @classmethod
    def _of_numbers(cls, path: Path | None) -> Path | None:
        if path is not None:
            try:
                heights = np.loadtxt(path, delimiter=",", ndmin=2)
            except ValueError as error:
                raise ValueError(f"expected rows of numbers with commas between in {path}: {error}") from error
            if min(heights.shape) < 2 or not np.isfinite(heights).all():
                raise ValueError(f"expected at least two rows and two columns of finite numbers in {path}")
        return path

    _one_source = one_of("heights", "file")

    @model_validator(mode="after")
    def _rows_of_one_length(self) -> Self:
        if self.heights is not None and len({len(row) for row in self.heights}) != 1:
            raise ValueError("expected heights with rows of one length")
        return self

    def build(self, frame: LocalFrame, corners: Box) -> tuple[Terrain, tuple[str, ...]]:
        """Refuse a grid over half its spacing too small."""
        if self.file is not None:
            heights = np.loadtxt(self.file, delimiter=",", ndmin=2)
        else:
            heights = np.asarray(self.heights, float)
        first = np.array([self.east, self.north])
        last = first + self.spacing * (np.array(heights.shape[::-1]) - 1)
        missing = np.concatenate([first - corners[0], corners[1] - last])
        side = int(np.argmax(missing))
        if missing[side] - self.spacing / 2 > 1e-6:
            raise NotCovered(
                f"expected a grid over the whole flight area, which lies {missing[side]:.1f} m "
                f"beyond its {('west', 'south', 'east', 'north')[side]} edge",
                hint="give a larger grid, or narrow `bounds` (bounds.margin = 50 is the default)",
                place="terrain",
            )
        return Grid(self.east, self.north, self.spacing, heights), ()


TerrainSection: TypeAlias = Annotated[
    FlatTerrain | AnalyticTerrain | GridTerrain | ElevationTerrain, Field(discriminator="kind")
]


class FenceSection(Section):
    """A geofence: a polygon, or a circle around `center`."""

    inclusion: bool = True
    """true: stay inside; false: stay outside."""
    polygon: Ring | None = None
    """Corners as [east, north]."""
    polygon_geodetic: Ring | None = None
    """Corners as [latitude_deg, longitude_deg]."""
    center: Horizontal | None = None
    """Center of a circle, in place of a polygon."""
    radius: Positive | None = None
    """Radius of the circle [m]."""

    _one_shape = one_of("polygon", "polygon_geodetic", "center and radius")


class BoundsSection(Section):
    """Box in which the flight stays, each as [least, greatest]. Default: large enough."""

    east: tuple[Number, Number] | None = None
    """West and east side [m from home]. Default: large enough, or those of a map's flight area."""
    north: tuple[Number, Number] | None = None
    """South and north side [m from home]. Default: large enough, or those of a map's flight area."""
    up: tuple[Number, Number] | None = None
    """Heights [m above home]."""
    margin: NotNegative = 50.0
    """Distance of a default side beyond home, start, goal, ground, obstacles and near buildings [m]."""

    @field_validator("east", "north", "up")
    @classmethod
    def _ordered(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and value[0] >= value[1]:
            raise ValueError(f"expected [least, greatest], not [{value[0]:g}, {value[1]:g}]")
        return value
