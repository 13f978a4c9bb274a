import math
from collections.abc import Mapping
from typing import Any

import shapely

from ipoa_mission.maps.feature import Feature, printed

KINDS = ("building", "man_made", "aerialway", "barrier", "power", "natural", "landuse")
WORDS = {("natural", "tree_row"): "row of trees", ("power", "tower"): "power tower", ("power", "pole"): "power pole"}


def called(feature: Feature, shape: Any) -> str:
    """Name a feature for a pilot: by name or address, else by kind, position and number; `shape` is east, north [m].

    >>> called(Feature("town.geojson: features[3]", None, {"natural": "tree"}), shapely.Point(30.0, 30.0))
    'tree 42 m NE of home (features[3])'
    """
    tags, kind = feature.tags, _kind(feature.tags)
    if tags.get("name") or tags.get("addr:housename"):
        return feature.name
    street, number = tags.get("addr:street"), tags.get("addr:housenumber")
    if "building" in tags and street and number:
        return printed(f"{kind}, {street} {number}")
    return printed(f"{kind}{_from_home(shape)} ({feature.name.rpartition(': ')[2]})")


def _from_home(shape: Any) -> str:
    if shapely.is_empty(shape) or shapely.get_dimensions(shape) == 1:
        return ""
    east, north = shape.centroid.coords[0]
    side = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")[round(math.atan2(east, north) / (math.pi / 4)) % 8]
    return f" {math.hypot(east, north):.0f} m {side} of home"


def _kind(tags: Mapping[str, str]) -> str:
    if tags.get("power", "").endswith("line") or tags.get("power") == "cable":
        volts = [int(each) for each in tags.get("voltage", "").split(";") if each.isdecimal()]
        return f"{max(volts) / 1000:g} kV line" if volts else "power line"
    if tags.get("generator:source") == "wind":
        return "wind turbine"
    values = ((key, tags[key]) for key in KINDS if tags.get(key) not in (None, "", "yes", "no"))
    return next((WORDS.get(each, each[1].replace("_", " ")) for each in values), "building")
