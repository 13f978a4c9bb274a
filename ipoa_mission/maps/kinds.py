"""What the tags of a feature say that it is: something that stands in the way, something flat, or nothing at all.

The tags are OpenStreetMap's. Those of Overture's buildings are read as the tags of OpenStreetMap that mean the same.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

import numpy as np
import shapely

from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.wires import OVERGROUND, WIRES

#: What a shape covers.
Extent: TypeAlias = Literal["area", "thin", "none"]
#: Values of `building` and `building:part` that say that there is none.
NO_BUILDING = {"no", "entrance", "demolished", "razed", "proposed", "construction_site"}
#: What is tall by nature, whether or not its height is known.
TALL = {
    "man_made": {
        "antenna", "chimney", "communications_tower", "cooling_tower", "crane", "flagpole", "gasometer", "lighthouse",
        "mast", "monitoring_station", "obelisk", "silo", "storage_tank", "telescope", "tower", "utility_pole",
        "water_tower", "windmill",
    },
    "natural": {"tree", "tree_row"},
    "power": {"tower", "pole", "portal", "terminal"},
    "generator:source": {"wind"},
    "aerialway": {"pylon"},
    "highway": {"street_lamp"},
    "advertising": {"column", "totem"},
}  # fmt: skip
#: Trees over an area: no obstacle unless their height is known, but in the way.
WOODS = {"natural": {"wood"}, "landuse": {"forest", "orchard"}, "landcover": {"trees"}}
#: What lies on the ground, or is only an area: all values of these keys but those named.
GROUNDS: Mapping[str, set[str]] = {
    "highway": {"elevator"},
    "railway": {"station"},
    "waterway": {"dam", "weir", "lock_gate"},
    "landuse": {"forest", "orchard"},
    "natural": {"wood", "tree", "tree_row", "arch", "cliff", "rock", "stone"},
    "leisure": {"stadium", "sports_hall", "sports_centre", "grandstand", "bleachers", "ice_rink", "bandstand"},
    "boundary": set(),
    "place": set(),
    "route": set(),
    "admin_level": set(),
    "aeroway": {"hangar", "terminal", "tower"},
    "landcover": {"trees"},
    "golf": set(),
}
#: Areas by `amenity` in which buildings are mapped on their own.
FLAT_AMENITIES = {
    "bench", "bicycle_parking", "clinic", "college", "fountain", "grave_yard", "hospital", "kindergarten",
    "marketplace", "parking", "parking_entrance", "parking_space", "place_of_worship", "school", "university",
    "waste_basket",
}  # fmt: skip
#: Keys by which a file of buildings is known even where they are null.
HEIGHTS = {"height", "building:levels", "num_floors", "min_height", "roof_height"}
OVERTURE = {"num_floors", "num_floors_underground", "min_floor", "roof_height", "has_parts", "is_underground"}
AS_OPENSTREETMAP = {"num_floors": "building:levels", "min_floor": "building:min_level", "roof_height": "roof:height"}
#: The height of the top above mean sea level [m].
TOP_AMSL = "height:amsl"
#: Tags that say which thing it is, not what.
NAMING = {"name", "id", "@id", "osm_id", "osm_way_id", "fid", "ID", "FID", "OBJECTID", "Name", "Id", "description"}


@dataclass(frozen=True)
class Reason:
    """Why a feature is passed over; `may_stand`: it may be in the way all the same. `remedy`: what to do then."""

    words: str
    may_stand: bool
    remedy: str = (
        'what stands there the map does not say: under [[maps]], take = "all" makes it an obstacle (default_height); '
        'take = "tagged" says that it is nothing'
    )


CABLE = Reason(
    "a power cable that may hang or lie in the ground",
    True,
    "location=underground in the map says that it lies in the ground; under [[maps]], line_height = 15 lets all power "
    "lines hang so high [m]",
)
WOOD = Reason(
    "a wood of unknown height",
    True,
    "under [[maps]], wood_height = 35 gives woods that height [m]; wood_height = 0 says that nothing stands there",
)
FLAT = Reason("tagged as something flat", False)


def as_openstreetmap(feature: Feature) -> Feature:
    """The same feature with Overture's tags under the names that OpenStreetMap has for them."""
    if OVERTURE.isdisjoint(feature.tags) and OVERTURE.isdisjoint(feature.blank):
        return feature
    tags = {AS_OPENSTREETMAP.get(key, key): value for key, value in feature.tags.items()}
    if tags.pop("is_underground", "no") == "yes":
        tags["location"] = "underground"
    return feature._replace(tags=tags)


def has_place_for_height(feature: Feature, height_key: str) -> bool:
    """Whether a feature has a key by which files of buildings are known, with a value or without."""
    keys = HEIGHTS | OVERTURE | {height_key}
    return not (keys.isdisjoint(feature.tags) and keys.isdisjoint(feature.blank))


def has_kind(feature: Feature) -> bool:
    """Whether tags say which kind of thing a feature is.

    A file in which none does, and some have a place for a height, is of buildings and nothing else. So are Overture's
    files, a cadastre's, and what people draw.
    """
    tags = feature.tags
    mapped = "building" in tags or "building:part" in tags or any(tagged(tags, kinds) for kinds in (TALL, WIRES, WOODS))
    return mapped or _is_flat(tags)


def why_passed_over(feature: Feature, extent: Extent, height_key: str, all_buildings: bool) -> Reason | None:
    """Why a feature, whose shape has such an extent, does not stand in the way; None if it does."""
    tags, areal = feature.tags, extent == "area"
    if extent == "none":
        return Reason("without a geometry", False)
    if _is_below(tags):
        return Reason("underground", False)
    values = [tags[key] for key in ("building", "building:part") if key in tags]
    if values:
        gone = all(value in NO_BUILDING for value in values)
        return Reason(f"tagged building={values[0]}", False) if gone else None
    if {height_key, TOP_AMSL, "building:levels"} & tags.keys() or tagged(tags, TALL):
        return None
    if tags.get("power") == "cable" and tags.get("location") not in OVERGROUND:
        return CABLE
    if tagged(tags, WIRES):
        return None
    if tagged(tags, WOODS):
        return WOOD
    if _is_flat(tags):
        return FLAT
    if areal and (all_buildings or (HEIGHTS | {height_key}) & feature.blank):
        return None
    unknown = "of a kind unknown" if tags.keys() - NAMING else "untagged"
    if areal:
        return Reason(f"an area {unknown}", True)
    return Reason(f"a point or line {unknown}", bool((HEIGHTS | {height_key}) & feature.blank))


def key_of_height(feature: Feature) -> str | None:
    """The key under [[maps]] that says how high a thing is of which the map does not say it; None for other things."""
    tags = feature.tags
    if {"height", TOP_AMSL, "building:levels", "building"} & tags.keys() or _is_below(tags):
        return None
    if tagged(tags, WIRES):
        return "aerialway_height" if tags.get("aerialway") in WIRES["aerialway"] else "line_height"
    return "wood_height" if tagged(tags, WOODS) else "point_height" if tagged(tags, TALL) else None


def tagged(tags: Mapping[str, str], kinds: Mapping[str, set[str]]) -> bool:
    """Whether the tags have one of the values of one of the keys; most have none of them."""
    return not kinds.keys().isdisjoint(tags) and any(tags.get(key) in values for key, values in kinds.items())


def extents_of(shapes: Sequence[Any]) -> list[Extent]:
    """Of each shape whether it has an area, or is the closed line round one; or is thin, or empty."""
    each = np.array(shapes, dtype=object)
    kinds = shapely.get_type_id(each)
    closed = shapely.is_closed(each) & (shapely.get_num_coordinates(each) > 3)
    areal = (kinds == shapely.GeometryType.POLYGON) | ((kinds == shapely.GeometryType.LINESTRING) & closed)
    for i in np.flatnonzero(kinds >= shapely.GeometryType.MULTIPOINT).tolist():
        areal[i] = _is_areal(each[i])
    named = np.where(shapely.is_empty(each), "none", np.where(areal, "area", "thin"))
    return cast(list[Extent], named.tolist())


def _is_areal(shape: Any) -> bool:
    """Whether something of a collection has an area, or is the closed line round one."""
    parts = [part for piece in shapely.get_parts(shape) for part in shapely.get_parts(piece)]
    return any(
        part.geom_type in ("Polygon", "MultiPolygon", "GeometryCollection")
        or (part.geom_type == "LineString" and part.is_closed and len(part.coords) > 3)
        for part in parts
    )


def _is_below(tags: Mapping[str, str]) -> bool:
    return tags.get("location") in ("underground", "underwater") or tags.get("tunnel", "no") != "no"


def _is_flat(tags: Mapping[str, str]) -> bool:
    on_the_ground = any(key in tags and tags[key] not in tall for key, tall in GROUNDS.items())
    return on_the_ground or tags.get("amenity") in FLAT_AMENITIES
