"""GeoJSON (RFC 7946) as OpenStreetMap's exports write it: Overpass turbo, osmtogeojson, QGIS.

They differ in where they keep the tags: beside each other in `properties`, under `properties.tags`, or, from GDAL's
OSM driver, as text in `properties.other_tags`. QGIS may write other coordinates than degrees, and says so in `crs`.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from sys import intern
from typing import Any

import numpy as np
import shapely
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.maps.cityjson import cityjson_features, is_cityjson
from ipoa_mission.maps.feature import (
    DEEPEST,
    Corners,
    Feature,
    Mistakes,
    many_objects,
    on_earth,
    positions_of,
    read_all,
)
from ipoa_mission.maps.geozones import circle, ed269_features, is_ed269, layer_tags
from ipoa_mission.maps.outlines import sound_polygons
from ipoa_mission.maps.streamed import Unstreamed, read_document

MOST_SHOWN = 80  # characters of a place
AT_ONCE = 1024  # features are made together
SHORT = 8  # values up to so many characters are kept once: "yes" stands in a map a hundred thousand times
HSTORE = re.compile(r'"((?:[^"\\]|\\.)*)"=>"((?:[^"\\]|\\.)*)"')


def read_geojson(path: Path) -> tuple[Feature, ...]:
    """The features of a FeatureCollection, of a single Feature, or of a bare geometry.

    Raises:
        BadInput: naming file and place, and what was expected there.
    """
    try:
        with many_objects():
            return _streamed(path)
    except json.JSONDecodeError as error:
        raise BadInput(f"{path}: line {error.lineno}: {error.msg[:1].lower()}{error.msg[1:]}") from error
    except RecursionError:
        raise BadInput(f"{path}: expected a map, not brackets nested without end") from None
    except ValueError:
        raise BadInput(f"{path}: expected numbers that fit in 64 bits, not one of thousands of digits") from None


def _streamed(path: Path) -> tuple[Feature, ...]:
    if path.is_fifo():  # which can be read only once
        return _whole(json.loads(read_text(path)), path)
    collection = _Collection(path)
    try:
        document = read_document(path, collection.add)
        if not isinstance(document, dict) or "features" not in document:
            return _whole(document, path)
        return collection.features(document)
    except Unstreamed:
        del collection
        return _whole(json.loads(read_text(path)), path)


class _Collection:
    """The features of a collection, made of so many at once as they come."""

    def __init__(self, path: Path) -> None:
        self._path, self._mistakes = path, Mistakes()
        self._made: list[Feature] = []
        self._waiting: list[tuple[str, Any]] = []
        self._crs: Any = None
        self._to_degrees: _Degrees | None = None

    def add(self, document: Mapping[str, Any], number: int, feature: Any) -> None:
        """Take the feature of this number; the document is what stands before it."""
        if self._to_degrees is None:
            self._crs, self._to_degrees = document.get("crs"), _coordinate_system(document, self._path)
        self._waiting.append((f"{self._path}: features[{number}]{_number(feature)}", feature))
        if len(self._waiting) == AT_ONCE:
            self._make(self._to_degrees)

    def features(self, document: Mapping[str, Any]) -> tuple[Feature, ...]:
        """All of them.

        Raises:
            BadInput: what is wrong with any.
            Unstreamed: the document is no collection, or names its coordinate system behind them.
        """
        if document.get("type") != "FeatureCollection" or (self._to_degrees and document.get("crs") != self._crs):
            raise Unstreamed
        self._make(self._to_degrees or _coordinate_system(document, self._path))
        self._mistakes.tell()
        return tuple(self._made)

    def _make(self, to_degrees: "_Degrees") -> None:
        drawn = sound_polygons([_rings(feature) for _, feature in self._waiting], to_degrees)
        for (place, feature), shape in zip(self._waiting, drawn, strict=True):
            made = self._mistakes.attempt(_feature, place, feature, to_degrees, shape)
            if made is not None:
                self._made.append(made)
        self._waiting.clear()


def _rings(feature: Any) -> Any:
    """What should be the rings of the polygon that a feature should be; None if it is something else."""
    geometry = feature.get("geometry") if isinstance(feature, dict) else None
    if isinstance(geometry, dict) and geometry.get("type") == "Polygon":
        return geometry.get("coordinates")
    return None


def _whole(document: Any, path: Path) -> tuple[Feature, ...]:
    if is_ed269(document):
        return ed269_features(document, path)
    if is_cityjson(document):
        return cityjson_features(document, path)
    kind = document.get("type") if isinstance(document, dict) else None
    if kind == "FeatureCollection":
        features = document.get("features")
        if not isinstance(features, list):
            raise BadInput(f"{path}: features: expected a list")
        placed = [(f"{path}: features[{i}]{_number(feature)}", feature) for i, feature in enumerate(features)]
    elif kind == "Feature":
        placed = [(f"{path}: feature", document)]
    elif isinstance(kind, str) and (kind == "GeometryCollection" or kind in SHAPES):
        placed = [(f"{path}: feature", {"type": "Feature", "geometry": document})]
    else:
        raise BadInput(f"{path}: type: expected 'FeatureCollection', not {kind!r:.40}", hint="a map is a GeoJSON file")
    to_degrees = _coordinate_system(document, path)
    return read_all(_feature, ((place, feature, to_degrees) for place, feature in placed))


def _number(feature: Any) -> str:
    """What OpenStreetMap calls a feature, in brackets, if the file says so."""
    number = feature.get("id") if isinstance(feature, dict) else None
    return f" ({number})" if isinstance(number, str) and number else ""


def _feature(place: str, feature: Any, to_degrees: "_Degrees", drawn: Any = None) -> Feature:
    """A feature, whose shape may be `drawn` already."""
    if not isinstance(feature, dict) or feature.get("type") != "Feature":
        raise BadInput(f"{place}: expected a Feature")
    geometry, properties = feature.get("geometry"), feature.get("properties")
    properties = properties if isinstance(properties, dict) else {}
    tags = {intern(key): value if len(value) > SHORT else intern(value) for key, value in tags_of(properties)}
    if isinstance(feature.get("id"), str | int):
        tags.setdefault("@id", str(feature["id"]))
    if drawn is not None:
        shape = drawn
    else:
        shape = shapely.GeometryCollection() if geometry is None else _shape(geometry, f"{place}.geometry", to_degrees)
    if isinstance(geometry, dict) and isinstance(geometry.get("layer"), dict):
        tags |= dict(layer_tags(geometry["layer"]))
    return Feature(place, shape, tags, frozenset(blank_keys(properties)))


def tags_of(properties: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Properties as tags; of those under `tags` and `other_tags` too. What has no value is left out."""
    for key, value in properties.items():
        if key == "tags" and isinstance(value, dict):
            yield from tags_of(value)
        elif key == "other_tags" and isinstance(value, str):
            yield from ((_unescaped(k), _unescaped(v)) for k, v in HSTORE.findall(value))
        elif key == "names" and isinstance(value, dict) and isinstance(value.get("primary"), str):
            yield "name", value["primary"]  # Overture's
        elif key == "limitedApplicability" and isinstance(value, list) and value:
            yield key, json.dumps(value)
        elif isinstance(value, bool):
            yield key, "yes" if value else "no"
        elif isinstance(value, str | int | float) and not _is_blank(value):
            yield key, str(value).strip()


def blank_keys(properties: Mapping[str, Any]) -> Iterator[str]:
    """Keys of the properties that have no value."""
    for key, value in properties.items():
        if key == "tags" and isinstance(value, dict):
            yield from blank_keys(value)
        elif _is_blank(value):
            yield key


def _is_blank(value: Any) -> bool:
    """Null, a text of nothing, or NaN, which is what pandas makes of them."""
    return value is None or (isinstance(value, str) and not value.strip()) or value != value


def _unescaped(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text)


def _shape(geometry: Any, place: str, to_degrees: "_Degrees", depth: int = 0) -> Any:
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if isinstance(geometry, dict) and kind == "GeometryCollection":
        members = geometry.get("geometries")
        if not isinstance(members, list):
            raise BadInput(f"{place}.geometries: expected a list")
        if depth >= DEEPEST:
            raise BadInput(f"{place[:MOST_SHOWN]}...: expected collections in no more than {DEEPEST} others")
        shapes = [_shape(member, f"{place}.geometries[{i}]", to_degrees, depth + 1) for i, member in enumerate(members)]
        return shapely.GeometryCollection(shapes)
    if not isinstance(geometry, dict) or not isinstance(kind, str) or kind not in SHAPES:
        raise BadInput(f"{place}.type: expected a kind of geometry, such as 'Polygon', not {kind!r}")
    extent = geometry.get("extent")
    if kind == "Point" and isinstance(extent, dict):  # ED-318
        return circle(geometry.get("coordinates"), extent.get("radius"), f"{place}.extent")
    return SHAPES[kind](geometry.get("coordinates"), f"{place}.coordinates", to_degrees)


def _corners(values: Any, place: str, to_degrees: "_Degrees") -> Corners:
    return on_earth(to_degrees(positions_of(values, place)), place)


def _point(values: Any, place: str, to_degrees: "_Degrees") -> Any:
    return shapely.Point(_corners([values], place, to_degrees)[0])


def _line(values: Any, place: str, to_degrees: "_Degrees") -> Any:
    corners = _corners(values, place, to_degrees)
    if len(corners) < 2:
        raise BadInput(f"{place}: expected 2 positions or more, not {len(corners)}")
    return shapely.LineString(corners)


def _polygon(values: Any, place: str, to_degrees: "_Degrees") -> Any:
    if not isinstance(values, list) or not values:
        raise BadInput(f"{place}: expected a list of rings")
    rings = []
    for i, ring in enumerate(values):
        corners = _corners(ring, f"{place}[{i}]", to_degrees)
        if len({tuple(corner) for corner in corners.tolist()}) < 3:
            raise BadInput(f"{place}[{i}]: expected a ring of 3 different corners or more")
        rings.append(corners)
    return shapely.Polygon(rings[0], rings[1:])


def _several(one: "_Reader", whole: Any) -> "_Reader":
    def read(values: Any, place: str, to_degrees: "_Degrees") -> Any:
        if not isinstance(values, list):
            raise BadInput(f"{place}: expected a list")
        return whole([one(value, f"{place}[{i}]", to_degrees) for i, value in enumerate(values)])

    return read


_Degrees = Callable[[Corners], Corners]
_Reader = Callable[[Any, str, _Degrees], Any]

SHAPES: Mapping[str, _Reader] = {
    "Point": _point,
    "MultiPoint": _several(_point, shapely.MultiPoint),
    "LineString": _line,
    "MultiLineString": _several(_line, shapely.MultiLineString),
    "Polygon": _polygon,
    "MultiPolygon": _several(_polygon, shapely.MultiPolygon),
}


def _coordinate_system(document: Mapping[str, Any], path: Path) -> _Degrees:
    """How to turn the file's coordinates into longitude and latitude: its `crs` member (GeoJSON of 2008, and QGIS)."""
    if document.get("crs") is None:
        return lambda corners: corners
    try:
        name = document["crs"]["properties"]["name"]
        system = CRS.from_user_input(name)
    except (KeyError, TypeError, CRSError) as error:
        raise BadInput(f"{path}: crs: expected the name of a coordinate system, such as 'EPSG:32633'") from error
    if system.is_geographic and system.ellipsoid is not None and "WGS 84" in system.ellipsoid.name:
        return lambda corners: corners
    convert = Transformer.from_crs(system, "OGC:CRS84", always_xy=True)
    return lambda corners: np.column_stack(convert.transform(*corners.T))
