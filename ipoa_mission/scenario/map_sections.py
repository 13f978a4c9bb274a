"""Files of others that a scenario names: buildings, zones and the flight area, the elevation model of its terrain."""

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from ipoa_mission.errors import NothingThere
from ipoa_mission.maps.areas import RESTRICTIONS, Restriction, Zones, find_zones
from ipoa_mission.maps.around import Around, Box
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import Buildings, search_buildings
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.scenario.section import NotNegative, Positive, Section, beside
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.terrain import Grid


class MapFile(Section):
    """A table that names a file of shapes."""

    file: Annotated[Path, beside("a map")]
    """A `.geojson`, `.json`, `.geojsonl`, `.ndjson`, `.jsonl`, `.kml`, `.kmz`, `.osm`, `.osm.pbf`, `.parquet`,
    `.geoparquet`, `.shp`, `.fgb` or `.gpkg` file, relative to the scenario file."""


class BuildingsMap(MapFile):
    """Buildings, masts and trees that stand on the ground, as OpenStreetMap's exports have them."""

    kind: Literal["buildings"]
    take: Literal["tagged", "all"] | None = None
    """`all`: every feature is an obstacle but roads, land use and the like without a height. `tagged`: what tags call a
    building, a mast, a tree, a power line, or give a height; the rest is nothing. Left out: as `tagged`, but a file of
    nothing but buildings is taken whole, and a flight near what is passed over and may stand there is refused."""
    height_key: str = "height"
    """The property that holds the height of the top above the ground [m, or feet if it says so]."""
    default_height: Positive | None = None
    """Height of a building that has neither a height nor storeys [m]; left out, by its kind."""
    storey_height: Positive = 3.0
    """Height of a storey where only their number is known [m]."""
    point_height: Positive | None = None
    """Height of a mast, tree or other point that has none [m]; left out, by its kind."""
    point_radius: Positive | None = None
    """Radius of a mast, tree or other point; also half the width of a wall [m]; left out, by its kind."""
    line_height: NotNegative | None = None
    """Height of a power or telephone line that has none [m]; left out, by its voltage; 0: there are none."""
    aerialway_height: NotNegative = 40.0
    """Height of a cable car, lift or zip line that has none [m], of drag lifts 15 m at most; 0: there are none."""
    wood_height: NotNegative | None = None
    """Height of a wood or orchard that has none [m]; left out, no flight may be near one; 0: they are nothing."""

    def read(self, frame: LocalFrame, within: Box) -> Buildings:
        """What stands in the way within a box, what is passed over, and remarks on what was assumed."""
        rules = BuildingRules(**self.model_dump(include={field.name for field in fields(BuildingRules)}))
        buildings = search_buildings(self.file, rules, frame, within)
        if not (buildings.standing or buildings.elsewhere):
            words = f"expected buildings, but none of {buildings.features} features is tagged as one"
            raise NothingThere(words, hint='`take = "all"` takes every feature, whatever its tags', place=self.file)
        return buildings


class ZoneMap(MapFile):
    """Polygons on the map."""

    geofence: bool = True
    """Also put it into the mission, so that the vehicle itself keeps it."""

    def read(self, frame: LocalFrame, time: float | None) -> Zones:
        """The polygons at a time [s since 1970], what is passed over, and remarks on what was mended."""
        return find_zones(read_features(self.file, Around.of(frame)), frame, self.file)


class NoFlyMap(ZoneMap):
    """Zones to keep out of."""

    kind: Literal["no_fly"]
    base: float | None = None
    """Lower end of the zones [m above home]; left out, they begin below everything."""
    top: float | None = None
    """Upper end [m above home]; left out, they have none. Zones with an end are no geofence: fences have no height."""
    restrictions: tuple[Restriction, ...] = RESTRICTIONS
    """Which zones of an ED-269 or ED-318 file to keep out of; they have their own limits unless `base` or `top` is
    given."""

    def read(self, frame: LocalFrame, time: float | None) -> Zones:
        """The polygons at a time [s since 1970], what is passed over, and remarks on what was mended."""
        features = read_features(self.file, Around.of(frame))
        return find_zones(features, frame, self.file, self.restrictions, time)

    @model_validator(mode="after")
    def _ordered(self) -> "NoFlyMap":
        if self.base is not None and self.top is not None and self.base >= self.top:
            raise ValueError(f"expected base below top, not {self.base:g} and {self.top:g}")
        return self


class FlightAreaMap(ZoneMap):
    """The area to stay in: the bounds' footprint."""

    kind: Literal["flight_area"]


MapSection: TypeAlias = Annotated[BuildingsMap | NoFlyMap | FlightAreaMap, Field(discriminator="kind")]


class ElevationTerrain(Section):
    """An elevation model: GeoTIFF, SRTM `.hgt`, or another raster that GDAL reads (needs rasterio)."""

    kind: Literal["elevation"]
    file: Annotated[Path, beside("an elevation model")]
    """The model, relative to the scenario file; in any coordinate system, if it names it."""
    heights: Literal["amsl", "ellipsoidal"] | None = None
    """What its heights are above: mean sea level (SRTM), or the WGS 84 ellipsoid; left out, what the file says."""
    geoid: Annotated[float | Path | None, beside("a number or a grid")] = None
    """For ellipsoidal heights: the geoid's height above the ellipsoid [m], or a PROJ grid; left out, PROJ's own."""
    spacing: Positive | None = None
    """Distance between the nodes of the local grid [m]; left out, that of the model's posts."""
    voids: Literal["refuse", "fill"] = "refuse"
    """What is done about missing heights: `fill` takes them from their neighbors."""
    nodata: float | None = None
    """A number that stands for a missing height, where the file does not say so itself."""
    level_at_home: bool = False
    """Move the model up or down so that its ground at home is at home's altitude: only differences count then."""

    def read(
        self, frame: LocalFrame, lower: tuple[float, float], upper: tuple[float, float]
    ) -> tuple[Grid, tuple[str, ...]]:
        """The ground between two corners (east, north) [m] above home, and remarks on how it was read."""
        from ipoa_mission.maps.elevation import ElevationRules, local_grid  # SciPy's splines are slow to import

        rules = ElevationRules(**self.model_dump(include={field.name for field in fields(ElevationRules)}))
        return local_grid(self.file, rules, frame, lower, upper)
