"""Read GeoJSON (RFC 7946), also one value a line; ED-269 and Overpass's JSON, too.

QGIS may name another `crs`.
"""

import json
import re
from itertools import chain
from pathlib import Path
from typing import Any

from pyproj import CRS
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, NoCoordinateSystem, WrongFormat
from ipoa_mission.files import read_text, reading
from ipoa_mission.maps.feature import EMPTY_SHAPE, Feature, read_all
from ipoa_mission.maps.geozones import ed269_features, is_ed269, layers_apart, limit_tags, zone_tags
from ipoa_mission.maps.json_shapes import SHAPES, ToDegrees, degrees_of, highest_of, shape_of, unchanged
from ipoa_mission.maps.osm import is_overpass, overpass_features
from ipoa_mission.maps.properties import feature_of_properties, tags_of

_NOT_BLANK = re.compile(r"[^ \t\n\r\x1e]")  # RFC 8142: \x1e


def read_geojson(path: Path) -> tuple[Feature, ...]:
    text = read_text(path)
    with reading(path, text):
        values = _values(text)
    if len(values) == 1:
        return _features_of(values[0], path, str(path))
    numbered = ((value, path, f"{path}: value {n}") for n, value in enumerate(values, 1))
    return tuple(chain.from_iterable(read_all(_features_of, numbered)))


def _values(text: str) -> list[Any]:
    decode = json.JSONDecoder().raw_decode
    values = list[Any]()
    index = _first(text, 0)
    while index < len(text) or not values:
        if values and text[index] != "{":
            raise json.JSONDecodeError("Extra data", text, index)
        value, end = decode(text, index)
        values.append(value)
        index = _first(text, end)
    return values


def _first(text: str, index: int) -> int:
    """Return the place of the next letter that is not blank."""
    match = _NOT_BLANK.search(text, index)
    return len(text) if match is None else match.start()


def _features_of(document: Any, path: Path, place: str) -> tuple[Feature, ...]:
    if is_ed269(document):
        return ed269_features(document, path)
    if is_overpass(document):
        return overpass_features(document, path)
    kind = document.get("type") if isinstance(document, dict) else None
    if kind == "FeatureCollection":
        features = document.get("features")
        if not isinstance(features, list):
            raise BadInput("expected a list", place=f"{place}: features")
        placed = [(f"{place}: features[{i}]{_number(feature)}", feature) for i, feature in enumerate(features)]
    elif kind == "Feature":
        placed = [(f"{place}: feature", document)]
    elif isinstance(kind, str) and kind in {*SHAPES, "GeometryCollection"}:
        placed = [(f"{place}: feature", {"type": "Feature", "geometry": document})]
    else:
        hint = "a map is GeoJSON (one value, or one a line) or Overpass's JSON; QGIS exports footprints of CityJSON"
        raise WrongFormat(f"expected 'FeatureCollection', not {kind!r:.40}", hint=hint, place=f"{place}: type")
    to_degrees = _coordinate_system(document.get("crs"), path)
    apart = ((place, part, to_degrees) for place, feature in placed for part in layers_apart(feature))
    return read_all(_feature, apart)


def _number(feature: Any) -> str:
    number = feature.get("id") if isinstance(feature, dict) else None
    return f" ({number})" if isinstance(number, str) and number else ""


def _feature(place: str, feature: Any, to_degrees: ToDegrees) -> Feature:
    if not isinstance(feature, dict) or feature.get("type") != "Feature":
        raise BadInput("expected a Feature", place=place)
    geometry = feature.get("geometry")
    properties = feature["properties"] if isinstance(feature.get("properties"), dict) else {}
    tags = dict(tags_of(properties)) | dict(zone_tags(properties))
    if isinstance(feature.get("id"), str | int):
        tags.setdefault("@id", str(feature["id"]))
    shape = EMPTY_SHAPE if geometry is None else shape_of(geometry, f"{place}.geometry", to_degrees)
    if isinstance(geometry, dict) and isinstance(geometry.get("layer"), dict):
        tags |= dict(limit_tags(geometry["layer"]))
    return feature_of_properties(place, shape, properties, tags, highest_of(geometry))


def _coordinate_system(crs: Any, path: Path) -> ToDegrees:
    """Read `crs` (GeoJSON of 2008, and QGIS)."""
    if crs is None:
        return unchanged
    try:
        return degrees_of(CRS.from_user_input(crs["properties"]["name"]))
    except (KeyError, TypeError, CRSError) as error:
        words = "expected the name of a coordinate system, such as 'EPSG:32633'"
        raise NoCoordinateSystem(words, place=f"{path}: crs") from error
