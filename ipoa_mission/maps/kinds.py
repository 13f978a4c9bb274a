"""Decide by tags whether a map feature is an obstacle."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import shapely

from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.keys import AMBIGUITY_MARK, CUT, CUT_BY_SHP_WRITE, Means, complete, keys_of, meaning, normalize
from ipoa_mission.maps.planar import close_as_polygon, simple_parts

Extent: TypeAlias = Literal["area", "thin", "none"]
NO_BUILDING = {"no", "entrance", "demolished", "razed", "proposed", "construction_site"}
TALL = {
    "man_made": {
        "antenna", "bell_tower", "campanile", "ceremonial_gate", "chimney", "column", "communications_tower",
        "cooling_tower", "crane", "cross", "flagpole", "flare", "gantry", "gasometer", "goods_conveyor", "kiln",
        "lamp_post", "lighthouse", "mast", "minaret", "monitoring_station", "monument", "obelisk",
        "observation_tower", "offshore_platform", "power_pole", "pylon", "radar", "satellite_dish", "silo",
        "ski_jump", "statue", "storage_tank", "stupa", "tank", "telescope", "torii", "tower", "utility_pole",
        "ventilation_shaft", "water_tank", "water_tower", "wind_turbine", "windmill", "windpump",
    },
    "natural": {"tree", "tree_row"},
    "power": {"catenary_mast", "pole", "portal", "terminal", "tower", "wind_turbine"},
    "generator:source": {"wind"},
    "generator:method": {"wind_turbine"},
    "aerialway": {"pylon"},
    "aeroway": {"navigationaid", "windsock"},
    "highway": {"street_lamp"},
    "historic": {"castle", "church", "city_gate", "monument", "obelisk", "tower"},
    "artwork_type": {"obelisk", "statue"},
    "attraction": {"big_wheel", "drop_tower", "roller_coaster"},
    "advertising": {"column", "totem"},
}  # fmt: skip
DRAG_LIFTS = {"drag_lift", "t-bar", "j-bar", "platter", "rope_tow"}
# A power cable is underground by default.
WIRES = {
    "power": {"line", "minor_line", "cable"},
    "aerialway": {"cable_car", "gondola", "mixed_lift", "chair_lift", "goods", "zip_line"} | DRAG_LIFTS,
    "communication": {"line"},
    "telecom": {"line"},
}
# Possible obstacles without a height.
WOODS = {"natural": {"wood"}, "landuse": {"forest", "orchard"}, "landcover": {"trees"}}
# Flat, except these values.
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
# Of building files, even if null.
OVERTURE = {"has_parts", "is_underground"}
TOP_AMSL = "height:amsl"


@dataclass(frozen=True)
class Reason:
    """`heights` are keys and values under [[maps]] that give it a height."""

    words: str
    may_be_obstacle: bool
    remedy: str = (
        'the map does not name its kind: under [[maps]], take = "all" makes it an obstacle (default_height); '
        'take = "tagged" excludes it'
    )
    heights: tuple[tuple[str, float], ...] = ()


CABLE = Reason(
    "a power cable that may hang or lie in the ground",
    True,
    "location=underground in the map excludes it; under [[maps]], line_height = 15 makes all power lines 15 m high",
    (("line_height", 15.0),),
)
WOOD = Reason(
    "a wood of unknown height",
    True,
    "under [[maps]], wood_height = 35 gives woods that height [m]; wood_height = 0 excludes them",
    (("wood_height", 35.0), ("wood_height", 0.0)),
)
FLAT = Reason("tagged as something flat", False)


_OTHER_KEYS = ("building", "building:part", "location", "tunnel", "bridge", "layer", "voltage", "barrier", "height")
# By their plain spelling; the long ones are cut to ten letters by a Shapefile.
_NAMES = {normalize(key): key for key in (
    *TALL, *WIRES, *WOODS, *OVERTURE, *_OTHER_KEYS,
    "building:levels", "building:height", "building:min_level", "building:min_height", "building:max_level",
    "roof:height", "roof:levels", "diameter_crown", "rotor:diameter", "tower:height", "measuredHeight",
    "storeysAboveGround", "restriction", "limitedApplicability", "lowerVerticalReference", "upperVerticalReference",
    TOP_AMSL,
)}  # fmt: skip
_KNOWN = frozenset(_OTHER_KEYS) | TALL.keys() | WIRES.keys() | WOODS.keys()
_MEASURES = (Means.TOP, Means.LEVELS, Means.MAX_LEVEL, Means.HUB, Means.ROTOR, Means.BLADE)
_OF_BUILDINGS = (*_MEASURES, Means.FOOT, Means.MIN_LEVEL, Means.ROOF, Means.ROOF_LEVELS)


def as_openstreetmap(feature: Feature) -> Feature:
    tags = feature.tags
    renamed = {key: named for key in tags if (named := _named(key)) != key and named not in tags}
    if not renamed and "is_underground" not in tags:
        return feature
    tags = {renamed.get(key, key): value for key, value in tags.items()}
    if tags.pop("is_underground", "no") == "yes":
        tags["location"] = "underground"
    return feature._replace(tags=tags)


@lru_cache(maxsize=65536)
def _named(key: str) -> str:
    for out_of_service in ("disused:", "abandoned:", "ruins:", "construction:", "was:"):
        key = key.removeprefix(out_of_service)
    return _NAMES.get(normalize(key), key)


def restore_key(key: str, value: str) -> str:
    """Complete a Shapefile's field, with `perhaps` if ambiguous."""
    is_unsure = meaning(key) in (Means.NOTHING, Means.AMBIGUOUS)
    if len(key) not in (CUT, CUT_BY_SHP_WRITE) or _named(key) in _KNOWN or not is_unsure:
        return key
    if len(key) != CUT:
        return complete(key)
    letters = normalize(key).replace("_", "")
    begins = (letters, re.sub(r"\d{1,2}$", "", letters))  # a second one ends in _1
    long_names = ((plain, name) for plain, name in _NAMES.items() if len(name) > CUT)
    names = [name for plain, name in long_names if plain.replace("_", "").startswith(begins)]
    of_kind = [name for name in names if value in TALL.get(name, ())]
    if of_kind or (len(names) == 1 and not key[-1].isdigit()):
        return (of_kind or names)[0]
    return f"{key} {AMBIGUITY_MARK}" if names else complete(key)


def has_place_for_height(feature: Feature, height_key: str) -> bool:
    """Find keys typical of building files, even without a value."""
    keys = {*feature.tags, *feature.blank}
    return not keys.isdisjoint(OVERTURE | {height_key}) or any(meaning(key) in _OF_BUILDINGS for key in keys)


def has_kind(feature: Feature) -> bool:
    """Return whether tags name the kind; files with heights only have buildings: Overture's, cadastres', drawings."""
    tags = feature.tags
    is_building = "building" in tags or "building:part" in tags
    return is_building or any(is_tagged(tags, kinds) for kinds in (TALL, WIRES, WOODS)) or _is_flat(tags)


def why_passed_over(feature: Feature, extent: Extent, height_key: str, all_buildings: bool) -> Reason | None:
    tags = feature.tags
    if extent == "none":
        return Reason("without a geometry", False)
    if tags.get("location") in ("underground", "underwater") or tags.get("tunnel", "no") != "no":
        return Reason("underground", False)
    values = [tags[key] for key in ("building", "building:part") if key in tags]
    if any(value not in NO_BUILDING for value in values) or is_tagged(tags, TALL) or is_bridge(tags):
        return None
    if values and not is_tagged(tags, WIRES):
        return Reason(f"tagged building={values[0]}", False)
    if {height_key, TOP_AMSL} & tags.keys() or keys_of(tags, *_MEASURES):
        return None
    if tags.get("power") == "cable" and tags.get("location") not in {"overground", "overhead", "kiosk", "roof"}:
        return CABLE
    if is_tagged(tags, WIRES):
        return None
    if is_tagged(tags, WOODS):
        return WOOD
    if _is_flat(tags):
        return FLAT
    has_blank = height_key in feature.blank or any(meaning(key) in _OF_BUILDINGS for key in feature.blank)
    if extent == "area" and (all_buildings or has_blank):
        return None
    names = {
        "name", "id", "@id", "osm_id", "osm_way_id", "fid", "ID", "FID", "OBJECTID", "Name", "Id", "description",
    }  # fmt: skip
    unknown = "of a kind unknown" if tags.keys() - names else "untagged"
    if extent == "area":
        return Reason(f"an area {unknown}", True)
    return Reason(f"a point or line {unknown}", has_blank or bool(keys_of(tags, Means.AMBIGUOUS)))


def is_tagged(tags: Mapping[str, str], kinds: Mapping[str, set[str]]) -> bool:
    if kinds.keys().isdisjoint(tags):
        return False
    return any(not values.isdisjoint(values_of(tags[key])) for key, values in kinds.items() if key in tags)


@lru_cache(maxsize=4096)
def values_of(text: str) -> tuple[str, ...]:
    return tuple(part.strip().lower() for part in text.split(";"))


def is_on_roof(tags: Mapping[str, str]) -> bool:
    return "building:part" not in tags and not {"roof", "rooftop"}.isdisjoint(values_of(tags.get("location", "")))


def is_bridge(tags: Mapping[str, str]) -> bool:
    no_bridge = {"no", "abandoned", "demolished", "removed", "proposed", "low_water_crossing", "boardwalk"}
    return tags.get("bridge", "no") not in no_bridge and not tags.keys().isdisjoint(("highway", "railway", "waterway"))


def extent_of(shape: Any) -> Extent:
    """A closed line is an area."""
    if shapely.is_empty(shape):
        return "none"
    parts = [close_as_polygon(part) for part in simple_parts(shape)]
    return "area" if any(part.geom_type == "Polygon" for part in parts) else "thin"


def _is_flat(tags: Mapping[str, str]) -> bool:
    on_the_ground = any(key in tags and tags[key] not in tall for key, tall in GROUNDS.items())
    return on_the_ground or tags.get("amenity") in {  # areas whose buildings are mapped separately
        "bench", "bicycle_parking", "clinic", "college", "fountain", "grave_yard", "hospital", "kindergarten",
        "marketplace", "parking", "parking_entrance", "parking_space", "place_of_worship", "school", "university",
        "waste_basket",
    }  # fmt: skip
