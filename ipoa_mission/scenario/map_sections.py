from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import Field, model_validator

from ipoa_mission.errors import NothingThere
from ipoa_mission.finding import Finding
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.areas import RESTRICTIONS, Restriction, Zones, find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings
from ipoa_mission.maps.map_reader import READERS, compare_with_gdal, read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from ipoa_mission.scenario.section import NotNegative, Positive, Section, existing_file
from ipoa_mission.world.terrain import Grid


class MapFile(Section):
    """A table that names a file of shapes."""

    file: Annotated[Path, existing_file("a map")]
    """Path relative to the scenario file. Text formats: `.geojson`, `.json`, `.geojsonl`, `.ndjson`, `.jsonl`, `.kml`,
    `.kmz`, `.osm`. Binary formats: `.osm.pbf`, `.shp`, `.fgb`, `.gpkg`."""
    suffixes: ClassVar[tuple[str, ...]] = READERS

    def differences(self) -> Iterator[Finding]:
        """Compare two readers' shapes."""
        return compare_with_gdal(self.file)


class BuildingsMap(MapFile):
    """Buildings, masts and trees on the ground, as OpenStreetMap exports them."""

    kind: Literal["buildings"]
    take: Literal["tagged", "all"] | None = None
    """`all`: every feature is an obstacle, except roads, land use and the like without a height. `tagged`: only
    features tagged as building, mast, tree or power line, or with a height. Default: as `tagged`, but a file of
    buildings only is taken whole. A flight near a passed-over feature that may be an obstacle is refused."""
    height_key: str = "height"
    """Property with the height of the top above the ground [m, or feet if stated]."""
    default_height: Positive | None = None
    """Height of a building without height and storeys [m]. Default: by its kind."""
    storey_height: Positive = 3.0
    """Height of a storey if only the number of storeys is known [m]."""
    point_height: Positive | None = None
    """Height of a mast, tree or other point without one [m]. Default: by its kind."""
    point_radius: Positive | None = None
    """Radius of a mast, tree or other point, and half width of a wall [m]. Default: by its kind."""
    line_height: NotNegative | None = None
    """Height of a power or telephone line without one [m]; 0 excludes lines. Default: by its voltage."""
    aerialway_height: NotNegative = 40.0
    """Height of a cable car, lift or zip line without one [m], at most 15 m for drag lifts; 0 excludes them."""
    wood_height: NotNegative | None = None
    """Height of a wood or orchard without one [m]; 0 excludes them. Default: no flight may be near one."""

    def read(self, frame: LocalFrame, within: Box) -> Buildings:
        rules = BuildingRules(**self.model_dump(include={field.name for field in fields(BuildingRules)}))
        buildings = search_buildings(self.file, rules, frame, within)
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
        return find_zones(read_features(self.file, MapWindow.of(frame)), frame, self.file)


class NoFlyMap(ZoneMap):
    """No-fly zones."""

    kind: Literal["no_fly"]
    base: float | None = None
    """Lower end of the zones [m above home]. Default: none."""
    top: float | None = None
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


class ElevationTerrain(Section):
    """An elevation model: GeoTIFF, SRTM `.hgt`, or another raster that GDAL reads (needs rasterio)."""

    kind: Literal["elevation"]
    file: Annotated[Path, existing_file("an elevation model")]
    """The model, relative to the scenario file, in any coordinate system that it names."""
    heights: Literal["amsl", "ellipsoidal"] | None = None
    """Datum of its heights: mean sea level (SRTM), or the WGS 84 ellipsoid. Default: as the file states."""
    geoid: Annotated[float | Path | None, existing_file("a number or a grid")] = None
    """For ellipsoidal heights: the geoid's height above the ellipsoid [m], or a PROJ grid. Default: PROJ's own grid."""
    spacing: Positive | None = None
    """Distance between the nodes of the local grid [m]. Default: that of the model's posts."""
    nodata: float | None = None
    """Number that marks a missing height, if the file does not state it."""
    level_at_home: bool = False
    """Shift the model so that its ground at home is at home's altitude: only differences count then."""

    def read(
        self, frame: LocalFrame, lower: tuple[float, float], upper: tuple[float, float]
    ) -> tuple[Grid, tuple[str, ...]]:
        """Return the ground above home [m], and remarks."""
        from ipoa_mission.maps.elevation import ElevationRules, local_grid  # slow import

        rules = ElevationRules(**self.model_dump(include={field.name for field in fields(ElevationRules)}))
        return local_grid(self.file, rules, frame, lower, upper)
