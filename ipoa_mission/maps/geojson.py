"""Read GeoJSON (RFC 7946), also one value a line.

Tags may be in `properties.tags`, or `properties.other_tags` (GDAL). QGIS may name another `crs`.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, InvalidRing, NoCoordinateSystem, TooLarge, WrongFormat
from ipoa_mission.files import why_no_json
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
from ipoa_mission.maps.geozones import circle, ed269_features, is_ed269, layer_tags, layers_apart, zone_tags
from ipoa_mission.maps.osm import is_overpass, overpass_features
from ipoa_mission.maps.properties import blank_keys, tags_of, truncated
from ipoa_mission.maps.streamed import Unstreamed, read_document, read_values


def sound_polygons(rings_of: Sequence[Any], to_degrees: Callable[[Corners], Corners]) -> list[Any]:
    """Build many polygons at once; None (no rings, repeated first corners, or not on Earth) needs a separate check."""
    made: list[Any] = [None] * len(rings_of)
    taken = [i for i, rings in enumerate(rings_of) if _looks_sound(rings)]
    rings = [ring for i in taken for ring in rings_of[i]]
    if not rings:
        return made
    try:
        of_position = set(map(len, chain.from_iterable(rings)))  # some may have a height
        numbers = np.fromiter(chain.from_iterable(chain.from_iterable(rings)), float)
    except (TypeError, ValueError, KeyError, OverflowError):
        return made
    if len(of_position) != 1 or min(of_position) < 2:
        return made
    corners = numbers.reshape(-1, min(of_position))[:, :2]
    if not np.isfinite(corners).all():
        return made
    corners = to_degrees(corners)
    lengths = np.array([len(ring) for ring in rings])
    first = np.cumsum(lengths) - lengths
    a, b, c = corners[first], corners[first + 1], corners[first + 2]
    sound = (a != b).any(axis=1) & (b != c).any(axis=1) & (a != c).any(axis=1)
    sound &= np.logical_and.reduceat((np.abs(corners) <= (360.0, 90.0)).all(axis=1), first)
    owner = np.repeat(np.arange(len(taken)), [len(rings_of[i]) for i in taken])
    whole = np.bincount(owner[~sound], minlength=len(taken)) == 0
    kept = whole[owner]
    of_ring = np.repeat(np.arange(int(kept.sum())), lengths[kept])
    lines = shapely.linearrings(corners[np.repeat(kept, lengths)], indices=of_ring)
    number = np.cumsum(whole) - 1
    polygons = shapely.polygons(lines, indices=number[owner[kept]])
    for i, polygon in zip(np.flatnonzero(whole).tolist(), polygons.tolist(), strict=True):
        made[taken[i]] = polygon
    return made


def _looks_sound(rings: Any) -> bool:
    return isinstance(rings, list) and bool(rings) and all(isinstance(ring, list) and len(ring) > 2 for ring in rings)


BATCH = 1024
SHAPES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
Take = Callable[[Sequence[Feature]], object]
_Degrees = Callable[[Corners], Corners]


def read_geojson(path: Path, begin: Callable[[], Take]) -> None:
    """Pass on features in batches; `begin` is called again if reading restarts."""
    try:
        _hand_on(path, begin)
    except RecursionError:
        raise TooLarge("expected a map, not endlessly nested brackets", place=path) from None


@many_objects()
def _hand_on(path: Path, begin: Callable[[], Take]) -> None:
    document: dict[str, Any] = {}
    if not path.is_fifo():  # a FIFO can be read only once
        with suppress(Unstreamed):
            if _Collection(path, begin()).read(document) or _Collection(path, begin(), document).read({}):
                return
    values = read_values(path)
    with _json_errors_named(path):
        first, second = next(values), next(values, None)
    if second is None:
        begin()(_whole(first, path))
    else:
        _hand_on_each(path, chain((first, second), values), begin())


def _hand_on_each(path: Path, values: Iterator[Any], take: Take) -> None:
    """Read GeoJSONSeq, RFC 8142."""
    mistakes, features, end = Mistakes(), list[Feature](), object()
    for number in count(1):
        with _json_errors_named(path):
            value: Any = next(values, end)
        if value is end:
            break
        features += mistakes.attempt(_whole, value, path, f"{path}: value {number}") or ()
        if len(features) >= BATCH:
            take(features)
            features = []
    mistakes.raise_all()
    if features:
        take(features)


@contextmanager
def _json_errors_named(path: Path) -> Iterator[None]:
    try:
        yield
    except json.JSONDecodeError as error:
        words, place = f"{error.msg[:1].lower()}{error.msg[1:]}", f"{path}: line {error.lineno}"
        raise WrongFormat(words, hint=why_no_json(error.doc, error.pos), place=place) from error
    except ValueError:
        raise TooLarge("expected numbers that fit in 64 bits, not one of thousands of digits", place=path) from None


class _Collection:
    def __init__(self, path: Path, take: Take, document: Mapping[str, Any] | None = None) -> None:
        self._path, self._take, self._mistakes = path, take, Mistakes()
        self._waiting: list[tuple[str, Any]] = []
        self._document = document
        self._to_degrees: _Degrees | None = None

    def read(self, document: dict[str, Any]) -> bool:
        """Return whether the coordinate system was known from the first feature on, or raise Unstreamed."""
        pieces = read_document(self._path, document)
        while True:
            with _json_errors_named(self._path):  # not around `_add`
                number, features = next(pieces, (0, None))
            if features is None:
                break
            self._add(document, number, features)
        if document.get("type") != "FeatureCollection" or "features" not in document:
            raise Unstreamed
        if self._document is not None and document.get("crs") != self._document.get("crs"):
            return False
        self._make(self._to_degrees or _coordinate_system(document, self._path))
        self._mistakes.raise_all()
        return True

    def _add(self, before: Mapping[str, Any], number: int, features: list[Any]) -> None:
        if self._to_degrees is None:
            self._document = dict(before) if self._document is None else self._document
            self._to_degrees = _coordinate_system(self._document, self._path)
        self._waiting += [
            (f"{self._path}: features[{i}]{_number(feature)}", part)
            for i, feature in enumerate(features, number)
            for part in layers_apart(feature)
        ]
        if len(self._waiting) >= BATCH:
            self._make(self._to_degrees)

    def _make(self, to_degrees: _Degrees) -> None:
        drawn = sound_polygons([_rings(feature) for _, feature in self._waiting], to_degrees)
        made = [
            self._mistakes.attempt(_feature, place, feature, to_degrees, shape)
            for (place, feature), shape in zip(self._waiting, drawn, strict=True)
        ]
        self._waiting.clear()
        if features := [feature for feature in made if feature is not None]:
            self._take(features)


def _rings(feature: Any) -> Any:
    geometry = feature.get("geometry") if isinstance(feature, dict) else None
    if not isinstance(geometry, dict) or geometry.get("type") != "Polygon":
        return None
    return geometry.get("coordinates")


def _whole(document: Any, path: Path, place: str = "") -> tuple[Feature, ...]:
    if is_ed269(document):
        return ed269_features(document, path)
    if is_overpass(document):
        return overpass_features(document, path)
    place = place or str(path)
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
        cityjson = (
            "CityJSON is not read: export footprints with a `height` [m] as GeoJSON or GeoPackage, for example with "
            "QGIS; cjio writes neither"
        )
        usual = "a map is GeoJSON (one value, or one a line) or Overpass's JSON"
        hint = cityjson if str(kind).startswith("CityJSON") else usual
        raise WrongFormat(f"expected 'FeatureCollection', not {kind!r:.40}", hint=hint, place=f"{place}: type")
    to_degrees = _coordinate_system(document, path)
    apart = ((place, part) for place, feature in placed for part in layers_apart(feature))
    return read_all(_feature, ((place, feature, to_degrees) for place, feature in apart))


def _number(feature: Any) -> str:
    number = feature.get("id") if isinstance(feature, dict) else None
    return f" ({number})" if isinstance(number, str) and number else ""


def _feature(place: str, feature: Any, to_degrees: _Degrees, drawn: Any = None) -> Feature:
    if not isinstance(feature, dict) or feature.get("type") != "Feature":
        raise BadInput("expected a Feature", place=place)
    geometry, properties = feature.get("geometry"), feature.get("properties")
    properties = properties if isinstance(properties, dict) else {}
    tags = dict(tags_of(properties)) | dict(zone_tags(properties))
    if isinstance(feature.get("id"), str | int):
        tags.setdefault("@id", str(feature["id"]))
    shape = shapely.GeometryCollection() if drawn is None else drawn
    if drawn is None and geometry is not None:
        shape = _shape(geometry, f"{place}.geometry", to_degrees)
    if isinstance(geometry, dict) and isinstance(geometry.get("layer"), dict):
        tags |= dict(layer_tags(geometry["layer"]))
    return Feature(place, shape, tags, frozenset(blank_keys(properties)), truncated(properties, shape))


def _shape(geometry: Any, place: str, to_degrees: _Degrees, depth: int = 0) -> Any:
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if isinstance(geometry, dict) and kind == "GeometryCollection":
        members = geometry.get("geometries")
        if not isinstance(members, list):
            raise BadInput("expected a list", place=f"{place}.geometries")
        if depth >= DEEPEST:
            raise TooLarge(f"expected collections in no more than {DEEPEST} others", place=f"{place[:80]}...")
        shapes = [_shape(member, f"{place}.geometries[{i}]", to_degrees, depth + 1) for i, member in enumerate(members)]
        return shapely.GeometryCollection(shapes)
    if not isinstance(geometry, dict) or not isinstance(kind, str) or kind not in SHAPES:
        raise BadInput(f"expected a kind of geometry, such as 'Polygon', not {kind!r}", place=f"{place}.type")
    extent = geometry.get("extent")
    if kind == "Point" and isinstance(extent, dict):  # ED-318
        return circle(geometry.get("coordinates"), extent.get("radius"), f"{place}.extent")
    values, place = geometry.get("coordinates"), f"{place}.coordinates"
    if not kind.startswith("Multi"):
        return _part(kind, values, place, to_degrees)
    if not isinstance(values, list):
        raise BadInput("expected a list", place=place)
    parts = [_part(kind.removeprefix("Multi"), value, f"{place}[{i}]", to_degrees) for i, value in enumerate(values)]
    return getattr(shapely, kind)(parts)


def _part(kind: str, values: Any, place: str, to_degrees: _Degrees) -> Any:
    def corners_of(positions: Any, place: str) -> Corners:
        return on_earth(to_degrees(positions_of(positions, place)), place)

    if kind == "Point":
        return shapely.Point(corners_of([values], place)[0])
    if kind == "LineString":
        corners = corners_of(values, place)
        if len(corners) < 2:
            raise InvalidRing(f"expected 2 positions or more, not {len(corners)}", place=place)
        return shapely.LineString(corners)
    if not isinstance(values, list) or not values:
        raise InvalidRing("expected a list of rings", place=place)
    rings = []
    for i, ring in enumerate(values):
        rings.append(corners_of(ring, f"{place}[{i}]"))
        if len(np.unique(rings[-1], axis=0)) < 3:
            raise InvalidRing("expected a ring of 3 different corners or more", place=f"{place}[{i}]")
    return shapely.Polygon(rings[0], rings[1:])


def _coordinate_system(document: Mapping[str, Any], path: Path) -> _Degrees:
    """Read `crs` (GeoJSON of 2008, and QGIS)."""
    if document.get("crs") is None:
        return lambda corners: corners
    try:
        system = CRS.from_user_input(document["crs"]["properties"]["name"])
    except (KeyError, TypeError, CRSError) as error:
        words = "expected the name of a coordinate system, such as 'EPSG:32633'"
        raise NoCoordinateSystem(words, place=f"{path}: crs") from error
    return degrees_of(system)


def degrees_of(system: CRS) -> _Degrees:
    if system.is_geographic and system.ellipsoid is not None and "WGS 84" in system.ellipsoid.name:
        return lambda corners: corners
    convert = Transformer.from_crs(system, "OGC:CRS84", always_xy=True)
    return lambda corners: np.column_stack(convert.transform(*corners.T))
