from pathlib import Path
from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import Field, model_validator

from ipoa_mission.errors import NothingThere
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.areas import RESTRICTIONS, Restriction, Zones, find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings
from ipoa_mission.maps.geoid import ElevationRules
from ipoa_mission.maps.map_reader import READERS, read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from ipoa_mission.scenario.section import Number, Section, existing_file
from ipoa_mission.world.terrain import Grid


class MapFile(Section):
    """A table that names a file of shapes."""

    file: Annotated[Path, existing_file("a map")]
    """Path relative to the scenario file."""
    suffixes: ClassVar[tuple[str, ...]] = READERS


class BuildingsMap(BuildingRules, MapFile):
    """Buildings, masts and trees on the ground, as OpenStreetMap exports them."""

    kind: Literal["buildings"]

    def read(self, frame: LocalFrame, within: Box) -> Buildings:
        buildings = search_buildings(self.file, self, frame, within)
        if not (buildings.obstacles or buildings.elsewhere):
            words = f"expected buildings, but none of {buildings.features} features is tagged as one"
            raise NothingThere(words, hint='`take = "all"` takes every feature, whatever its tags', place=self.file)
        return buildings


class ZoneMap(MapFile):
    """Polygons on the map."""

    geofence: bool = True
    """`true`: the mission also contains it as a geofence."""

    def read(self, frame: LocalFrame, time: float | None) -> Zones:
        """Return the zones at a time [s since 1970]."""
        return find_zones(read_features(self.file, MapWindow.of(frame)), frame, self.file, None)


class NoFlyMap(ZoneMap):
    """No-fly zones."""

    kind: Literal["no_fly"]
    base: Number | None = None
    """Lower end of the zones [m above home]. Default: none."""
    top: Number | None = None
    """Upper end [m above home]. Default: none. Zones with an end are not in the geofence, since fences have no
    heights."""
    restrictions: tuple[Restriction, ...] = RESTRICTIONS
    """Restrictions of an ED-269 or ED-318 file that are kept. Its zones have their own limits unless `base` or `top` is
    given."""

    def read(self, frame: LocalFrame, time: float | None) -> Zones:
        return find_zones(read_features(self.file, MapWindow.of(frame)), frame, self.file, self.restrictions, time)

    @model_validator(mode="after")
    def _ordered(self) -> "NoFlyMap":
        if self.base is not None and self.top is not None and self.base >= self.top:
            raise ValueError(f"expected base below top, not {self.base:g} and {self.top:g}")
        return self


class FlightAreaMap(ZoneMap):
    """The area to stay in: the footprint of the bounds."""

    kind: Literal["flight_area"]


MapSection: TypeAlias = Annotated[BuildingsMap | NoFlyMap | FlightAreaMap, Field(discriminator="kind")]


class ElevationTerrain(ElevationRules, Section):
    """An elevation model: GeoTIFF, SRTM `.hgt`, or another raster that GDAL reads (needs rasterio)."""

    kind: Literal["elevation"]
    file: Annotated[Path, existing_file("an elevation model")]
    """The model, relative to the scenario file, in any coordinate system that it names."""
    geoid: Annotated[float | Path | None, existing_file("a number or a grid")] = None
    """For ellipsoidal heights: the geoid's height above the ellipsoid [m], or a PROJ grid. Default: PROJ's own grid."""

    def build(self, frame: LocalFrame, corners: Box) -> tuple[Grid, tuple[str, ...]]:
        """Return the ground above home [m], and remarks."""
        from ipoa_mission.maps.elevation import local_grid  # slow import

        (west, south), (east, north) = (corner.tolist() for corner in corners)
        return local_grid(self.file, self, frame, (west, south), (east, north))
